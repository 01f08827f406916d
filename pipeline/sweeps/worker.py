"""The process that does trials: ``python -m pipeline.sweeps.worker SWEEP STUDY TRIALS``.

Any number of them work on one study. The URL of its database, which may hold a password, comes by
the environment variable RALLYGAP_STUDY, where the process list does not show it.
"""

import math
import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import optuna
from optuna import TrialPruned

from pipeline.runtime.console import refuse
from pipeline.runtime.errors import InputError
from pipeline.runtime.provenance import repository_root
from pipeline.sweeps.lost_trials import Signature
from pipeline.sweeps.plan import Plan, load_plan
from pipeline.sweeps.settings import PredictorSweep, Value
from pipeline.sweeps.study import load_study, running, tried
from pipeline.sweeps.trial_tracking import TrialRecord, recorded_trial
from pipeline.sweeps.trial_types import Trials, Watch

STUDY = "RALLYGAP_STUDY"  # the environment variable with the URL
LOOK_AGAIN = 2.0  # s, while others do the last trials


@dataclass(frozen=True)
class Worker:
    """A worker on a study.

    Attributes:
        plan: of the sweep.
        trials: trains.
        signature: by which other workers know whether it lives.
        say: told about each trial.
        master: the process that started it; when that has died, it ends, too.
    """

    plan: Plan
    trials: Trials
    signature: Signature
    say: Callable[[str], None]
    master: int

    def work(self, study: optuna.Study, wanted: int, retry_lost: Callable[[], None]) -> None:
        """Do trials until there are as many as wanted, those of others counted.

        Others may die: the last trials are waited for, and done again where they are lost.
        """
        while (done := tried(study)) < wanted:
            self._end_with_master()
            retry_lost()
            if done + len(running(study)) < wanted:
                study.optimize(self._trial, n_trials=1)
            else:
                time.sleep(LOOK_AGAIN)

    def _trial(self, trial: optuna.Trial) -> float:
        self.signature.sign(trial)
        values = self.plan.suggested(trial)
        try:
            return self._scored(trial, values)
        except TrialPruned as pruned:
            self.say(f"trial {trial.number}: given up, {pruned}")
            raise
        except KeyboardInterrupt:
            # Optuna would take it for the trial's failure; so it is lost, and tried again.
            raise SystemExit(130) from None

    def _scored(self, trial: optuna.Trial, values: dict[str, Value]) -> float:
        try:
            params = self.plan.trial_params(values)
        except InputError as error:
            raise TrialPruned(str(error)) from None
        with (
            recorded_trial(self.plan, trial.study.study_name, trial.number, params) as record,
            _folder(self.plan) as folder,
        ):
            score = self.trials.score(params, Path(folder), self._watch(trial, record))
        self.say(f"trial {trial.number}: {self.plan.settings.score} {score:.4g}")
        return score

    def _watch(self, trial: optuna.Trial, record: TrialRecord) -> Watch:
        settings = self.plan.settings

        def watch(step: int, score: float) -> None:
            self._end_with_master()
            record.scores[step] = score
            if not math.isfinite(score):
                raise TrialPruned(f"{settings.score} {score} after {settings.step} {step}")
            trial.report(score, step)
            if trial.should_prune():
                raise TrialPruned(f"{settings.score} {score:.4g} after {settings.step} {step}")

        return watch

    def _end_with_master(self) -> None:
        """End where nobody waits any more; the trial is lost, and tried again."""
        if os.getppid() != self.master:
            raise SystemExit(1)


def work(plan: Plan, name: str, wanted: int, url: str | None, say: Callable[[str], None]) -> None:
    """Do trials of a study until it has as many as wanted."""
    study = load_study(plan, name, url)
    with Signature(plan.scratch / "workers") as signature:
        worker = Worker(plan, trials_of(plan), signature, say, os.getppid())
        if url is None:
            worker.work(study, wanted, lambda: signature.retry_lost(study))
        else:
            worker.work(study, wanted, lambda: optuna.storages.fail_stale_trials(study))


def trials_of(plan: Plan) -> Trials:
    """Return what the trials of a plan train."""
    if isinstance(plan.settings, PredictorSweep):
        from pipeline.sweeps.predictor_trial import PredictorTrials

        return PredictorTrials(plan.root, plan.settings, plan.trial_params({}))
    from pipeline.sweeps.policy_trial import PolicyTrials

    return PolicyTrials(plan.settings)


def _folder(plan: Plan) -> "tempfile.TemporaryDirectory[str]":
    """A folder for a trial's checkpoints; what a killed one leaves is removed with the scratch."""
    parent = plan.scratch / "trials"
    parent.mkdir(parents=True, exist_ok=True)
    return tempfile.TemporaryDirectory(dir=parent)


def main(sweep: str, study: str, wanted: int) -> None:
    """Work on a study of this repository."""

    def say(line: str) -> None:
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()

    work(load_plan(repository_root(), sweep), study, wanted, os.environ.get(STUDY), say)


if __name__ == "__main__":
    try:
        main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    except InputError as error:
        refuse(error)
