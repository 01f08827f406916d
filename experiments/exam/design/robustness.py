"""Robustness groups: sessions whose errors or physics differ from what the sweeps assume.

One question in five of each group is clean: it has the group's errors and no physical cause.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import cycle, islice, product
from typing import Any, NamedTuple

import numpy as np

from experiments.exam.design.parameters import family, hideable, in_turn
from experiments.exam.design.question import MULTIPLE, Question, question, seed_of
from experiments.exam.simulate.camera_errors import (
    CameraErrors,
    Distortion,
    FieldShape,
    HeavyTailedScatter,
    LabelErrors,
    Stamps,
)
from experiments.exam.simulate.trial import CAMERAS, SCATTER, Variation
from rallygap.models.ball.catalogue import catalogue
from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.hypotheses import Hypothesis

COUNT = 60  # questions of a group
CLEAN_EVERY = 5

LABEL_ERROR, SESSION_ERROR = 0.05, 0.03  # of the spin
SMALL_ROW_ERROR = 0.01  # of the spin, of labels whose error is common to a shot
SHAPES: tuple[FieldShape, ...] = ("gaussian", "radial", "gaussian", "half")
FIELD_SIZE, FIELD_LENGTH = (0.001, 0.004), (0.6, 2.0)  # m
LARGE = 10.0  # detection limits, of a cause together with a distortion
DEGREES = (3.0, 4.0)  # of freedom of t distributions
ROUNDINGS = (0.001, 0.002, 0.003, 0.004, 0.005)  # s
STAMP_JITTER = (0.0005, 0.002)  # s to either side
FRAME_RATES = (50, 80, 125, 160, 250)  # Hz
SPREAD = (0.03, 0.08)  # of a parameter that differs from shot to shot
SEVERAL, MULTIPLES = (3, 6), (3.0, 5.0, 10.0)  # causes; detection limits of each

RESTITUTION, FRICTION = (Hypothesis("table_bounce", name) for name in ("restitution", "friction"))
DRAG, LIFT, CLOCK = (
    Hypothesis("drag", "cd"),
    Hypothesis("magnus", "cm"),
    Hypothesis("clock_rate", "d"),
)
WIND = tuple(Hypothesis("wind", axis) for axis in ("x", "y", "z"))
DRIFTING = (DRAG, *WIND, LIFT, RESTITUTION, FRICTION, CLOCK)
BY_SHOT = (DRAG, LIFT, RESTITUTION, FRICTION)
BY_PLACE = (DRAG, *WIND, LIFT, RESTITUTION, FRICTION)
# Parameters and their wrong values; None: the simulator lacks the effect.
FAR_OFF = ((DRAG, 0.3), (DRAG, 0.7), (LIFT, None), (RESTITUTION, 0.85), (FRICTION, 0.1))


class Session(NamedTuple):
    """Conditions of a question."""

    part: str  # of the group
    hidden: tuple[Hypothesis, ...]
    settings: dict[str, Any]  # of the trial
    multiple: float = MULTIPLE
    nominal: Simulator | None = None  # where it is not that of the exam


Group = Callable[[Simulator, np.random.Generator], Iterator[Session]]


def robustness(nominal: Simulator, seed: int) -> Iterator[Question]:
    """Yield the questions of all robustness groups."""
    for group, sessions in GROUPS.items():
        random = np.random.default_rng(seed_of(seed, group))
        for number, session in enumerate(islice(sessions(nominal, random), COUNT)):
            # A question of every five, in turn each of these, so that all parts have clean ones.
            part, hidden, settings, multiple, other = session
            if number % CLEAN_EVERY == number // CLEAN_EVERY % CLEAN_EVERY:
                hidden, causes = (), ("variation", "far_off")
                settings = {name: settings[name] for name in settings if name not in causes}
            simulator = other or nominal
            yield question(group, part, number, simulator, seed, hidden, multiple, **settings)


def _physical() -> list[Hypothesis]:
    """Return the parameters of flight and table that shots can show."""
    return [hidden for hidden in hideable() if catalogue()[hidden.effect].acts != "sensor"]


def _paired(
    kinds: Sequence[Any], parameters: Sequence[Hypothesis], random: np.random.Generator
) -> Iterator[tuple[Any, Hypothesis]]:
    """Yield kinds and parameters, without end."""
    return zip(cycle(kinds), in_turn(parameters, random), strict=False)


def _label_kind(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Errors of labels that are independent by row, or common to an arc, a shot or the session."""
    kinds = (
        ("row", LABEL_ERROR, LabelErrors()),
        ("arc", 0.0, LabelErrors(arc=LABEL_ERROR)),
        ("shot", SMALL_ROW_ERROR, LabelErrors(shot=LABEL_ERROR)),
        ("one_label", LABEL_ERROR, LabelErrors()),
        ("session", LABEL_ERROR, LabelErrors(session=SESSION_ERROR)),
    )
    # A label that all rows of an arc repeat contradicts a decay of the spin.
    shown = [hidden for hidden in _physical() if hidden.effect != "spin_decay"]
    for (kind, of_rows, shared), hidden in _paired(kinds, shown, random):
        settings = {
            "cameras": replace(CAMERAS, spin_noise=of_rows),
            "errors": CameraErrors(labels=shared),
            "spin_labels": "per_shot" if kind == "one_label" else "per_row",
        }
        yield Session(kind, (hidden,), settings)


