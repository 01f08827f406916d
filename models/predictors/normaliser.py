"""Normalisation: from metres and radians per second to a network's inputs and outputs, and back.

Measurements are standardised, with zero where there are none. Before that,

- balls that fly towards +y are rotated by half a turn about the vertical, so that a network learns
  one direction of play;
- the measured path is magnified about the current position: in 55 ms a ball moves a few decimetres
  on a table of metres, and a network is slow to resolve such small differences.

A further input is the residual of each measurement from *uniform motion*: a robust straight line
through the history at constant velocity, with the mean spin. It shows curvature and noise of the
path. Outputs are deviations of the future from a *baseline*, so that a network need not reproduce
its input to the millimetre. The baseline is uniform motion, which has no gravity, or for a hybrid
the forecast of a simulator. A hybrid's residuals are deviations from the straight line at the
baseline's first position and velocity.
"""

import torch
from torch import Tensor, nn

from rallygap.models.predictors.protocol import FUTURE_TIMES, HISTORY, HISTORY_TIMES, TICK

INPUTS = 6  # columns of a measurement: position and spin
RESIDUALS = 3  # columns of its position's residual from uniform motion
OUTPUTS = 9  # columns of a forecast: position, velocity and spin

MAGNIFICATION = 6.0  # 55 ms of the path look like 330 ms, the scale of the forecast
# Weights of position, velocity and spin in units of their spread, and so in the loss. Measured spin
# is so noisy that it would otherwise be half of the loss and dominate the gradient's noise.
WEIGHT = (3.0, 1.0, 0.5)
RESIDUAL_SCALE = 0.006  # m, about the effect of noise and gravity on a sample
MAX_RESIDUAL = 5.0  # of these; larger residuals of outliers are saturated
HALF_TURN = (-1.0, -1.0, 1.0)  # of a vector or spin about the vertical
MIN_SPREAD = 1e-3  # m, m/s, rad/s; anything that varies by less is constant
_EARLIER, _LATER = torch.triu_indices(HISTORY, HISTORY, offset=1)


class Normaliser(nn.Module):
    """Normalises measurements for a network and denormalises its output to ball states.

    The statistics are buffers, so they are saved with the network's weights; ``fit`` computes them
    from training windows. The three axes of a quantity share one output scale, so that a
    millimetre counts the same in each.
    """

    history_mean: Tensor
    history_spread: Tensor
    future_mean: Tensor
    future_spread: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("history_mean", torch.zeros(6))
        self.register_buffer("history_spread", torch.ones(6))
        self.register_buffer("future_mean", torch.zeros(9))
        self.register_buffer("future_spread", torch.ones(9))

    def fit(
        self, history: Tensor, mask: Tensor, future: Tensor, measured: Tensor, motion: Tensor
    ) -> None:
        """Compute mean and spread of every column from training windows.

        Args:
            history: (B, 12, 6) measured positions (m) and spins (rad/s), here and below.
            mask: (B, 12, 6) where they were measured.
            future: (B, 60, 9) measured positions, velocities (m/s) and spins.
            measured: (B, 60, 9) where they were measured.
            motion: (B, 60, 9) the baseline, which the network corrects.
        """
        self.history_mean, self.history_spread = _moments(_network_view(history, motion), mask)
        self.fit_outputs(future, measured, motion)

    def fit_outputs(self, future: Tensor, measured: Tensor, motion: Tensor) -> None:
        """Compute mean and spread of what the baseline leaves; arguments are those of ``fit``."""
        self.future_mean, spread = _moments(_rotated(future - motion, motion), measured)
        by_quantity = spread.view(3, 3).square().mean(dim=1, keepdim=True).sqrt()
        self.future_spread = (
            (by_quantity / spread.new_tensor(WEIGHT)[:, None]).expand(3, 3).flatten()
        )

    def normalised(self, history: Tensor, mask: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 12, 6) standardised measurements, zero where there are none."""
        viewed = _network_view(history, motion)
        return torch.where(mask, (viewed - self.history_mean) / self.history_spread, 0.0)

    def residual(self, history: Tensor, mask: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 12, 3) residuals of measured positions from the baseline's straight line.

        They are in units of ``RESIDUAL_SCALE``, saturated at ``MAX_RESIDUAL``, and zero where
        nothing is measured.
        """
        times = torch.as_tensor(HISTORY_TIMES, dtype=history.dtype, device=history.device)
        line = _current_position(motion) + times[:, None] * motion[:, :1, 3:6]
        residual = _rotated(history[..., :3] - line, motion) / RESIDUAL_SCALE
        limited = MAX_RESIDUAL * torch.tanh(residual / MAX_RESIDUAL)
        return torch.where(mask[..., :3], limited, 0.0)

    def expected(self, motion: Tensor) -> Tensor:
        """Return (B, 60, 6) standardised positions and spins of the baseline."""
        states = torch.cat([motion[..., :3], motion[..., 6:]], dim=2)
        return (_rotated(states, motion) - self.history_mean) / self.history_spread

    def deviation(self, future: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, 60, 9) network output that corresponds to the ball states ``future``."""
        return (_rotated(future - motion, motion) - self.future_mean) / self.future_spread

    def states(self, output: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, 60, 9) ball states that correspond to a network's output."""
        return _rotated(output * self.future_spread + self.future_mean, motion) + motion

    def distances(self, output: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, N, 3) vectors, m, that correspond to a network's output of positions."""
        return _rotated(self.future_spread[0] * output, motion)


