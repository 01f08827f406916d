"""The catalogue: all entries, and the figures and tables that they belong to."""

from dataclasses import dataclass

from pipeline.paper.entries import Finding, Group
from pipeline.paper.judgements import NO_NUMBER, of_all
from pipeline.paper.prediction_accuracy import ACCURACY, BESIDE_OTHERS
from pipeline.paper.printed_settings import DATA, EXPERIMENTS, PREDICTOR, QUOTED
from pipeline.paper.run_reports import Reports
from pipeline.paper.shot_quality import DOUBLED, QUALITY
from pipeline.paper.transfer import COUNTS, ESPECIALLY, GAINS, SIM2SIM

GROUPS = (
    ACCURACY,
    BESIDE_OTHERS,
    SIM2SIM,
    COUNTS,
    GAINS,
    ESPECIALLY,
    QUALITY,
    DOUBLED,
    DATA,
    PREDICTOR,
    EXPERIMENTS,
    QUOTED,
)

OTHERS = (
    "Balls, arm and policy are others than the paper's. Network and training are the paper's in "
    "the profile paper alone; what this run has of them is said below, setting by setting."
)


@dataclass(frozen=True)
class Exhibit:
    """A figure, table or algorithm of the paper.

    Attributes:
        name: as the paper numbers it.
        what: it shows.
        stage: that makes ours.
        ours: the files, relative to the reports; or where else it is.
        claims: the groups whose verdicts make its own; without any, it has no number.
    """

    name: str
    what: str
    stage: str
    ours: str
    claims: tuple[Group, ...]

    def verdict(self, run: Reports) -> str:
        """Return the verdict on it, from those on its claims."""
        if not self.claims:
            return NO_NUMBER
        return of_all(entry.find(run).verdict for group in self.claims for entry in group.entries)


EXHIBITS = (
    Exhibit("Figure 1", "a sketch of the swap", "sim2real", "the replay in index.html", ()),
    Exhibit("Figure 2", "a sketch of the network", "train_predictor",
            "models/predictors/transformer.py; model cards in artifacts/train_predictor", ()),
    Exhibit("Figure 3", "forecast error of position, velocity and spin over the horizon",
            "evaluate_predictor", "evaluate_predictor/figures/forecast_error_arena.png",
            (ACCURACY,)),
    Exhibit("Figure 4", "returns between simulators, told by the right and the wrong one",
            "sim2sim", "sim2sim/figures/return_rate.png", (SIM2SIM,)),
    Exhibit("Table I", "hits and returns of replayed shots, told by physics and by the learned",
            "sim2real", "sim2real/transfer.csv, sim2real/figures/transfer.png",
            (GAINS, ESPECIALLY)),
    Exhibit("Figure 5", "medians of speed, spin, clearance and winning probability of returns",
            "shot_quality", "shot_quality/quality.csv, shot_quality/figures/quality.png",
            (QUALITY, DOUBLED)),
    Exhibit("Algorithm 1", "the swap step by step", "sim2real",
            "stages/train_policy.py, stages/train_predictor.py, stages/sim2real.py", ()),
)  # fmt: skip


def findings(run: Reports) -> dict[str, Finding]:
    """Return what a run says to every entry, by key."""
    return {entry.key: entry.find(run) for group in GROUPS for entry in group.entries}
