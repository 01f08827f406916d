"""Where our number comes from: the kinds of ``ours`` in ``values.yaml``."""

from pydantic import Field

from rallygap.models.ball.simulators import shipped
from rallygap.pipeline.paper.assessments import Interval, difference
from rallygap.pipeline.paper.forecast_errors import ErrorDifference, ErrorSpread
from rallygap.pipeline.paper.run_reports import Reading, Reports, ReportSource
from rallygap.pipeline.paper.settings import COMPUTED, CONSTANTS

DIGITS = 4  # of a difference in percentage points: tables have six digits of a share


class Table(ReportSource):
    """A row of a table of the reports: a number, perhaps with its interval and the count behind it.

    The number is ``(column + offset) * scale``.
    """

    file: str
    where: dict[str, str | int]
    column: str
    low: str | None = "ci_low"
    high: str | None = "ci_high"
    offset: float = 0
    scale: float = 1
    count: str | None = None
    of: str | None = None

    @property
    def place(self) -> str:
        """The file and the column."""
        return f"{self.file}: {self.column}"

    def read(self, run: Reports) -> Reading | None:
        """Return the number, or ``None`` where the reports do not have it."""
        named = [self.column, self.low, self.high, self.count, self.of]
        found = run.numbers(self.file, [name for name in named if name], **self.where)
        if found is None:
            return None
        value, *ends = (self.scale * (one + self.offset) for one in found[:3])
        if self.low is None:
            return Reading(value)
        interval = Interval(value, *ends)
        if self.count is None:
            return Reading(interval.value, interval)
        value, low, high = interval
        counts = f"{round(found[3], 1):g} of {found[4]:.0f}"
        return Reading(value, interval, f"{counts}: {number(value)} % ({low:.0f} to {high:.0f})")


class Difference(ReportSource):
    """One number minus another that is independent of it."""

    first: "Source"
    minus: "Source"

    @property
    def place(self) -> str:
        """Where the first is."""
        return self.first.place

    def read(self, run: Reports) -> Reading | None:
        """Return the difference, or ``None`` where the reports lack one of the two."""
        found = [one.read(run) for one in (self.first, self.minus)]
        ends = [one.interval for one in found if one is not None and one.interval is not None]
        if len(ends) < len(found):
            return None
        interval = Interval(*(round(end, DIGITS) + 0.0 for end in difference(*ends)))  # no -0
        return Reading(interval.value, interval)


class Parameter(ReportSource):
    """A number of params.yaml."""

    param: str
    scale: float = 1

    @property
    def place(self) -> str:
        """Its path."""
        return f"params.yaml: {self.param}"

    def read(self, run: Reports) -> Reading | None:
        """Return the run's parameter."""
        found = run.param(self.param)
        return None if found is None else Reading(self.scale * float(found))


class Constant(ReportSource):
    """A constant of the code, the same in every run."""

    constant: str
    of: str

    @property
    def place(self) -> str:
        """The module that has it."""
        return self.of

    def read(self, run: Reports) -> Reading | None:
        """Return the constant."""
        return Reading(CONSTANTS[self.constant])


class SimulatorParameter(ReportSource):
    """A parameter of a shipped simulator, which is named here or by a parameter of the run."""

    effect: str
    parameter: str
    simulator: str | None = None
    simulator_param: str | None = None

    @property
    def place(self) -> str:
        """The simulator's file, or the parameter that names it."""
        if self.simulator_param:
            return f"params.yaml: {self.simulator_param}"
        return f"models/ball/simulators/{self.simulator}.yaml: {self.effect}.{self.parameter}"

    def read(self, run: Reports) -> Reading | None:
        """Return the parameter of the simulator."""
        name = run.param(self.simulator_param) if self.simulator_param else self.simulator
        if name is None:
            return None
        return Reading(float(shipped(name).effects[self.effect][self.parameter]))


class Computed(ReportSource):
    """A setting that is computed from the reports or the parameters of a run."""

    computed: str

    @property
    def place(self) -> str:
        """What it is computed from."""
        return COMPUTED[self.computed][1]

    def read(self, run: Reports) -> Reading | None:
        """Return the setting."""
        found = COMPUTED[self.computed][0](run)
        return None if found is None else Reading(found)


class Unmeasured(ReportSource):
    """No number of ours; where to look instead."""

    see: str = Field(min_length=1)

    @property
    def place(self) -> str:
        """Where to look."""
        return self.see

    def read(self, run: Reports) -> Reading | None:
        """Return nothing."""
        return None


Source = (
    Table
    | Difference
    | ErrorDifference
    | ErrorSpread
    | Parameter
    | Constant
    | SimulatorParameter
    | Computed
    | Unmeasured
)


def number(value: float) -> str:
    """Return a number with three digits, however small it is."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"