def uniform_motion(history: Tensor, mask: Tensor) -> Tensor:
    """Return the (B, 60, 9) future states at constant velocity and spin.

    The line is a Theil-Sen estimate (Theil 1950, Sen 1968) rather than least squares, which one
    outlier would bend by centimetres.

    Args:
        history: (B, 12, 6) measured positions and spins; any finite number where not measured.
        mask: (B, 12, 6) where they were measured.
    """
    times = torch.as_tensor(HISTORY_TIMES, dtype=history.dtype, device=history.device)
    ahead = torch.as_tensor(FUTURE_TIMES, dtype=history.dtype, device=history.device)
    position, spin = history[..., :3], history[..., 3:]
    seen, labelled = mask[..., :3], mask[..., 3:]
    spans = (times[_LATER] - times[_EARLIER])[:, None]
    slopes = (position[:, _LATER] - position[:, _EARLIER]) / spans
    velocity = _median(slopes, seen[:, _LATER] & seen[:, _EARLIER])
    now = _median(position - velocity[:, None] * times[:, None], seen)
    labels = labelled.sum(dim=1).clamp(min=1)
    mean_spin = torch.where(labelled, spin, 0.0).sum(dim=1) / labels
    moved = now[:, None] + ahead[:, None] * velocity[:, None]
    rest = torch.cat([velocity, mean_spin], dim=1)[:, None].expand(-1, len(ahead), -1)
    return torch.cat([moved, rest], dim=2)


def _median(values: Tensor, known: Tensor) -> Tensor:
    """Return the (B, 3) median over the known rows of (B, N, 3); zero without any."""
    ordered = torch.where(known, values, torch.inf).sort(dim=1).values
    count = known.sum(dim=1, keepdim=True)
    indices = (count - 1) // 2, count // 2
    lower, upper = (ordered.gather(1, index.clamp(min=0)) for index in indices)
    return torch.where(count > 0, (lower + upper) / 2, 0.0).squeeze(1)


def _network_view(history: Tensor, motion: Tensor) -> Tensor:
    """Return (B, 12, 6) measurements in one direction of play, the path magnified."""
    now = _current_position(motion)
    position = now + MAGNIFICATION * (history[..., :3] - now)
    return _rotated(torch.cat([position, history[..., 3:]], dim=2), motion)


def _current_position(motion: Tensor) -> Tensor:
    """Return the (B, 1, 3) position of uniform motion at the end of the history."""
    return motion[:, :1, :3] - TICK * motion[:, :1, 3:6]


def _rotated(vectors: Tensor, motion: Tensor) -> Tensor:
    """Return (B, T, 3 n) vectors rotated by half a turn where ``motion`` goes towards +y."""
    half_turn = vectors.new_tensor(HALF_TURN).repeat(vectors.shape[2] // 3)
    away = motion[:, :1, 4:5] > 0
    return torch.where(away, vectors * half_turn, vectors)


def _moments(values: Tensor, known: Tensor) -> tuple[Tensor, Tensor]:
    """Return mean and standard deviation of every column where it is known; 0 and 1 where never.

    The standard deviation of a constant is taken as 1.
    """
    count = known.sum(dim=(0, 1)).clamp(min=1)
    mean = torch.where(known, values, 0.0).sum(dim=(0, 1)) / count
    variance = torch.where(known, values - mean, 0.0).square().sum(dim=(0, 1)) / count
    spread = variance.sqrt()
    return mean, torch.where(spread > MIN_SPREAD, spread, 1.0)
