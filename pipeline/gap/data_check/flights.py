"""Flights between contacts, and bounces, of tracks in m and s."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.segmentation.contacts import Contact
from rallygap.models.segmentation.cuts import Cuts, cut
from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.pipeline.gap.data_check.fall import parabola
from rallygap.pipeline.gap.data_check.tracks import Track
from rallygap.pipeline.gap.noise import coordinate_noise

FEWEST_SAMPLES = 10  # of a flight
PARABOLA_ERROR = np.sqrt(720.0)  # of an acceleration over n samples in T: noise * this / (T^2 n^.5)


@dataclass(frozen=True)
class Flights:
    """Labelled flights between contacts, and contacts.

    Attributes:
        velocities: (n, 3) m/s, at the middle of each flight.
        accelerations: (n, 3) m/s^2.
        errors: (n,) m/s^2, standard error of a component of the acceleration.
        spins: (n, 3) rad/s, mean label.
        contacts: breaks of the path, of whatever surface.
    """

    velocities: Floats
    accelerations: Floats
    errors: Floats
    spins: Floats
    contacts: tuple[Contact, ...]

    @property
    def spin_sizes(self) -> Floats:
        """(n,) rad/s."""
        return np.asarray(np.linalg.norm(self.spins, axis=1))

    def turned(self, axes: Floats) -> "Flights":
        """Return the flights with all vectors multiplied by a (3, 3) matrix, without contacts."""
        vectors = [part @ axes.T for part in (self.velocities, self.accelerations, self.spins)]
        return Flights(vectors[0], vectors[1], self.errors, vectors[2], ())


def flights_of(tracks: Sequence[Track]) -> Flights:
    """Cut tracks at their contacts."""
    settings = SegmentSettings(noise=coordinate_noise([track.positions for track in tracks]))
    rows: list[Floats] = []
    contacts: list[Contact] = []
    for track in tracks:
        cuts = cut(track.times, np.ascontiguousarray(track.positions), settings)
        rows += _labelled(track, cuts, settings.noise)
        contacts += cuts.contacts.values()
    table = np.array(rows).reshape(-1, 10)
    return Flights(table[:, :3], table[:, 3:6], table[:, 6], table[:, 7:], tuple(contacts))


def _labelled(track: Track, cuts: Cuts, noise: float) -> Iterator[Any]:
    """Yield velocity, acceleration, its error and mean label (10,) of flights with a label."""
    for number in range(cuts.flights):
        rows = np.flatnonzero((cuts.flight == number) & ~cuts.outlier)
        labels = track.spins[rows][np.isfinite(track.spins[rows]).all(axis=1)]
        if len(rows) >= FEWEST_SAMPLES and len(labels):
            times = track.times[rows]
            velocity, acceleration, _ = parabola(times, track.positions[rows])
            error = PARABOLA_ERROR * noise / np.ptp(times) ** 2 / np.sqrt(len(rows))
            yield [*velocity, *acceleration, error, *labels.mean(axis=0)]
