"""How old the kept runs are that the documentation quotes."""

from pathlib import Path

from pipeline.experiments.stale import age_sentence

RUNS = ("paper", "real", "policies", "shots")


def kept_runs(root: Path) -> str:
    """Return a list of the kept runs with their commits, and whether the code has changed since."""
    return "\n".join(f"- `{run}`: {age_sentence(root, root / 'reports' / run)}" for run in RUNS)


def age_of(root: Path, run: str) -> str:
    """Return the commit of one kept run, and whether the code has changed since."""
    return age_sentence(root, root / "reports" / run)