def _distortion(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Smooth position errors, half of them Gaussian, with small and with large causes."""
    kinds = list(product((MULTIPLE, LARGE), SHAPES))
    for (multiple, shape), hidden in _paired(kinds, _physical(), random):
        size, length = random.uniform(*FIELD_SIZE), random.uniform(*FIELD_LENGTH)
        gaussian = shape == "gaussian"
        distortion = Distortion(shape, size, length) if gaussian else Distortion(shape, size)
        settings = {"errors": CameraErrors(distortion=distortion)}
        yield Session(shape, (hidden,), settings, multiple)


def _heavy_tails(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Position errors, bounce scatter or both with t distributions."""
    for kind, hidden in _paired(("positions", "bounces", "both"), _physical(), random):
        degrees = random.uniform(*DEGREES)
        settings: dict[str, Any] = {}
        if kind != "bounces":
            settings["errors"] = CameraErrors(tails=degrees)
        if kind != "positions":
            settings["scatter"] = HeavyTailedScatter(SCATTER.restitution, SCATTER.friction, degrees)
        yield Session(kind, (hidden,), settings)


def _time_stamps(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Time stamps that are rounded, or jittered."""
    for kind, hidden in _paired(("rounded", "jittered"), _physical(), random):
        rounded = Stamps(rounding=float(random.choice(ROUNDINGS)))
        jittered = Stamps(jitter=random.uniform(*STAMP_JITTER))
        stamps = rounded if kind == "rounded" else jittered
        yield Session(kind, (hidden,), {"errors": CameraErrors(stamps=stamps)})


def _frame_rate(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Cameras of other frame rates."""
    for rate, hidden in _paired(FRAME_RATES, _physical(), random):
        cameras = replace(CAMERAS, interval=1.0 / rate)
        yield Session(f"{rate}Hz", (hidden,), {"cameras": cameras})


def _drift(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """A parameter that changes linearly from shot to shot; its mean is at 3 detection limits."""
    for hidden in in_turn(DRIFTING, random):
        yield Session("", (hidden,), {"variation": Variation("drift", hidden)})


def _shot_variation(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Balls that differ: a parameter is different in every shot, and nominal on average."""
    for hidden in in_turn(BY_SHOT, random):
        spread = random.uniform(*SPREAD)
        settings = {"variation": Variation("shot", hidden, spread)}
        yield Session("", (hidden,), settings, multiple=0.0)


def _place(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """A cause in half of the room, twice as large as elsewhere."""
    for hidden in in_turn(BY_PLACE, random):
        yield Session("", (hidden,), {"variation": Variation("place", hidden)}, 2.0 * MULTIPLE)


def _several(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """Three to six causes of different families, each at 3 detection limits or more."""
    low, high = SEVERAL
    for count in cycle(range(low, high + 1)):
        chosen: dict[str, Hypothesis] = {}
        for parameter in random.permutation(np.array(_physical(), dtype=object)):
            chosen.setdefault(family(parameter), parameter)
        hidden = tuple(chosen.values())[:count]
        yield Session(f"{count}_causes", hidden, {}, float(random.choice(MULTIPLES)))


def _far_off(nominal: Simulator, random: np.random.Generator) -> Iterator[Session]:
    """A nominal simulator that is far off in one parameter, and a missing effect."""
    missing = [hidden for hidden in _physical() if not hidden.listed(nominal)]
    for wrong, value in cycle(FAR_OFF):
        part = f"no_{wrong.effect}" if value is None else f"{wrong.parameter}_{value:g}"
        others = [hidden for hidden in missing if family(hidden) != family(wrong)]
        hidden = others[random.integers(len(others))]
        settings = {"far_off": {wrong.effect: {wrong.parameter: wrong.value(nominal)}}}
        rest = {name: nominal.effects[name] for name in nominal.effects if name != wrong.effect}
        far = Simulator(rest) if value is None else wrong.at(nominal, value)
        yield Session(part, (hidden,), settings, nominal=far)


GROUPS: dict[str, Group] = {
    "label_kind": _label_kind,
    "distortion": _distortion,
    "heavy_tails": _heavy_tails,
    "time_stamps": _time_stamps,
    "frame_rate": _frame_rate,
    "drift": _drift,
    "shot_variation": _shot_variation,
    "place": _place,
    "several": _several,
    "far_off": _far_off,
}
# Groups with a cause that is not the same throughout the session.
VARYING = ("drift", "shot_variation", "place")
# Groups whose sensor has errors that no parameter of the catalogue describes.
FAULTY_SENSOR = ("label_kind", "distortion", "time_stamps")
