"""Shared parts of the nodes of the friction graph: input alignment, parameters, QoS, diagnostics.

Importing it limits BLAS to one thread: every process that runs estimators does, and no other place sets it.
"""

from friction_runtime.blas_threads import use_one_blas_thread

use_one_blas_thread()
