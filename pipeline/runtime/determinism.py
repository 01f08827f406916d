"""One arithmetic on every x86-64 processor, so that the same inputs give the same bytes elsewhere.

numpy, OpenBLAS, MKL, oneDNN and torch look at the processor and choose instructions by it. Wider
ones add up in another order, the last bits differ, and a training amplifies that. All are
held to AVX2, which every such processor of the last ten years has. They read the environment when
they are loaded, so this comes before the first of them.
"""

import os
import platform

ARITHMETIC = {
    "NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR",
    "OPENBLAS_CORETYPE": "Haswell",
    "MKL_CBWR": "AVX2",
    "ONEDNN_MAX_CPU_ISA": "AVX2",
    "ATEN_CPU_CAPABILITY": "avx2",
}


def hold_arithmetic() -> None:
    """Set what the libraries read, where nobody has; processes begun later inherit it."""
    if platform.machine() in ("x86_64", "AMD64"):
        for name, value in ARITHMETIC.items():
            os.environ.setdefault(name, value)
