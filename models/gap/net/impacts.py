"""Impacts: how fast balls meet the face of the net and leave it, by the arcs before and after."""

from dataclasses import dataclass, fields

import numpy as np

from rallygap.models.ball.contact_laws import NET
from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import NET_HEIGHT, STATE_SIZE, VELOCITY
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.measurement import Schedule, predict_measurements
from rallygap.models.gap.fit.noise import Noise
from rallygap.models.gap.fit.refit import RefitResult, fit_nuisance
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.net.contacts import NetContacts
from rallygap.models.gap.settings import GapSettings

ANY_NET = {"restitution": 0.0, "friction": 0.0}  # where balls meet it does not depend on its law
ACROSS, UP = 1, 2  # axes: towards the net, and height


@dataclass(frozen=True)
class Impacts:
    """D impacts on the face of the net.

    Attributes:
        launches: (D, 9) states from which balls reach the net.
        spans: (D,) s in which they do.
        after: (D, 3) m/s measured velocities just after.
        speeds: (D,) m/s towards the net, just before.
        variances: (D,) (m/s)^2 of a component of the velocities, before and after together.
        paths: (D) measured arcs after the net.
        starts: (D,) s from the launch to the first sample of these.
    """

    launches: Floats
    spans: Floats
    after: Floats
    speeds: Floats
    variances: Floats
    paths: Shots
    starts: Floats

    def __len__(self) -> int:
        return len(self.launches)

    @classmethod
    def of(
        cls, contacts: NetContacts, simulator: Simulator, noise: Noise, settings: GapSettings
    ) -> "Impacts":
        """Return the impacts among contacts: those whose arc before meets the face of the net.

        At the cord the direction of the impulse depends on millimetres; such contacts, and those of
        arcs that do not reach the net, are left out.

        Args:
            contacts: measured, without the position-dependent camera error.
            simulator: that explains the flights.
            noise: of the measurements.
            settings: of the workflow.
        """
        fits = [
            fit_nuisance(arcs, simulator, noise, settings.fit)
            for arcs in (contacts.before, contacts.after)
        ]
        launches, starts = (fit.linear.nuisance[:, :STATE_SIZE] for fit in fits)
        gaps = contacts.after.times[:, 0] - contacts.before.times[:, 0]
        spans = gaps + settings.net.latest
        moments, before, _ = _first_contacts(simulator.amended("net", **ANY_NET), launches, spans)
        face = np.isfinite(moments) & (before[:, UP] < NET_HEIGHT)
        since = np.where(face, moments - gaps, 0.0)[:, None]
        after = simulator.without_surfaces().fly(starts, since).states[:, 0, VELOCITY]
        variances = _velocity_variances(fits[0]) + _velocity_variances(fits[1])
        speeds = np.abs(before[:, VELOCITY][:, ACROSS])
        known = face & (variances < (settings.net.largest_error * speeds) ** 2)
        found = cls(launches, spans, after, speeds, variances, contacts.after, gaps)
        return cls(*(getattr(found, field.name)[known] for field in fields(cls)))

    def velocities(self, simulator: Simulator) -> Floats:
        """Return (D, 3) velocities, m/s, at which balls leave the net of a simulator.

        Without a net they are those at which balls pass through its place.
        """
        there = "net" in simulator.effects
        net = simulator if there else simulator.amended("net", **ANY_NET)
        _, before, after = _first_contacts(net, self.launches, self.spans)
        velocities: Floats = (after if there else before)[:, VELOCITY]
        return velocities

    def squares(self, simulator: Simulator, settings: GapSettings) -> Floats:
        """Return (D, 1) mean square errors, m^2, of predictions of the paths after the net.

        They start from the state before it, and end at the horizon of the settings.
        """
        since = self.paths.times - self.paths.times[:, :1]
        schedule = Schedule.of_times(self.starts[:, None] + since)
        places = predict_measurements(simulator, schedule, self.launches).positions
        used = self.paths.valid & (since <= settings.net.horizon)
        squares = np.where(used, ((places - self.paths.positions) ** 2).sum(axis=2), 0.0)
        means: Floats = squares.sum(axis=1, keepdims=True) / used.sum(axis=1, keepdims=True)
        return means


def _first_contacts(
    simulator: Simulator, launches: Floats, spans: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return (D,) times of the first contacts, s, and (D, 9) states just before and just after.

    They are NaN where it is not with the net.
    """
    contacts = simulator.fly(launches, spans[:, None]).contacts
    met = contacts.surface[:, 0] == NET
    moments = np.where(met, contacts.time[:, 0], np.nan)
    before = np.where(met[:, None], contacts.before[:, 0], np.nan)
    after = np.where(met[:, None], contacts.after[:, 0], np.nan)
    return moments, before, after


def _velocity_variances(fit: RefitResult) -> Floats:
    """Return (D,) variances of a component of the fitted velocities, (m/s)^2."""
    count = fit.linear.nuisance_count
    covariance = np.linalg.inv(fit.noise_estimate.gram_matrices[:, :count, :count])
    variances: Floats = np.einsum("bii->bi", covariance)[:, VELOCITY].mean(axis=1)
    return variances
