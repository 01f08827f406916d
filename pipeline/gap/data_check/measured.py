"""What raw recordings measured: samples, how the ball falls, flights, contacts and bounces.

Nothing here assumes that units, axes and origin are right, but for what says so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.shots import spread_evenly
from rallygap.models.segmentation.contacts import Contact
from rallygap.models.segmentation.cuts import Cuts, cut
from rallygap.models.segmentation.settings import SegmentSettings
from rallygap.pipeline.io.frame import Frame
from rallygap.pipeline.io.schemas import POSITION_COLUMNS, SPIN_COLUMNS
from rallygap.pipeline.sources.source import SAMPLE_COLUMNS, RawTable

MOST_TRACKS = 150  # recordings that are checked, spread evenly over all
FEWEST_SAMPLES = 8  # of a track
# s between two samples; beyond these limits no ball can be followed.
SHORTEST_STEP, LONGEST_STEP = 1e-5, 0.2

DIFFERENCE = np.sqrt(20.0)  # standard deviation of a third difference, in those of its samples
TO_DEVIATION = 1.4826  # from the median size of an error to its standard deviation
LARGEST_NOISE = 0.05  # m, beyond which nothing can be cut

WINDOW = 0.12  # s
FEWEST_IN_WINDOW = 6  # samples
FEWEST_WINDOWS = 5
KINK = 1.5  # residual, in the median of all windows, above which the ball touched something
RESTING = 0.1  # of a fast ball's speed, below which it lies or is held
ROUNDS = 10  # of the robust fit
RIDGE = 1e-3  # keeps it finite where all balls fly the same way

FEWEST_IN_FLIGHT = 10  # samples
PARABOLA_ERROR = np.sqrt(720.0)  # of an acceleration over n samples in T: noise * this / (T^2 n^.5)
SLOWEST_BOUNCE = 0.5  # m/s towards and away from the surface
MOST_GAIN = 0.5  # m/s of speed, more is a racket
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Track:
    """The samples of one recording, before any of them is refused as implausible.

    Attributes:
        times: (n,) s, rising.
        positions: (n, 3) m.
        spins: (n, 3) rad/s, NaN where there is no label.
    """

    times: Floats
    positions: Floats
    spins: Floats

    @property
    def speed(self) -> float:
        """Median speed over several samples, m/s."""
        lag = max(len(self.times) // 10, 1)
        steps = np.linalg.norm(self.positions[lag:] - self.positions[:-lag], axis=1)
        return float(np.median(steps / (self.times[lag:] - self.times[:-lag])))


@dataclass(frozen=True)
class Fall:
    """How the ball falls, in units of the tracks' positions and s.

    Attributes:
        acceleration: (3,) that all windows share, across the direction of flight, where drag does
            not act: gravity, and lift if all shots have the same spin.
        velocities: (n, 3) of the windows.
    """

    acceleration: Floats
    velocities: Floats

    @property
    def size(self) -> float:
        """Magnitude of the shared acceleration."""
        return float(np.linalg.norm(self.acceleration))


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

    def turned(self, axes: Floats) -> "Flights":
        """Return the flights with all vectors multiplied by a (3, 3) matrix, without contacts."""
        vectors = [part @ axes.T for part in (self.velocities, self.accelerations, self.spins)]
        return Flights(vectors[0], vectors[1], self.errors, vectors[2], ())


@dataclass(frozen=True)
class Measured:
    """What recordings measured, in the table frame as their source states it.

    Attributes:
        tracks: of recordings that have enough samples with numbers, at most ``MOST_TRACKS``.
    """

    tracks: tuple[Track, ...]

    @classmethod
    def by(cls, tables: Sequence[RawTable], frame: Frame) -> "Measured":
        """Return what tables measured, transformed into the table frame."""
        chosen = spread_evenly(len(tables), min(MOST_TRACKS, len(tables)))
        return cls(tuple(_tracks([tables[k] for k in chosen], frame)))

    @cached_property
    def step(self) -> float:
        """Median time between two samples, in the tracks' units."""
        return float(np.median(np.concatenate([np.diff(track.times) for track in self.tracks])))

    @cached_property
    def extent(self) -> float:
        """Largest extent of a typical track, in its units."""
        return float(np.median([np.ptp(track.positions, axis=0).max() for track in self.tracks]))

    @cached_property
    def second(self) -> float:
        """How many units of the tracks' times make a second: a power of a thousand."""
        scale = 1.0
        while self.step / scale > LONGEST_STEP:
            scale *= 1000
        while self.step / scale < SHORTEST_STEP:
            scale /= 1000
        return scale

    @cached_property
    def fall(self) -> Fall | None:
        """How the ball falls; ``None`` if there are too few samples."""
        windows = np.array([row for track in self.tracks for row in _windows(track, self.second)])
        if len(windows) < FEWEST_WINDOWS:
            return None
        # Those of a ball that moves and touches nothing.
        speeds, residuals = np.linalg.norm(windows[:, :3], axis=1), windows[:, 6]
        moves = speeds > RESTING * np.quantile(speeds, 0.9)
        windows = windows[moves & (residuals <= KINK * np.median(residuals[moves]))]
        velocities, accelerations = windows[:, :3], windows[:, 3:6]
        return Fall(_shared_across(velocities, accelerations), velocities)

    @cached_property
    def flights(self) -> Flights:
        """Flights and contacts of tracks in s and m."""
        noise = coordinate_noise([track.positions for track in self.tracks])
        rows: list[Floats] = []
        contacts: list[Contact] = []
        for track in self.tracks:
            positions = np.ascontiguousarray(track.positions)
            cuts = cut(track.times, positions, SegmentSettings(noise=noise))
            rows += _labelled_flights(track, cuts, noise)
            contacts += cuts.contacts.values()
        table = np.array(rows).reshape(-1, 10)
        return Flights(table[:, :3], table[:, 3:6], table[:, 6], table[:, 7:], tuple(contacts))

    @cached_property
    def bounces(self) -> Floats:
        """(n, 3) m, places of bounces, where z is up."""
        return bounce_places(self.flights.contacts, UP)


