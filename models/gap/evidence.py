"""Evidence: what the shots say for and against every hypothesis, before any is refitted.

Each shot, freed of its unknowns, gives for K hypotheses a score ``u_s`` and an information ``A_s``.
A block k of them is tested beside others that are free, ``n`` (those that the simulator lists are
always free): with ``theta = A_nn^-1 U_n`` and ``C = A_kn A_nn^-1``,

    e_s = (u_k - A_kn theta)_s - C (u_n - A_nn theta)_s,    I = A_kk - C A_nk,

are the efficient scores and their information. ``U = sum e_s`` gives the estimate ``I^-1 U`` and
the gain of twice the log likelihood ``U'I^-1 U``, by which hypotheses are ranked. Whether a gain is
significant is left to the shots themselves: ``U'(sum d_s d_s')^-1 U`` holds whatever correlation
the noise has within a shot. Here ``d_s = e_s - I_s (I - I_s)^-1 (U - e_s)`` is how far a shot is
from what the others say of it, ``I_s`` its part of the information, so that an effect which shots
show unequally does not pass for their scatter. Its null distribution is that of the same figure
with the scores' signs drawn at random, a shot's at once; the same signs for all blocks give that of
the largest, so that many may be tested.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2, norm

from models.ball.types import Floats
from models.gap.components import Components
from models.gap.hypotheses import Hypothesis
from models.gap.linear import Linearised
from models.gap.marginal import marginal

Indices = NDArray[np.int64]

DETECTABLE = 5.8  # standard errors
SIGN_FLIPS = 20_000
FOLDS = 5
FEWEST_SUPPORTERS = 4.0  # shots
LEAST_INFORMATION = 1e-7  # of a hypothesis alone, that its own part beside the others must have


@dataclass(frozen=True)
class Tested:
    """One block of hypotheses, tested beside others.

    Attributes:
        block: places of the block's hypotheses.
        scores: (B, D) efficient scores of the shots.
        shares: (B, D, D) of each shot in the information.
    """

    block: tuple[int, ...]
    scores: Floats
    shares: Floats

    @cached_property
    def information(self) -> Floats:
        """(D, D) of all shots."""
        information: Floats = self.shares.sum(axis=0)
        return information

    @cached_property
    def estimate(self) -> Floats:
        """(D,) by how much the values differ from the simulator's, to first order."""
        change: Floats = np.linalg.solve(self.information, self.scores.sum(axis=0))
        return change

    @cached_property
    def standard_error(self) -> Floats:
        """(D,) of each estimate, with the noise as it was found."""
        error: Floats = np.sqrt(np.diag(np.linalg.inv(self.information)))
        return error

    @cached_property
    def gain(self) -> float:
        """Twice the gain of log likelihood."""
        return float(self.scores.sum(axis=0) @ self.estimate)

    @cached_property
    def held_out_gain(self) -> float:
        """Twice the gain of log likelihood of shots by the values that others say.

        The shots of each fold in turn are predicted from all others.
        """
        fold = np.arange(len(self.scores)) % FOLDS
        parts = [(self.scores[fold == f].sum(axis=0), self.shares[fold == f]) for f in range(FOLDS)]
        total, gain = self.scores.sum(axis=0), 0.0
        for score, shares in parts:
            information = shares.sum(axis=0)
            said = np.linalg.solve(_regular(self.information - information), total - score)
            gain += float(2 * said @ score - said @ information @ said)
        return gain

    def studentised(self, signs: Floats) -> Floats:
        """Return (R,) squared test statistics of shots whose scores have (R, B) signs.

        With ``B_s = I_s (I - I_s)^-1`` a surprise is ``d_s = (1 + B_s) e_s - B_s U``; their sum of
        squares is written out in U, so that it follows the signs at the cost of a few products.
        """
        others = _regular(self.information - self.shares)
        pull = np.swapaxes(np.linalg.solve(others, self.shares), 1, 2)
        lone = self.scores + np.einsum("sij,sj->si", pull, self.scores)
        total = signs @ self.scores
        size = len(self.block)
        products = np.einsum("si,sjk->sijk", lone, pull).reshape(len(lone), -1)
        mixed = (signs @ products).reshape(-1, size, size, size)
        crossed = np.einsum("rijk,rk->rij", mixed, total)
        pulled = np.einsum("sij,skl->ikjl", pull, pull)
        square = np.einsum("ikjl,rj,rl->rik", pulled, total, total)
        spread = lone.T @ lone - crossed - np.swapaxes(crossed, 1, 2) + square
        solved = np.linalg.solve(_regular(spread), total[..., None])[..., 0]
        squares: Floats = (total * solved).sum(axis=1)
        return squares

    @cached_property
    def supporters(self) -> float:
        """How many shots, all alike, would say as much: no verdict rests on one or two."""
        shares = np.einsum("bdd->b", np.linalg.solve(_regular(self.information), self.shares))
        return float(shares.sum() ** 2 / np.maximum((shares**2).sum(), 1e-300))

    @cached_property
    def extremity(self) -> float:
        """How many standard deviations of a normal the test amounts to.

        The spread between shots and the noise as it was found must both allow it: where only a
        handful of shots show an effect, their spread alone may be small by chance.
        """
        between = self.studentised(np.ones((1, len(self.scores))))[0]
        return float(_normal_size(min(between, self.gain), len(self.block)))


