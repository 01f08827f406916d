"""The questions that the exam asks, as a pure function of a seed and of counts."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from experiments.exam.design.parameters import NEED_LABELS, family, hideable, in_turn
from experiments.exam.design.question import MULTIPLE, Question, question, seed_of
from experiments.exam.design.robustness import robustness
from experiments.exam.simulate.trial import CAMERAS, SpinLabels
from rallygap.models.arena.cameras import SlowError
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis

LABELS: tuple[SpinLabels, ...] = ("per_row", "per_shot", "none")
FAULTY = replace(CAMERAS, outliers=0.03, dropouts=0.10, slow_error=SlowError(share=0.6, time=0.05))


@dataclass(frozen=True)
class Cell:
    """A setting of the sweeps: size of the cause in detection limits, shots and noise (m)."""

    name: str
    multiple: float = MULTIPLE
    shots: int = 100
    noise: float = 0.003


BASE = Cell("base")
SWEEPS = (
    *(Cell(f"size-{multiple}x", multiple=multiple) for multiple in (1, 2, 5, 10)),
    *(Cell(f"shots-{shots}", shots=shots) for shots in (10, 30, 300)),
    *(Cell(f"noise-{noise}mm", noise=noise / 1000) for noise in (1, 10)),
)

# How often the exam asks: repeats of each parameter in the base and other cells, and group sizes.
BASE_REPEATS, SWEEP_REPEATS = 5, 3
CLEAN, PAIRS = 500, 80
SENSOR_FAULTS, NOMINAL_OFF, WITHHELD, UNLABELLED, ONE_DIRECTION = 40, 50, 50, 40, 40


def exam(nominal: Simulator, seed: int) -> list[Question]:
    """Return all questions about a nominal simulator, each with a seed that its name gives it."""
    groups = (_sweeps, _clean, _pairs, _other_groups, robustness)
    return [question for group in groups for question in group(nominal, seed)]


def _sweeps(nominal: Simulator, seed: int) -> Iterator[Question]:
    for cell in (BASE, *SWEEPS):
        cameras = replace(CAMERAS, position_noise=cell.noise)
        for hidden in hideable():
            for number in range(BASE_REPEATS if cell is BASE else SWEEP_REPEATS):
                part = ("sweep", cell.name, number, nominal, seed, (hidden,), cell.multiple)
                yield question(*part, shots=cell.shots, cameras=cameras)


def _clean(nominal: Simulator, seed: int) -> Iterator[Question]:
    """Yield clean sets of all kinds of labels, mostly in both directions."""
    random = np.random.default_rng(seed_of(seed, "clean"))
    for number in range(CLEAN):
        labels, directions = LABELS[random.integers(3)], int(random.choice([2, 2, 2, 1]))
        yield question(
            "clean", "", number, nominal, seed, spin_labels=labels, directions=directions
        )


def _pairs(nominal: Simulator, seed: int) -> Iterator[Question]:
    """Yield pairs of causes of different families."""
    random = np.random.default_rng(seed_of(seed, "pairs"))
    parameters = hideable()
    for number in range(PAIRS):
        first = parameters[random.integers(len(parameters))]
        others = [other for other in parameters if family(other) != family(first)]
        second = others[random.integers(len(others))]
        yield question("pair", "", number, nominal, seed, (first, second))


def _other_groups(nominal: Simulator, seed: int) -> Iterator[Question]:
    """Yield the other groups, in which every parameter is hidden equally often."""
    parameters = hideable()
    sensor = [hidden for hidden in parameters if catalogue()[hidden.effect].acts == "sensor"]
    # Faults of the sensor, with cameras that are worse in every other way, too.
    faulty: dict[str, Any] = {"cameras": FAULTY, "time_resolution": 0.001}
    for number, hidden in _drawn(sensor, seed, "sensor_fault", SENSOR_FAULTS):
        part = ("sensor_fault", "", number, nominal, seed, (hidden,))
        yield question(*part, spin_labels="per_shot", **faulty)
    missing = [hidden for hidden in parameters if not hidden.listed(nominal)]
    listed = [hidden for hidden in parameters if hidden.listed(nominal)]
    random = np.random.default_rng(seed_of(seed, "own"))
    # Missing effects while a parameter of the nominal simulator is off at the same time.
    for number, hidden in _drawn(missing, seed, "nominal_off", NOMINAL_OFF):
        others = [other for other in listed if family(other) != family(hidden)]
        off = others[random.integers(len(others))]
        yield question("nominal_off", "", number, nominal, seed, (hidden, off))
    for number, hidden in _drawn(missing, seed, "withheld", WITHHELD):
        withheld = (hidden.effect,)
        yield question("withheld", "", number, nominal, seed, (hidden,), withheld=withheld)
    need_no_label = [hidden for hidden in parameters if hidden.effect not in NEED_LABELS]
    for number, hidden in _drawn(need_no_label, seed, "unlabelled", UNLABELLED):
        yield question("unlabelled", "", number, nominal, seed, (hidden,), spin_labels="none")
    for number, hidden in _drawn(parameters, seed, "one_direction", ONE_DIRECTION):
        yield question("one_direction", "", number, nominal, seed, (hidden,), directions=1)


def _drawn(
    parameters: list[Hypothesis], seed: int, group: str, count: int
) -> Iterator[tuple[int, Hypothesis]]:
    """Yield numbered parameters, every one equally often."""
    random = np.random.default_rng(seed_of(seed, group))
    return enumerate(islice(in_turn(parameters, random), count))
