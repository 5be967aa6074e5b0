"""One BLAS thread per process: our matrices are small, and the sums of several threads differ from run to run."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from typing import Any, Final

_VARIABLES: Final = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")
_LIBRARIES: Final = ("openblas", "mkl_rt", "blis")
_OPENBLAS: Final = [
    (f"{before}openblas_set_num_threads{after}", f"{before}openblas_get_num_threads{after}")
    for before, after in product(("", "scipy_"), ("", "64_"))
]
_FUNCTIONS: Final = (
    *_OPENBLAS,
    ("MKL_Set_Num_Threads", "MKL_Get_Max_Threads"),
    ("bli_thread_set_num_threads", "bli_thread_get_num_threads"),
)


def use_one_blas_thread() -> None:
    """Limit the BLAS libraries of this process and of its children, those that are loaded and those that will be."""
    os.environ.update(dict.fromkeys(_VARIABLES, "1"))
    for library in _loaded():
        for setter, _ in _FUNCTIONS:
            if hasattr(library, setter):
                getattr(library, setter)(1)


def blas_threads() -> list[int]:
    """Return the number of threads of each BLAS library that is loaded."""
    return [getattr(library, getter)() for library in _loaded() for _, getter in _FUNCTIONS if hasattr(library, getter)]


def _loaded() -> Iterator[Any]:
    """Yield the loaded libraries; none where the system does not list them, and the environment alone limits them."""
    maps = Path("/proc/self/maps")
    lines = maps.read_text(errors="replace").splitlines() if maps.exists() else []
    files = {fields[5] for line in lines if len(fields := line.split(maxsplit=5)) == 6}
    for file in sorted(files):
        if any(name in Path(file).name for name in _LIBRARIES):
            yield ctypes.CDLL(file)
