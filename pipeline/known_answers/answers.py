"""Answers to questions: verdicts in parallel, each a file, so that a killed run resumes."""

import hashlib
import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path

from rallygap.models.ball.simulator import Simulator
from rallygap.models.gap.diagnose import diagnose
from rallygap.models.gap.fit.shots import Shots
from rallygap.models.gap.verdict import Verdict, VerdictError
from rallygap.pipeline.io.artifacts import write_text
from rallygap.pipeline.known_answers.design import PlantedError
from rallygap.pipeline.known_answers.planting import plant
from rallygap.pipeline.runtime.errors import InputError
from rallygap.pipeline.runtime.parallel import make_missing
from rallygap.pipeline.runtime.provenance import content_hash

# What verdicts depend on, besides the shots: packages, files and the libraries.
DEPENDENCIES = (
    "models/ball",
    "models/gap",
    "pipeline/known_answers/answers.py",
    "pipeline/known_answers/design.py",
    "pipeline/known_answers/folds.py",
    "pipeline/known_answers/planting.py",
    "pipeline/known_answers/references.py",
    "constraints.txt",
)


@dataclass(frozen=True)
class Diagnosis:
    """Shots and a simulator to compare, and where the verdict is kept.

    Attributes:
        file: of the verdict.
        shots: without the error.
        simulator: without the error.
        error: that is planted before the diagnosis, if any.
        references: values in the shots without the error, by identity.
        seed: of the error, where it is random.
    """

    file: Path
    shots: Shots
    simulator: Simulator
    error: PlantedError | None = None
    references: Mapping[str, float] = field(default_factory=dict)
    seed: int = 0


def verdicts(diagnoses: Sequence[Diagnosis], description: str) -> list[Verdict]:
    """Return the verdicts on all diagnoses; those whose file is there are not made again.

    Args:
        diagnoses: in folders that belong to their shots and to the code that they depend on.
        description: of the progress bar.

    Raises:
        InputError: a file that an earlier run left is broken.
    """
    make_missing({one.file: partial(_diagnose, one) for one in diagnoses}, description)
    return [_read(diagnosis.file) for diagnosis in diagnoses]


def fingerprint(root: Path, shots: Shots, folds: int) -> str:
    """Return a digest of all that the verdicts on a set depend on."""
    hashes = {name: content_hash(root / name) for name in DEPENDENCIES}
    digest = hashlib.sha256(json.dumps([hashes, folds]).encode())
    for one in fields(shots):
        digest.update(getattr(shots, one.name).tobytes())
    return digest.hexdigest()


def _diagnose(diagnosis: Diagnosis) -> None:
    simulator, shots = plant(
        diagnosis.error,
        diagnosis.simulator,
        diagnosis.shots,
        diagnosis.references,
        diagnosis.seed,
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # numerical warnings would hide the progress
        verdict = diagnose(shots, simulator)
    write_text(diagnosis.file, verdict.to_json())


def _read(file: Path) -> Verdict:
    try:
        return Verdict.load(file)
    except VerdictError:
        raise InputError(file, "is no verdict; remove it and run again") from None
