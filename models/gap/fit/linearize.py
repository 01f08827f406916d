"""Linearised shots: derivatives by all parameters, and residuals, in one array.

Near the fitted nuisance parameters ``eta`` of a shot its measurements are ``y = h + G d_eta + F
d_theta + noise``: G by its nuisance parameters, F by the hypotheses, which all shots share. The
columns are in this order: E nuisance parameters, K hypotheses, F coefficients of errors that all
shots share, in which measurements are exactly linear, and last the residual ``y - h``.
"""

from dataclasses import dataclass, fields, replace

import numpy as np

from rallygap.models.ball.simulator import Simulator
from rallygap.models.ball.state import STATE_SIZE
from rallygap.models.ball.types import Floats
from rallygap.models.gap.fit.measurement import (
    JUMP,
    KINK,
    Schedule,
    hypothesis_derivatives,
    nuisance_derivatives,
    predict_measurements,
)
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.hypotheses import Hypothesis
from rallygap.models.gap.types import Bools, Indices


@dataclass(frozen=True)
class Linearised:
    """B shots near their fitted nuisance parameters.

    Attributes:
        shots: the measurements.
        simulator: about which they are linearised.
        columns: the K hypotheses.
        nuisance: (B, E) at which: states and kicks.
        positions: (B, N, 3, E + K + F + 1) columns of the positions, zero in padding.
        labels: (B, L, 3, E + K + 1) columns of the labels but those of shared errors, which do not
            change labels; zero where there is none, in units of the fitted spin.
        label_scales: (B, L) these units, rad/s.
        label_arcs: (B, L) how many contacts are before a label.
        velocities: (B, N, 3) of the balls at the samples, m/s.
        sampled: (B, N) which samples are used.
        labelled: (B, L) which labels are used.
    """

    shots: Shots
    simulator: Simulator
    columns: tuple[Hypothesis, ...]
    nuisance: Floats
    positions: Floats
    labels: Floats
    label_scales: Floats
    label_arcs: Indices
    velocities: Floats
    sampled: Bools
    labelled: Bools

    def __getitem__(self, rows: Indices) -> "Linearised":
        """Return some of the shots."""
        names = [field.name for field in fields(self) if field.name not in ("simulator", "columns")]
        return replace(self, **{name: getattr(self, name)[rows] for name in names})

    def departures(self, nominal: Simulator) -> Floats:
        """Return (K,) by how much the values of the hypotheses depart from the nominal ones."""
        return np.array([c.value(self.simulator) - c.value(nominal) for c in self.columns])

    @property
    def nuisance_count(self) -> int:
        """E, the number of nuisance parameters of a shot."""
        return int(self.nuisance.shape[1])

    @property
    def of_hypotheses(self) -> slice:
        """Places of the K columns of the hypotheses."""
        return slice(self.nuisance_count, self.nuisance_count + len(self.columns))

    @property
    def of_shared(self) -> slice:
        """Places of the F columns of shared errors."""
        end = self.positions.shape[-1] - 1
        return slice(end - 3 * self.shots.shared.shape[-1], end)

    def with_shared(self, shots: Shots) -> "Linearised":
        """Return the shots with the columns of the errors that ``shots``, the same, share."""
        columns, shared = self.positions, _shared_columns(shots)
        shared[~self.sampled] = 0.0
        parts = columns[..., : self.of_shared.start], shared, columns[..., -1:]
        return replace(self, shots=shots, positions=np.concatenate(parts, axis=-1))

    @property
    def of_labels(self) -> Indices:
        """(E + K + 1,) places, among the columns of the positions, of those of the labels."""
        return np.array([*range(self.of_shared.start), self.of_shared.stop])

    @property
    def in_arcs(self) -> Bools:
        """(B, L, J) in which of the arcs between contacts a label is."""
        arcs = np.arange(int(self.label_arcs.max(initial=0)) + 1)
        return np.asarray(self.label_arcs[..., None] == arcs)

    @property
    def label_counts(self) -> tuple[Floats, Floats]:
        """(B, L) how many labels are in the arc of a label, and (B, 1) in its shot."""
        return label_counts(self.labelled, self.label_arcs)

    @property
    def listed(self) -> Bools:
        """(K,) which of the hypotheses are about parameters that the simulator lists."""
        return np.array([column.listed(self.simulator) for column in self.columns], dtype=bool)


