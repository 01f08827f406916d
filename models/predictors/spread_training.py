"""Training of a spread, after the network whose errors it describes, which stays as it is.

It maximises the likelihood of the forecast's errors on training windows. Errors have heavy tails,
because a ball may hit the net, so the likelihood is a multivariate Student-t.
"""

import numpy as np
import torch
from torch import Tensor
from torch.optim import Adam
from torch.optim.lr_scheduler import CosineAnnealingLR

from rallygap.models.predictors.learned import ForecastNetwork
from rallygap.models.predictors.spread import Spread
from rallygap.models.predictors.window_dataset import Tracks

DEGREES = 4.0  # of freedom of the errors
EPOCHS, BATCH, LEARNING_RATE = 6, 256, 2e-3
FIRST_FIT = 4000  # windows that typical errors are taken from
NORMAL_SPREAD = 1.4826  # standard deviations of a normal in its median absolute value
LEAST_SIZE = 1e-4  # of a typical error, in the units of the normaliser

Window = tuple[Tensor, Tensor, Tensor, Tensor]  # as Tracks.windows has it


def fit_spread(network: ForecastNetwork, tracks: Tracks, seed: int) -> Spread:
    """Return the spread of a trained network's errors on windows of training tracks."""
    torch.manual_seed(seed)
    spread, random = Spread(), np.random.default_rng(seed)
    first_anchors = tracks.draw_anchors(random.integers(0, tracks.episodes, FIRST_FIT), random)
    window = tracks.windows(first_anchors)
    errors, known = _errors(network, window, network.baseline(*window[:2]))
    sizes = torch.where(known[..., None], errors.abs(), torch.nan).nanmedian(dim=0).values
    spread.sizes.copy_(NORMAL_SPREAD * sizes.nan_to_num(1.0).clamp(min=LEAST_SIZE))
    optimizer = Adam(spread.parameters(), lr=LEARNING_RATE)
    steps = EPOCHS * -(-tracks.episodes // BATCH)
    schedule = CosineAnnealingLR(optimizer, steps)
    for _ in range(EPOCHS):
        anchors = tracks.draw_anchors(random.permutation(tracks.episodes), random)
        for start in range(0, len(anchors), BATCH):
            loss = _loss(network, spread, tracks.windows(anchors[start : start + BATCH]))
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimizer.step()
            schedule.step()
    return spread.eval()


def _errors(network: ForecastNetwork, window: Window, motion: Tensor) -> tuple[Tensor, Tensor]:
    """Return (B, 60, 3) normalised errors of positions, and (B, 60) where they are known."""
    history, mask, future, measured = window
    with torch.no_grad():
        wanted = network.normaliser.deviation(future, motion)
        errors = wanted - network.deviation(history, mask, motion)
    return errors[..., :3], measured[..., :3].all(dim=2)


def _loss(network: ForecastNetwork, spread: Spread, window: Window) -> Tensor:
    """Return the negative log likelihood of measured positions, but for a constant."""
    history, mask, _, _ = window
    motion = network.baseline(history, mask)
    errors, known = _errors(network, window, motion)
    factors = spread(*network.inputs(history, mask, motion))
    scaled = torch.linalg.solve_triangular(factors, errors[..., None], upper=False)[..., 0]
    distance = scaled.square().sum(dim=2)
    volume = torch.diagonal(factors, dim1=2, dim2=3).log().sum(dim=2)
    losses = volume + 0.5 * (DEGREES + 3) * torch.log1p(distance / DEGREES)
    return torch.where(known, losses, 0.0).sum() / known.sum().clamp(min=1)
