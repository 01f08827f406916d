"""The same arithmetic on x86-64 processors of a maker, so that the same inputs give the same bytes.

numpy, OpenBLAS, MKL, oneDNN and torch choose instructions by the processor. Wider ones add in
another order, the last bits differ, and a training amplifies the difference. All are limited to
AVX2, which every such processor of the last ten years has. The threads of OpenBLAS add in another
order as well: it has one, whatever the number of cores. They read the environment when they are
loaded, so it is set before the first of them: by the command line, by the stages, and by
``python -m rallygap.…``. Importing rallygap into another program sets nothing.

MKL, which multiplies torch's matrices, still adds in another order on AMD's processors than on
Intel's; ``MKL_CBWR=COMPATIBLE`` makes them alike, in 1.7 times the time (docs/decisions.md).
"""

import os
import platform
import sys

ARITHMETIC = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_CBWR": "AVX2",
    "ONEDNN_MAX_CPU_ISA": "AVX2",
    "ATEN_CPU_CAPABILITY": "avx2",
}


def hold_arithmetic() -> None:
    """Set the environment of the libraries where the user has not; child processes inherit it."""
    if platform.machine() in ("x86_64", "AMD64"):
        for name, value in ARITHMETIC.items():
            os.environ.setdefault(name, value)


def is_program(package: str) -> bool:
    """Return whether ``python -m`` is importing a package in order to run one of its modules."""
    # So it is documented: while the module is located, sys.argv starts with -m.
    if sys.argv[:1] != ["-m"]:
        return False
    return sys.orig_argv[-len(sys.argv)].removeprefix("-m").startswith(f"{package}.")