def linearise(
    shots: Shots, simulator: Simulator, nuisance: Floats, columns: tuple[Hypothesis, ...]
) -> Linearised:
    """Linearise shots about a simulator and their (B, E) nuisance parameters."""
    schedule = Schedule.of(shots)
    prediction = predict_measurements(simulator, schedule, nuisance)
    inner = nuisance_derivatives(simulator, schedule, nuisance, prediction)
    outer = hypothesis_derivatives(simulator, schedule, nuisance, prediction, columns)
    prediction = replace(prediction, smooth_until=np.fmin(inner.smooth_until, outer.smooth_until))
    miss = shots.positions - prediction.positions, np.nan_to_num(shots.labels) - prediction.labels
    shared = _shared_columns(shots)
    positions = np.concatenate(
        [inner.positions, outer.positions, shared, miss[0][..., None]], axis=-1
    )
    labels = np.concatenate([inner.labels, outer.labels, miss[1][..., None]], axis=-1)
    start = shots.times[:, :1]
    sampled = shots.valid & prediction.is_smooth(shots.times - start, KINK)
    sampled &= np.isfinite(positions).all(axis=(2, 3))
    positions[~sampled] = 0.0
    labelled = shots.labelled & prediction.is_smooth(shots.label_times - start, JUMP)
    labels[~labelled] = 0.0
    scales = label_scales(prediction.labels)
    labels /= scales[..., None, None]
    return Linearised(
        shots=shots,
        simulator=simulator,
        columns=columns,
        nuisance=nuisance,
        positions=positions,
        labels=labels,
        label_scales=scales,
        label_arcs=prediction.arcs(shots.label_times - start),
        velocities=prediction.velocities,
        sampled=sampled,
        labelled=labelled,
    )


def label_scales(spins: Floats) -> Floats:
    """Return (B, L) sizes of (B, L, 3) fitted spins, at least a tenth of the typical one, rad/s.

    Errors of labels grow with the spin. The size of a label itself would give those that came out
    large too little weight.
    """
    sizes = np.linalg.norm(spins, axis=-1)
    typical = float(np.sqrt(np.mean(sizes**2))) if sizes.size else 0.0
    scales: Floats = np.maximum(sizes, max(0.1 * typical, 1.0))
    return scales


def label_counts(labelled: Bools, arcs: Indices) -> tuple[Floats, Floats]:
    """Return (B, L) how many labels are in the arc of a label, and (B, 1) in its shot."""
    count = int(arcs.max(initial=0)) + 1
    arc_of_all = arcs + count * np.arange(len(arcs))[:, None]
    sizes = np.bincount(arc_of_all[labelled], minlength=count * len(arcs))
    in_arc = np.maximum(sizes[arc_of_all], 1).astype(np.float64)
    in_shot = np.maximum(labelled.sum(axis=1, keepdims=True), 1).astype(np.float64)
    return in_arc, in_shot


def ballistic_nuisance(states: Floats, kicks: int) -> Floats:
    """Return (B, 9 + 3 kicks) nuisance parameters of (B, 9) states without kicks."""
    return np.concatenate([states[:, :STATE_SIZE], np.zeros((len(states), 3 * kicks))], axis=1)


def _shared_columns(shots: Shots) -> Floats:
    """Return (B, N, 3, F) columns of shared errors of positions."""
    columns = np.zeros((*shots.positions.shape, 3, shots.shared.shape[-1]))
    for axis in range(3):
        columns[:, :, axis, axis] = shots.shared
    return columns.reshape(*shots.positions.shape, -1)
