"""Drift: the physics changes during a session, so that the simulator no longer holds.

Every shot is fitted on its own about the simulator, in the noise that reference shots have. Its
efficient score about a parameter of the catalogue, and its information, say what the value is that
the shot shows (gap/fit/projection.py). Where the value changes, that of the latest shots departs
from that of the reference. For each parameter and for windows of several lengths, the difference is
compared with its standard error (a generalised likelihood ratio in a window, Lai 1995). What the
simulator gets wrong in reference and window alike cancels.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.projection import eliminate_nuisance
from rallygap.models.gap.fit.refit import RefitResult, fit_nuisance, refit
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.inference.score_test import Evidence
from rallygap.models.gap.settings import DEFAULTS, GapSettings

REFERENCE = 100  # shots, at least as many as most windows have
WINDOWS = (5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160)  # lengths, in shots
# Standard errors from which a difference is an alarm. In 20,000 quiet shots 5.06 was the largest;
# experiments/benchmarks/drift.py counts false alarms in other sessions.
THRESHOLD = 5.4
LARGEST = 6.0  # standard deviations; a shot's score counts as no larger
TINY = 1e-12  # information of a shot that does not show a parameter

Shot = tuple[Floats, Floats, Floats]  # (N,) times, (N, 3) positions and spins, NaN without one


@dataclass(frozen=True)
class Alarm:
    """A parameter whose value has changed.

    Attributes:
        hypothesis: the parameter whose change explains the shots best.
        change: of its value since the reference.
        error: of the change, its standard error.
        shots: the length of the window that shows it.
        possible: parameters whose change explains them about as well, the most likely first.
    """

    hypothesis: Hypothesis
    change: float
    error: float
    shots: int
    possible: tuple[Hypothesis, ...]


class DriftMonitor:
    """Watches shot after shot for a change of the world.

    Args:
        reference: shots before any change.
        simulator: of the ball.
        settings: of the gap workflow.

    Attributes:
        parameters: K of the catalogue that are watched, those that the reference can show.
    """

    def __init__(
        self, reference: Shots, simulator: Simulator, settings: GapSettings = DEFAULTS
    ) -> None:
        self._simulator, self._settings = simulator, settings
        fit = refit(reference, simulator, (), settings.fit)
        self._noise = fit.noise_estimate.noise
        evidence = Evidence.of(fit.linear, fit.noise_estimate, settings)
        self._places = list(evidence.decidable(()))
        self.parameters = tuple(evidence.columns[k] for k in self._places)
        scores, information = self._scores(fit)
        self._information = information.sum(axis=0)
        self._value = scores.sum(axis=0) / self._information  # less the simulator's
        departures = (scores - information * self._value) / np.sqrt(information)
        # What differs between shots beyond the noise, such as players, must not pass for a change.
        self._excess = np.maximum(departures.std(axis=0), 1.0)
        # Of the latest shots: scores, the same limited, and information.
        self._latest = np.empty((0, 3, len(self._places)))

    def add(self, shots: Shots) -> list[Alarm | None]:
        """Take the next shots, in their order; return the alarm at each of them, if any."""
        fit = fit_nuisance(shots, self._simulator, self._noise, self._settings.fit)
        return [self._add(*shot) for shot in zip(*self._scores(fit), strict=True)]

    def _scores(self, fit: RefitResult) -> tuple[Floats, Floats]:
        """Return (B, K) efficient scores of fitted shots and their information, each alone."""
        system = eliminate_nuisance(fit.noise_estimate.gram_matrices, fit.linear.nuisance_count)
        information = np.einsum("bkk->bk", system.information)[:, self._places]
        return system.scores[:, self._places], np.maximum(information, TINY)

    def _add(self, scores: Floats, information: Floats) -> Alarm | None:
        """Take the (K,) scores of a shot and their information."""
        scores = scores - information * self._value
        most = LARGEST * self._excess * np.sqrt(information)
        row = np.stack([scores, np.clip(scores, -most, most), information])[None]
        self._latest = np.concatenate([self._latest[1 - WINDOWS[-1] :], row])
        windows = [length for length in WINDOWS if length <= len(self._latest)]
        if not windows:
            return None
        sums = np.cumsum(self._latest[::-1], axis=0)[np.array(windows) - 1]
        seen, limited, known = np.moveaxis(sums, 1, 0)  # each (W, K)
        errors = self._excess * np.sqrt(1 / known + 1 / self._information)
        # Limited scores decide whether there is an alarm, and in which window: no shot decides
        # alone. The scores themselves decide which parameter it is.
        largest = np.abs(limited / known / errors).max(axis=1)
        w = int(largest.argmax())
        if largest[w] < THRESHOLD:
            return None
        changes = seen[w] / known[w]
        gains = (changes / errors[w]) ** 2
        likeliest = np.argsort(-gains).tolist()
        k = likeliest[0]
        close = (j for j in likeliest if gains[j] > gains[k] - self._settings.tolerance)
        return Alarm(
            self.parameters[k],
            float(changes[k]),
            float(errors[w, k]),
            windows[w],
            tuple(self.parameters[j] for j in close),
        )


class Session:
    """Watches a session: its first shots are the reference.

    Args:
        simulator: of the ball.
        reference: how many shots.
    """

    def __init__(self, simulator: Simulator, reference: int = REFERENCE) -> None:
        self._simulator, self._count = simulator, reference
        self._reference: list[Shot] = []
        self._monitor: DriftMonitor | None = None

    def add(self, shot: Shot) -> Alarm | None:
        """Take the next shot; return the alarm that it raises. An implausible shot is left out."""
        try:
            if self._monitor is not None:
                return self._monitor.add(_shots([shot]))[0]
            self._reference.append(shot)
            if len(self._reference) == self._count:
                self._monitor = DriftMonitor(_shots(self._reference), self._simulator)
        except (ValueError, np.linalg.LinAlgError):  # implausible places, or paths of no ball
            del self._reference[-1:]
        return None


def _shots(parts: Sequence[Shot]) -> Shots:
    return Shots.from_arrays(*zip(*parts, strict=True))
