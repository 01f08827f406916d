"""Sim-to-sim: policies from imperfect simulators play in another, which counts as the truth."""

from rallygap.pipeline.policies.storage import load_policies
from rallygap.pipeline.runtime.stage_run import StageRun, run_stage
from rallygap.pipeline.transfer.sim2sim_report import report_sim2sim
from rallygap.pipeline.transfer.sim2sim_trials import sim2sim_trials
from rallygap.pipeline.transfer.trials import joined, run_trials


def sim2sim(run: StageRun) -> None:
    """Let every policy play the same shots, with the truth and its own simulator as predictors."""
    group, folder = run.params.sim2sim.group, run.input("train_policy", "")
    policies = load_policies(folder, group)
    run.log_input(f"policies of {group}", folder, len(policies))
    report_sim2sim(run, joined(run_trials(sim2sim_trials(run, policies))))


if __name__ == "__main__":
    run_stage(sim2sim)
