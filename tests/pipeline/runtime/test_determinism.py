"""Stages compute alike on every x86-64 processor."""

import os
import platform
import subprocess
import sys

import pytest

from rallygap.pipeline.runtime.determinism import ARITHMETIC

pytestmark = pytest.mark.skipif(
    platform.machine() not in ("x86_64", "AMD64"), reason="other processors have no AVX2"
)

LOADED = """
import rallygap.stages
import numpy, threadpoolctl, torch
from numpy._core._multiarray_umath import __cpu_features__ as features
print([name for name in ("X86_V4", "AVX512_ICL", "AVX512_SPR") if features[name]])
openblas = [one for one in threadpoolctl.threadpool_info() if one["internal_api"] == "openblas"]
print({(one["architecture"], one["num_threads"]) for one in openblas})
print(torch.backends.cpu.get_cpu_capability())
"""


def fresh(program, **environment):
    clean = {name: value for name, value in os.environ.items() if name not in ARITHMETIC}
    command = [sys.executable, "-W", "ignore", "-c", program]
    done = subprocess.run(
        command, env={**clean, **environment}, check=True, capture_output=True, text=True
    )
    return done.stdout.splitlines()


def test_libraries_use_one_thread_and_nothing_wider_than_avx2_but_what_a_user_sets():
    assert fresh(LOADED) == ["[]", "{('Haswell', 1)}", "AVX2"]
    program = "import os, rallygap.stages; print(os.environ['OPENBLAS_CORETYPE'])"
    assert fresh(program, OPENBLAS_CORETYPE="Zen") == ["Zen"]
