"""What policies gain by another predictor: the paper's sim-to-sim figure and sim-to-real table."""

from functools import partial

from pipeline.paper import values as paper
from pipeline.paper.entries import MISSING, Entry, Finding, Group, number
from pipeline.paper.judgements import Interval, beside, claim, minus, share
from pipeline.paper.run_reports import Reports

SIMULATORS = {"imperfect_a": "A", "imperfect_b": "B", "imperfect_c": "C"}
HORIZONS_MS = ("115-125", "170-180")
SETS = {"stroke_pro": "Stroke-Pro", "stroke_uni": "Stroke-Uni", "receive": "Receive"}
MOST = "stroke_uni"  # where the paper says that the swap gains the most
PREDICTORS = {"physics": "physics", "learned": "transformer"}
RATES = {"hits": "hit_rate", "returns": "return_rate"}
BETWEEN_SIMULATORS = "sim2sim/difference.csv"
REPLAYED, GAINED = "sim2real/rates.csv", "sim2real/difference.csv"


def _right_simulator(simulator: str, horizons: str, run: Reports) -> Finding:
    gain = run.interval(
        BETWEEN_SIMULATORS,
        "difference",
        protocol="first_state",
        simulator=simulator,
        horizons_ms=horizons,
    )
    if gain is None:
        return MISSING
    points = gain.times(100)
    return Finding(claim(points), points.value, points)


def _counted(name: str, horizons: str, predictor: str, outcome: str, run: Reports) -> Finding:
    rate = RATES[outcome]
    ours = run.numbers(
        REPLAYED,
        [outcome, "balls", rate, f"{rate}_low", f"{rate}_high"],
        set=name,
        horizons_ms=horizons,
        predictor=PREDICTORS[predictor],
        protocol="every_tick",
    )
    if ours is None:
        return MISSING
    count, balls, *shares = ours
    percent = Interval(*shares).times(100)
    printed = share(_printed(name, horizons, predictor, outcome), paper.SHOTS[name])
    value, low, high = percent
    words = f"{number(count)} of {balls:.0f}: {value:.0f} % ({low:.0f} to {high:.0f})"
    return Finding(beside(percent, printed.times(100)), value, percent, words)


def _gain_of(run: Reports, name: str, horizons: str, outcome: str) -> Interval | None:
    """Return what the swap gains in a set (percentage points)."""
    gain = run.interval(
        GAINED,
        "difference",
        set=name,
        horizons_ms=horizons,
        predictor=PREDICTORS["learned"],
        protocol="every_tick",
        outcome=outcome,
    )
    return None if gain is None else gain.times(100)


def _gained(name: str, horizons: str, outcome: str, run: Reports) -> Finding:
    points = _gain_of(run, name, horizons, outcome)
    return MISSING if points is None else Finding(claim(points), points.value, points)


def _gained_more(other: str, horizons: str, outcome: str, run: Reports) -> Finding:
    most, less = (_gain_of(run, name, horizons, outcome) for name in (MOST, other))
    if most is None or less is None:
        return MISSING
    points = minus(most, less)
    return Finding(claim(points), points.value, points)


def _printed(name: str, horizons: str, predictor: str, outcome: str) -> int:
    count: int = getattr(paper.TRANSFER[name, horizons], f"{predictor}_{outcome}")
    return count


def _number(name: str, horizons: str, predictor: str, outcome: str) -> Entry:
    count, shots = _printed(name, horizons, predictor, outcome), paper.SHOTS[name]
    return Entry(
        f"transfer.{name}.{horizons}.{predictor}.{outcome}",
        f"{SETS[name]}, {horizons} ms, {outcome} told by {PREDICTORS[predictor]}",
        100 * count / shots,
        "%",
        "sim2real",
        f"{REPLAYED}: {outcome}, {RATES[outcome]}",
        partial(_counted, name, horizons, predictor, outcome),
        words=f"{count} of {shots}: {100 * count / shots:.0f} %",
    )


def _printed_gain(name: str, horizons: str, outcome: str) -> float:
    before, after = (_printed(name, horizons, who, outcome) for who in ("physics", "learned"))
    return 100 * (after - before) / paper.SHOTS[name]


def _gain(name: str, horizons: str, outcome: str) -> Entry:
    return Entry(
        f"gain.{name}.{horizons}.{outcome}",
        f"{SETS[name]}, {horizons} ms, {outcome} gained by the swap",
        _printed_gain(name, horizons, outcome),
        "points",
        "sim2real",
        f"{GAINED}: difference, ci_low, ci_high",
        partial(_gained, name, horizons, outcome),
    )


def _more(other: str, horizons: str, outcome: str) -> Entry:
    most, less = (_printed_gain(name, horizons, outcome) for name in (MOST, other))
    return Entry(
        f"most.{other}.{horizons}.{outcome}",
        f"{SETS[MOST]} over {SETS[other]}, {horizons} ms, {outcome}: gained more by the swap",
        most - less,
        "points",
        "sim2real",
        f"{GAINED}: difference, ci_low, ci_high",
        partial(_gained_more, other, horizons, outcome),
    )


SIM2SIM = Group(
    "sim2sim",
    "Figure 4: sim-to-sim",
    "Returns of balls of the ground truth, told by it, minus returns told by the simulator that "
    "the policy was trained in: percentage points. Predictions start from the ball's first state, "
    "as in the paper, which draws the rates and prints none. The differences where they start from "
    "its true state at every tick are in sim2sim/difference.csv, too.",
    (-20.0, 50.0),
    tuple(
        Entry(
            f"sim2sim.{simulator}.{horizons}",
            f"simulator {letter}, {horizons} ms: more returns when told by the ground truth",
            None,
            "points",
            "sim2sim",
            f"{BETWEEN_SIMULATORS}: difference, ci_low, ci_high",
            partial(_right_simulator, simulator, horizons),
            words="more",
        )
        for simulator, letter in SIMULATORS.items()
        for horizons in HORIZONS_MS
    ),
)

COUNTS = Group(
    "transfer",
    "Table I: hits and returns of replayed shots",
    "Shares of the shots; both predictors are asked at every tick. Other shots, another arm and "
    "another policy: that the shares differ says little, what the swap gains is below. The paper's "
    "intervals, for the verdict, are those of its counts.",
    (0.0, 100.0),
    tuple(
        _number(name, horizons, predictor, outcome)
        for name in SETS
        for horizons in HORIZONS_MS
        for predictor in PREDICTORS
        for outcome in RATES
    ),
)

GAINS = Group(
    "gain",
    "Table I: what the swap gains",
    "Hits and returns with the transformer minus those with physics, on the same shots, in "
    "percentage points. The paper claims more of both in every set; one of its own twelve "
    "differences is zero.",
    (-25.0, 40.0),
    tuple(
        _gain(name, horizons, outcome)
        for name in SETS
        for horizons in HORIZONS_MS
        for outcome in RATES
    ),
)

ESPECIALLY = Group(
    "most",
    "Table I: the most in Stroke-Uni",
    "What the swap gains in Stroke-Uni minus what it gains in another set, in percentage points. "
    'The paper says "especially in the Stroke-Uni shots"; one of its own eight differences is '
    "zero. Sets have other shots, so the interval is put together from those of the two gains.",
    (-40.0, 40.0),
    tuple(
        _more(other, horizons, outcome)
        for other in SETS
        if other != MOST
        for horizons in HORIZONS_MS
        for outcome in RATES
    ),
)
