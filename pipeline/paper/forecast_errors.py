"""Claims of the paper's Figure 3: whose forecast errors are smaller, at every horizon."""

from rallygap.pipeline.paper.assessments import FAILS, HOLDS, OPEN, Interval, claim, combined
from rallygap.pipeline.paper.run_reports import Reading, Reports, ReportSource

ERRORS = "evaluate_predictor/forecast_error.csv"
DIFFERENCES = "evaluate_predictor/forecast_error_difference.csv"
SET, LEARNED = "arena", "transformer"
HORIZONS_MS = (100, 200, 300)  # those that the tables of a run have
CASE: dict[str, str | int] = {"set": SET, "against": "measured", "bounce": "all"}  # of errors


class ErrorDifference(ReportSource):
    """The transformer's mean forecast error compared with a rival's."""

    rival: str
    quantity: str

    @property
    def place(self) -> str:
        """The table of differences."""
        return f"{DIFFERENCES}: mean, lower_share"

    def read(self, run: Reports) -> Reading | None:
        """Return whether the mean error is below the rival's at every horizon.

        The number is the difference at the last horizon in percent of the rival's error.
        """
        found = [self._difference(run, horizon) for horizon in HORIZONS_MS]
        last = run.number(
            ERRORS, "mean", predictor=self.rival, quantity=self.quantity,
            horizon_ms=HORIZONS_MS[-1], **CASE,
        )  # fmt: skip
        known = [one for one in found if one is not None]
        if len(known) < len(found) or last is None:
            return None
        word = combined(claim(interval, grows=False) for interval, _ in known)
        if word == HOLDS and min(lower for _, lower in known) < 1:
            word = OPEN
        interval = known[-1][0].times(100 / last)
        return Reading(interval.value, interval, assessment=word)

    def _difference(self, run: Reports, horizon: int) -> tuple[Interval, float] | None:
        """Return the error minus the rival's, and at which share of horizons it is less.

        The table has a pair of predictors in either order.
        """
        at: dict[str, str | int] = {"set": SET, "quantity": self.quantity, "horizon_ms": horizon}
        for first, second, sign in ((LEARNED, self.rival, 1), (self.rival, LEARNED, -1)):
            found = run.numbers(
                DIFFERENCES, ["mean", "ci_low", "ci_high", "lower_share"],
                predictor=first, other=second, **at,
            )  # fmt: skip
            if found is not None:
                *interval, lower = found
                return Interval(*interval).times(sign), lower if sign > 0 else 1 - lower
        return None


class ErrorSpread(ReportSource):
    """The standard deviation of the transformer's forecast error compared with its rivals'."""

    smallest_spread: str
    rivals: list[str]

    @property
    def place(self) -> str:
        """The table of errors."""
        return f"{ERRORS}: std"

    def read(self, run: Reports) -> Reading | None:
        """Return whether it is smaller than every rival's at all horizons.

        The number is the excess over the smallest of the rivals at the last horizon in percent.
        """
        keys = ["quantity", "horizon_ms", "predictor", *CASE]
        table = run.table(ERRORS, keys, ["std"])
        case = {**CASE, "quantity": self.smallest_spread}
        for column, value in case.items() if len(table) else ():
            table = table[table[column] == value]
        if not {LEARNED, *self.rivals} <= set(table.get("predictor", ())):
            return None
        spread = table.pivot(index="horizon_ms", columns="predictor", values="std")
        best = spread[self.rivals].min(axis=1)
        word = HOLDS if (spread[LEARNED] < best).all() else FAILS
        return Reading(100 * float((spread[LEARNED] / best).iloc[-1] - 1), assessment=word)
