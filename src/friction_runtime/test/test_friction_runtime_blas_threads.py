"""One BLAS thread, whatever is imported first."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

BEFORE = "import numpy, scipy.linalg; import friction_runtime"
BETWEEN = "import numpy; import friction_runtime; import scipy.linalg"
AFTER = "import friction_runtime; import numpy, scipy.linalg"
SHOW = "from friction_runtime.blas_threads import blas_threads; print(blas_threads())"


def threads(code: str, show: str = SHOW) -> list[int]:
    """Run code in a new interpreter that may use all cores; return the threads of its BLAS libraries."""
    free = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    free["OPENBLAS_NUM_THREADS"] = "2"  # several on a machine with a single core, too
    command = [sys.executable, "-c", f"{code}\n{show}"]
    found = subprocess.run(command, env=free, capture_output=True, text=True, check=True).stdout
    return [int(each) for each in found.strip(" []\n").split(",") if each]


@pytest.mark.parametrize("code", [BEFORE, BETWEEN, AFTER])
def test_blas_has_one_thread_whichever_is_imported_first(code: str) -> None:
    found = threads(code)
    if not found:
        pytest.skip("this numpy has no BLAS with threads")
    assert set(found) == {1}


def test_without_the_limit_there_would_be_several() -> None:
    code = "import friction_runtime.blas_threads as limit, os; os.environ['OPENBLAS_NUM_THREADS'] = '2'; import numpy"
    found = threads(code)
    if not found:
        pytest.skip("this numpy has no BLAS with threads")
    assert max(found) > 1


def test_workers_of_a_pool_have_one_thread() -> None:
    code = """
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import friction_runtime
from friction_runtime.blas_threads import blas_threads

with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
    pool.submit(exec, "import scipy.linalg").result()
    print(pool.submit(blas_threads).result())
"""
    found = threads(code, show="")
    if not found:
        pytest.skip("this numpy has no BLAS with threads")
    assert set(found) == {1}
