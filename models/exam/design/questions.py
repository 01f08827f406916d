"""The design: which questions the exam asks, as a pure function of a seed and of counts.

A question is a trial whose causes have no size yet. Sizes are multiples of what the very data set
could show, so they come from a function that the exam is given (``Question.posed``).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar
from zlib import crc32

import numpy as np

from models.arena.cameras import SlowError
from models.ball.catalogue import catalogue
from models.ball.simulator import Simulator
from models.exam.design.trial import CAMERAS, SpinLabels, Trial, World
from models.exam.simulate.laws import supports

# Effects that no ball of this exam can show, and why.
LEFT_OUT = {
    "time_offset": "a constant delay only moves the instant from which a shot is counted",
    "racket_bounce": "shots are recorded from after one racket to before the next",
    "net": "every shot clears the net",
}

# Effects that may look alike; a pair is drawn from two of these families. An effect that is not
# listed here is a family of its own.
FAMILIES = (
    ("gravity", "buoyancy", "added_mass", "clock_rate", "position_scale"),
    ("drag", "linear_drag", "speed_dependent_drag", "speed_dependent_latency"),
    ("magnus", "lift_saturation", "lift_crisis", "spin_gain", "spin_decay"),
    ("wind", "frame_tilt", "side_force", "spin_axis_bias"),
    ("restitution", "speed_dependent_restitution", "spin_dependent_restitution", "table_tilt"),
    ("friction", "slip_dependent_friction", "tangential_elasticity"),
)

# Parameters of which only one side makes sense: with the other sign balls would leave the table no
# slower than they met it, at the speeds of this exam, and restitution ends at one.
UPWARDS = (("speed_dependent_restitution", "c"),)

# Effects of the spin labels themselves.
NEED_LABELS = ("spin_gain", "spin_axis_bias", "spin_sign_flip")

MULTIPLE = 3.0  # of the detectable size, where nothing else is asked
INDEPENDENT_EVERY = 3  # one trial in three comes from the independent world
LABELS: tuple[SpinLabels, ...] = ("per_row", "per_shot", "none")
FAULTY = replace(CAMERAS, outliers=0.03, dropouts=0.10, slow_error=SlowError(share=0.6, time=0.05))
STAMP = 0.001  # s, the resolution of the time stamps of faulty cameras

Asked = TypeVar("Asked")  # a question, or what belongs to one

Name = tuple[str, str]  # effect and parameter
# The least sizes of some parameters, each with the others free, that a trial of these settings can
# show at 5.8 standard errors, withheld effects after projection on all that is not withheld;
# infinite where it cannot.
Detectable = Callable[[Trial, tuple[Name, ...]], Sequence[float]]


@dataclass(frozen=True)
class Cell:
    """A setting of the sweeps: the asked multiple of the detectable size, shots and noise."""

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


@dataclass(frozen=True)
class Counts:
    """How often the exam asks: repeats of each parameter and cell, and sizes of other groups."""

    base: int = 5
    sweep: int = 3
    clean: int = 500
    pairs: int = 80
    sensor_faults: int = 40
    nominal_off: int = 50
    withheld: int = 50
    unlabelled: int = 40
    one_direction: int = 40


@dataclass(frozen=True)
class Question:
    """A trial before its causes have a size.

    Attributes:
        group: what the question is for; the first part of the trial's name.
        trial: all but the causes.
        asked: the (effect, parameter) to hide; none in a clean set.
        multiple: of the detectable size.
        cell: of the sweeps that it belongs to, empty in other groups.
    """

    group: str
    trial: Trial
    asked: tuple[Name, ...] = ()
    multiple: float = MULTIPLE
    cell: str = ""

    def posed(self, detectable: Detectable) -> Trial | None:
        """Return the trial, or None where no possible value of a parameter is that large."""
        sizes = detectable(self.trial, self.asked) if self.asked else ()
        causes: dict[str, dict[str, float]] = {}
        for name, size in zip(self.asked, sizes, strict=True):
            value = self._value(name, self.multiple * size)
            if value is None:
                return None
            causes.setdefault(name[0], {})[name[1]] = value
        return replace(self.trial, causes=causes)

    def _value(self, name: Name, size: float) -> float | None:
        """Return a value so far from the nominal one, on the side that the seed says if it can."""
        effect, parameter = name
        known = next(p for p in catalogue()[effect].parameters if p.name == parameter)
        start = self.trial.nominal.effects.get(effect, {}).get(parameter, known.neutral)
        side = 1.0 if _seed(self.trial.seed, f"{effect}.{parameter}") % 2 else -1.0
        sides = (1.0,) if name in UPWARDS else (side, -side)
        for value in (float(start + one * size) for one in sides):
            if known.bounds[0] <= value <= known.bounds[1]:
                return value
        return None


def exam(nominal: Simulator, seed: int, counts: Counts | None = None) -> list[Question]:
    """Return all questions about a nominal simulator, each with a seed that its name gives it."""
    counts = Counts() if counts is None else counts
    return [
        *_sweeps(nominal, seed, counts),
        *_clean(nominal, seed, counts.clean),
        *_pairs(nominal, seed, counts.pairs),
        *_others(nominal, seed, counts),
    ]


def spread(questions: Sequence[Asked], count: int) -> list[Asked]:
    """Return ``count`` questions spread evenly over an exam: a smaller one of the same kind."""
    places = np.linspace(0, len(questions) - 1, min(count, len(questions)))
    return [questions[int(place)] for place in places.round()]


def hideable() -> list[Name]:
    """Return every (effect, parameter) of the catalogue that balls can show."""
    return [
        (effect.name, parameter.name)
        for effect in catalogue().values()
        for parameter in effect.parameters
        if effect.name not in LEFT_OUT
    ]


def family(name: Name) -> str:
    """Return the first member of the family of look-alikes of an (effect, parameter)."""
    known = name[1] if name[0] == "table_bounce" else name[0]
    return next((members[0] for members in FAMILIES if known in members), known)


def _seed(seed: int, name: str) -> int:
    return int(np.random.SeedSequence([seed, crc32(name.encode())]).generate_state(1)[0])


def _question(
    group: str,
    detail: str,
    number: int,
    nominal: Simulator,
    seed: int,
    asked: tuple[Name, ...] = (),
    multiple: float = MULTIPLE,
    **settings: Any,
) -> Question:
    hidden = "+".join(f"{effect}.{parameter}" for effect, parameter in asked)
    name = "/".join(part for part in (group, hidden, detail, str(number)) if part)
    independent = number % INDEPENDENT_EVERY == 0 and all(supports(effect) for effect, _ in asked)
    world: World = "independent" if independent else "catalogue"
    trial = Trial(name, nominal, world=world, seed=_seed(seed, name), **settings)
    return Question(group, trial, asked, multiple, detail)


def _sweeps(nominal: Simulator, seed: int, counts: Counts) -> Iterator[Question]:
    for cell in (BASE, *SWEEPS):
        settings = {
            "shots": cell.shots,
            "cameras": replace(CAMERAS, position_noise=cell.noise),
        }
        for name in hideable():
            for number in range(counts.base if cell is BASE else counts.sweep):
                asked, multiple = (name,), cell.multiple
                yield _question(
                    "sweep", cell.name, number, nominal, seed, asked, multiple, **settings
                )


def _clean(nominal: Simulator, seed: int, count: int) -> Iterator[Question]:
    """Yield clean sets of all kinds of labels, mostly in both directions."""
    random = np.random.default_rng(_seed(seed, "clean"))
    for number in range(count):
        labels, directions = LABELS[random.integers(3)], int(random.choice([2, 2, 2, 1]))
        settings: dict[str, Any] = {"spin_labels": labels, "directions": directions}
        yield _question("clean", "", number, nominal, seed, **settings)


def _pairs(nominal: Simulator, seed: int, count: int) -> Iterator[Question]:
    """Yield pairs of causes of different families."""
    random = np.random.default_rng(_seed(seed, "pairs"))
    names = hideable()
    for number in range(count):
        first = names[random.integers(len(names))]
        others = [name for name in names if family(name) != family(first)]
        second = others[random.integers(len(others))]
        yield _question("pair", "", number, nominal, seed, (first, second))


def _others(nominal: Simulator, seed: int, counts: Counts) -> Iterator[Question]:
    yield from _sensor_faults(nominal, seed, counts.sensor_faults)
    yield from _nominal_off(nominal, seed, counts.nominal_off)
    missing = [name for name in hideable() if name[0] not in nominal.effects]
    for number, name in _drawn(missing, seed, "withheld", counts.withheld):
        settings: dict[str, Any] = {"withheld": (name[0],)}
        yield _question("withheld", "", number, nominal, seed, (name,), **settings)
    no_label = [name for name in hideable() if name[0] not in NEED_LABELS]
    for number, name in _drawn(no_label, seed, "unlabelled", counts.unlabelled):
        settings = {"spin_labels": "none"}
        yield _question("unlabelled", "", number, nominal, seed, (name,), **settings)
    for number, name in _drawn(hideable(), seed, "one_direction", counts.one_direction):
        yield _question("one_direction", "", number, nominal, seed, (name,), directions=1)


def _sensor_faults(nominal: Simulator, seed: int, count: int) -> Iterator[Question]:
    """Yield faults of the sensor, seen by cameras that are worse in every other way, too."""
    faults = [name for name in hideable() if not _acts(name)]
    settings: dict[str, Any] = {"cameras": FAULTY, "stamp": STAMP, "spin_labels": "per_shot"}
    for number, name in _drawn(faults, seed, "sensor_fault", count):
        yield _question("sensor_fault", "", number, nominal, seed, (name,), **settings)


def _nominal_off(nominal: Simulator, seed: int, count: int) -> Iterator[Question]:
    """Yield missing effects while a parameter of the nominal simulator is off at the same time."""
    missing = [name for name in hideable() if name[0] not in nominal.effects]
    own = [name for name in hideable() if name[0] in nominal.effects]
    random = np.random.default_rng(_seed(seed, "own"))
    for number, name in _drawn(missing, seed, "nominal_off", count):
        others = [other for other in own if family(other) != family(name)]
        off = others[random.integers(len(others))]
        yield _question("nominal_off", "", number, nominal, seed, (name, off))


def _drawn(names: list[Name], seed: int, group: str, count: int) -> Iterator[tuple[int, Name]]:
    """Yield every name equally often, in an order that the seed says."""
    order = np.random.default_rng(_seed(seed, group)).permutation(len(names))
    for number in range(count):
        yield number, names[order[number % len(names)]]


def _acts(name: Name) -> bool:
    """Return whether an effect acts on the ball rather than on what is measured of it."""
    return catalogue()[name[0]].acts != "sensor"
