"""What a network sees and says instead of metres and radians a second.

Measurements are standardised, and zero where there are none. Beside them stands how far each is off
*uniform motion*, in which curve and noise of a path show. Before that,

- a ball that flies towards +y is seen from the other side of the table (half a turn about the
  vertical), so that a network learns one direction of play and not two;
- the way that the ball has come is magnified about where it is now: in 55 ms it comes a few
  decimetres on a table of metres, and a network would be long in finding so small a difference.

Futures are told as deviations from uniform motion: the straight line that fits the history, at its
speed, with its mean spin. That is no model of flight, gravity included; it spares the network
to find again in its output what its input says already, to the millimetre.
"""

import torch
from torch import Tensor, nn

from models.predictors.protocol import FUTURE_TIMES, HISTORY, HISTORY_TIMES, TICK

INPUTS = 6  # numbers a measured row: position and spin
RESIDUALS = 3  # and how far its position is off uniform motion
OUTPUTS = 9  # numbers a forecast row: position, velocity and spin

MAGNIFICATION = 6.0  # 55 ms of the ball's way look like 330 ms, as far as forecasts go
# Position, velocity, spin: by how much finer than its spread each is told, and so weighs in a loss.
# Measured spin is so noisy that it would else be half of the loss, and its noise of the gradient.
WEIGHT = (3.0, 1.0, 0.5)
RESIDUAL = 0.006  # m, about what noise and gravity take a sample off the line
FARTHEST_RESIDUAL = 5.0  # of these; an outlier tells no more by being further off
HALF_TURN = (-1.0, -1.0, 1.0)  # of a vector, or of a spin, about the vertical
SMALLEST_SPREAD = 1e-3  # m, m/s, rad/s; a number that varies by less is constant, but for rounding
_EARLIER, _LATER = torch.triu_indices(HISTORY, HISTORY, offset=1)


class Normaliser(nn.Module):
    """Turns measurements into a network's numbers, and a network's numbers into ball states.

    Its statistics are buffers, so that they are saved with the network's weights; they are fitted
    to training windows once (``fit``). The three axes of a quantity share one spread in the
    output: a millimetre counts the same in each.
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

    def fit(self, history: Tensor, seen: Tensor, future: Tensor, measured: Tensor) -> None:
        """Take mean and spread of every number from training windows.

        Args:
            history: (B, 12, 6) measured positions (m) and spins (rad/s).
            seen: (B, 12, 6) where they were measured.
            future: (B, 60, 9) measured positions, velocities (m/s) and spins.
            measured: (B, 60, 9) where they were measured.
        """
        motion = uniform_motion(history, seen)
        self.history_mean, self.history_spread = _moments(_seen_from_behind(history, motion), seen)
        self.future_mean, spread = _moments(_turned(future - motion, motion), measured)
        by_quantity = spread.view(3, 3).square().mean(dim=1, keepdim=True).sqrt()
        self.future_spread = (
            (by_quantity / spread.new_tensor(WEIGHT)[:, None]).expand(3, 3).flatten()
        )

    def normalised(self, history: Tensor, seen: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 12, 6) standardised measurements, zero where there are none.

        Args:
            history: (B, 12, 6) measurements.
            seen: (B, 12, 6) where they were measured.
            motion: (B, 60, 9) their uniform motion, here and below.
        """
        viewed = _seen_from_behind(history, motion)
        return torch.where(seen, (viewed - self.history_mean) / self.history_spread, 0.0)

    def residual(self, history: Tensor, seen: Tensor, motion: Tensor) -> Tensor:
        """Return (B, 12, 3) how far measured positions are off uniform motion; zero without any.

        In units of ``RESIDUAL``, and never more than ``FARTHEST_RESIDUAL`` of them.
        """
        times = torch.as_tensor(HISTORY_TIMES, dtype=history.dtype, device=history.device)
        line = _now(motion) + times[:, None] * motion[:, :1, 3:6]
        residual = _turned(history[..., :3] - line, motion) / RESIDUAL
        limited = FARTHEST_RESIDUAL * torch.tanh(residual / FARTHEST_RESIDUAL)
        return torch.where(seen[..., :3], limited, 0.0)

    def expected(self, motion: Tensor) -> Tensor:
        """Return (B, 60, 6) standardised positions and spins of uniform motion."""
        states = torch.cat([motion[..., :3], motion[..., 6:]], dim=2)
        return (_turned(states, motion) - self.history_mean) / self.history_spread

    def deviation(self, future: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, 60, 9) output that stands for the ball states ``future``."""
        return (_turned(future - motion, motion) - self.future_mean) / self.future_spread

    def states(self, output: Tensor, motion: Tensor) -> Tensor:
        """Return the (B, 60, 9) ball states that a network's output stands for."""
        return _turned(output * self.future_spread + self.future_mean, motion) + motion


def uniform_motion(history: Tensor, seen: Tensor) -> Tensor:
    """Return the (B, 60, 9) states of balls that go on as they come.

    Medians of all pairs' slopes and of what remains (Theil 1950, Sen 1968) rather than least
    squares, because one outlier would bend the line by centimetres.

    Args:
        history: (B, 12, 6) measured positions and spins; any finite number where not measured.
        seen: (B, 12, 6) where they were measured.
    """
    times = torch.as_tensor(HISTORY_TIMES, dtype=history.dtype, device=history.device)
    ahead = torch.as_tensor(FUTURE_TIMES, dtype=history.dtype, device=history.device)
    known = torch.where(seen, history, torch.nan)
    position, spin = known[..., :3], known[..., 3:]
    spans = (times[_LATER] - times[_EARLIER])[:, None]
    velocity = _median((position[:, _LATER] - position[:, _EARLIER]) / spans)
    now = _median(position - velocity[:, None] * times[:, None])
    turning = torch.nan_to_num(spin.nanmean(dim=1))
    moved = now[:, None] + ahead[:, None] * velocity[:, None]
    rest = torch.cat([velocity, turning], dim=1)[:, None].expand(-1, len(ahead), -1)
    return torch.cat([moved, rest], dim=2)


def _median(values: Tensor) -> Tensor:
    """Return the (B, 3) median over the rows of (B, N, 3) that are numbers; zero without any."""
    ordered = values.sort(dim=1).values  # what is no number comes last
    count = (~values.isnan()).sum(dim=1, keepdim=True)
    places = (count - 1) // 2, count // 2
    lower, upper = (ordered.gather(1, place.clamp(min=0)) for place in places)
    return torch.nan_to_num((lower + upper) / 2).squeeze(1)


def _seen_from_behind(history: Tensor, motion: Tensor) -> Tensor:
    """Return (B, 12, 6) measurements turned to one direction of play, the way come magnified."""
    now = _now(motion)
    position = now + MAGNIFICATION * (history[..., :3] - now)
    return _turned(torch.cat([position, history[..., 3:]], dim=2), motion)


def _now(motion: Tensor) -> Tensor:
    """Return the (B, 1, 3) position at the end of the history that uniform motion goes on from."""
    return motion[:, :1, :3] - TICK * motion[:, :1, 3:6]


def _turned(vectors: Tensor, motion: Tensor) -> Tensor:
    """Return (B, T, 3 n) vectors after half a turn where (B, 60, 9) ``motion`` goes towards +y."""
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
    return mean, torch.where(spread > SMALLEST_SPREAD, spread, 1.0)