def coordinate_noise(paths: Sequence[Floats]) -> float:
    """Return the noise of a coordinate, m: the median third difference, at least the usual noise.

    Smooth paths have hardly any third differences, and the median ignores contacts and outliers.

    Args:
        paths: (n, 3) positions of each recording, m.
    """
    usual = SegmentSettings().noise
    parts = [np.abs(np.diff(path, 3, axis=0)).ravel() for path in paths]
    sizes = np.concatenate([np.empty(0), *parts])
    if not len(sizes):
        return usual
    return float(np.clip(TO_DEVIATION * np.median(sizes) / DIFFERENCE, usual, LARGEST_NOISE))


def bounce_places(contacts: Sequence[Contact], up: Floats) -> Floats:
    """Return (n, 3) places of contacts at which a passive surface throws the ball up.

    Args:
        contacts: of all recordings.
        up: (3,) unit vector.
    """
    positions = []
    for contact in contacts:
        down, rise = -contact.before @ up, contact.after @ up
        gain = np.linalg.norm(contact.after) - np.linalg.norm(contact.before)
        if down > SLOWEST_BOUNCE and rise > SLOWEST_BOUNCE and gain < MOST_GAIN:
            positions.append(contact.position)
    return np.array(positions).reshape(-1, 3)


def _tracks(tables: Sequence[RawTable], frame: Frame) -> Iterator[Track]:
    for table in tables:
        rows = table.rows.reindex(columns=SAMPLE_COLUMNS).astype(float)
        rows = rows[np.isfinite(rows[["t", *POSITION_COLUMNS]].to_numpy()).all(axis=1)]
        rises = rows["t"] > rows["t"].cummax().shift(fill_value=-np.inf)
        rows = frame.to_table(rows[rises]).reset_index(drop=True)
        # A label that is repeated in every row holds for the first row only.
        labels = rows[SPIN_COLUMNS].dropna()
        if len(labels) > 1 and (labels == labels.iloc[0]).all(axis=None):
            rows.loc[labels.index[1:], SPIN_COLUMNS] = np.nan
        if len(rows) >= FEWEST_SAMPLES:
            columns = ("t", POSITION_COLUMNS, SPIN_COLUMNS)
            yield Track(*(rows[column].to_numpy() for column in columns))


def _windows(track: Track, second: float) -> Iterator[Floats]:
    """Yield velocity, acceleration and residual (7,) of windows that do not overlap."""
    seconds = track.times / second
    numbers = ((seconds - seconds[0]) / WINDOW).astype(np.int64)
    starts = np.flatnonzero(np.diff(numbers, prepend=-1))
    for rows in np.split(np.arange(len(numbers)), starts[1:]):
        times = seconds[rows]
        if len(rows) >= FEWEST_IN_WINDOW and times[-1] - times[0] > WINDOW / 2:
            velocity, acceleration, residual = _parabola(times, track.positions[rows])
            yield np.array([*velocity, *acceleration, residual])


def _parabola(times: Floats, positions: Floats) -> tuple[Floats, Floats, float]:
    """Return velocity (3,) and acceleration (3,) at the middle time, and the RMS residual."""
    since = times - times.mean()
    terms = np.vander(since, 3)
    coefficients = np.linalg.lstsq(terms, positions)[0]
    residuals = positions - terms @ coefficients
    return coefficients[1], 2 * coefficients[0], float(np.sqrt((residuals**2).mean()))


def _shared_across(velocities: Floats, accelerations: Floats) -> Floats:
    """Return the acceleration (3,) that best explains all components across the velocities.

    Iteratively reweighted least squares with the L1 norm, because some windows have contacts.
    """
    speeds = np.maximum(np.linalg.norm(velocities, axis=1), 1e-12)
    along = velocities / speeds[:, None]
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    seen = np.einsum("nij,nj->ni", across, accelerations)
    shared, scale = np.median(accelerations, axis=0), np.median(np.linalg.norm(seen, axis=1))
    for _ in range(ROUNDS):
        misses = np.linalg.norm(seen - across @ shared, axis=1)
        weights = 1 / np.maximum(misses, 1e-3 * scale + 1e-12)
        information = np.einsum("n,nij->ij", weights, across) + RIDGE * weights.sum() * np.eye(3)
        shared = np.linalg.solve(information, weights @ seen)
    return np.asarray(shared)


def _labelled_flights(track: Track, cuts: Cuts, noise: float) -> Iterator[Floats]:
    """Yield velocity, acceleration, its error and mean label (10,) of flights with a label."""
    for number in range(cuts.flights):
        rows = np.flatnonzero((cuts.flight == number) & ~cuts.outlier)
        labels = track.spins[rows][np.isfinite(track.spins[rows]).all(axis=1)]
        if len(rows) >= FEWEST_IN_FLIGHT and len(labels):
            times = track.times[rows]
            velocity, acceleration, _ = _parabola(times, track.positions[rows])
            error = PARABOLA_ERROR * noise / np.ptp(times) ** 2 / np.sqrt(len(rows))
            yield np.array([*velocity, *acceleration, error, *labels.mean(axis=0)])