@dataclass(frozen=True)
class Evidence:
    """What B shots say of K hypotheses.

    Attributes:
        columns: the hypotheses.
        listed: (K,) which of them the simulator lists.
        scores: (B, K) of the shots.
        information: (B, K, K) of the shots.
    """

    columns: tuple[Hypothesis, ...]
    listed: NDArray[np.bool_]
    scores: Floats
    information: Floats

    @classmethod
    def of(cls, linear: Linearised, components: Components) -> "Evidence":
        """Return the evidence of linearised shots in the metric of their noise."""
        left = marginal(components.grams, linear.own)
        return cls(linear.columns, linear.listed, left.scores, left.information)

    @cached_property
    def total(self) -> Floats:
        """(K, K) information of all shots."""
        total: Floats = self.information.sum(axis=0)
        return total

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(K,) which hypotheses change what is measured at all."""
        diagonal = np.diag(self.total)
        shown: NDArray[np.bool_] = diagonal > 0.0
        return shown

    @cached_property
    def free(self) -> tuple[int, ...]:
        """Places of the simulator's own numbers: those that the shots see."""
        return tuple(np.flatnonzero(self.listed & self.seen).tolist())

    def tested(self, block: Sequence[int], beside: Sequence[int]) -> Tested:
        """Test a block of hypotheses beside others that are free."""
        k, n = list(block), [one for one in beside if one not in block]
        inner = _regular(self.total[np.ix_(n, n)])
        free = np.linalg.solve(inner, self.scores[:, n].sum(axis=0))
        mixing = np.linalg.solve(inner, self.total[np.ix_(n, k)]).T
        rest = self.scores - self.information[:, :, n] @ free
        a = self.information
        across = a[:, k][:, :, n] - mixing @ a[:, n][:, :, n]
        shares = a[:, k][:, :, k] - mixing @ a[:, n][:, :, k] - across @ mixing.T
        return Tested(tuple(k), rest[:, k] - rest[:, n] @ mixing.T, shares)

    def decidable(self, beside: Sequence[int]) -> tuple[int, ...]:
        """Return the places of hypotheses that the shots can tell from all that is beside them."""
        return tuple(
            k for k in np.flatnonzero(self.seen).tolist() if self.decides(self.tested([k], beside))
        )

    def decides(self, test: Tested) -> bool:
        """Return whether the shots can decide about the one hypothesis that is tested."""
        (k,) = test.block
        information = test.information[0, 0]
        reach = np.ptp(self.columns[k].declaration.bounds)
        own_part = information > LEAST_INFORMATION * self.total[k, k]
        within = information * reach**2 > DETECTABLE**2
        return bool(own_part and within and test.supporters > FEWEST_SUPPORTERS)

    def likeness(self, one: int, other: int, beside: Sequence[int]) -> float:
        """Return the correlation of two hypotheses' signatures, 1 where no data like these differ.

        The numbers beside them, less these two, are projected out.
        """
        rest = [k for k in beside if k not in (one, other)]
        pair = self.tested([one, other], rest).information
        return float(abs(pair[0, 1]) / np.sqrt(pair[0, 0] * pair[1, 1]))

    def detectable(self, k: int, beside: Sequence[int]) -> float:
        """Return the smallest size of a hypothesis that these shots would show."""
        return DETECTABLE * float(self.tested([k], beside).standard_error[0])


def familywise(tests: Sequence[Tested], seed: int = 0) -> Floats:
    """Return each test's probability that the most extreme of all is as extreme by chance.

    The blocks may differ in size; they are compared by their probabilities under chi squared.
    """
    generator = np.random.default_rng(seed)
    signs = generator.choice([-1.0, 1.0], size=(SIGN_FLIPS, len(tests[0].scores)))
    largest = np.zeros(SIGN_FLIPS)
    for test in tests:
        size = _normal_size(test.studentised(signs), len(test.block))
        largest = np.maximum(largest, size)
    largest.sort()
    found = np.array([test.extremity for test in tests])
    above = SIGN_FLIPS - np.searchsorted(largest, found * (1 - 1e-9))
    chances: Floats = (1 + above) / (1 + SIGN_FLIPS)
    return chances


def _normal_size(squares: Any, degrees: int) -> Any:
    """Return the size of a standard normal that is as rare as a chi squared of these degrees."""
    if degrees == 1:
        return np.sqrt(np.maximum(squares, 0.0))
    return -norm.ppf(np.maximum(chi2.sf(squares, degrees), 1e-300) / 2)


def _regular(matrix: Floats) -> Floats:
    """Return information matrices that can be inverted where hypotheses are exactly alike."""
    size = matrix.shape[-1]
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)[..., None] * np.eye(size)
    return matrix + 1e-10 * diagonal + 1e-300 * np.eye(size)
