"""Generation, compilation and caching of the filter step of a sensor suite and of the common
driver.

The generated step is called the kernel. A module is stored in the user's cache folder under a hash
of its source and of everything that affects its compilation, and numba stores the machine code in
the same folder. A suite is therefore compiled once per machine. Two processes that start at the
same time both compile and write the same bytes. Threads of one process take turns.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from importlib import resources
from pathlib import Path
from types import ModuleType

import llvmlite
import llvmlite.binding
import numba
import numpy as np
import platformdirs

from mgeo.store.atomic import write_file
from mgeo_attitude import _compiled
from mgeo_attitude._typing import Floats
from mgeo_attitude.filter import discretization, polynomials
from mgeo_attitude.filter.codegen import build_module_source
from mgeo_attitude.filter.lanewise import lanewise
from mgeo_attitude.filter.layout import NO_MONITORS, Monitors
from mgeo_attitude.sensors.suite import Suite

_log = logging.getLogger(__name__)

# The lock is needed because a module is in sys.modules before its execution is finished.
_load_lock = threading.Lock()


@cache
def count_lanes() -> int:
    """Return the number of float64 values in a vector register, which is 4 or 8.

    One call of the compiled filter step processes this number of candidates.
    """
    features = llvmlite.binding.get_host_cpu_features()
    return 8 if features.get("avx512f") else 4


@cache
def load_kernel(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> ModuleType:
    """Load the compiled filter step of a sensor suite, or compile it if necessary.

    The C function ``step`` of the module advances all candidates by one step. The C function
    ``check`` computes the last Cholesky pivot of each covariance.

    Parameters
    ----------
    suite : Suite
    gated : tuple of bool
        For each sensor, whether it is unavailable at some samples.
    monitors : Monitors
        Path constraints and required 1-sigmas to monitor.
    """
    return load_module(
        "kernel", build_module_source(suite, gated, monitors, count_lanes()), [lanewise]
    )


@cache
def load_driver() -> ModuleType:
    """Return the compiled version of the module `driver.py`, which contains the loop over filter
    steps.
    """
    source = resources.files(__package__).joinpath("driver.py").read_text(encoding="utf-8")
    return load_module("driver", source, [discretization, polynomials, lanewise])


def load_module(
    kind: str,
    source: str,
    dependencies: Iterable[ModuleType | Callable[..., object]],
    part: str = "",
) -> ModuleType:
    """Load a compiled module from memory or from the user's cache, or compile its source.

    If several threads request modules at once, one thread loads a module while the others wait.

    Parameters
    ----------
    kind : str
        Kind of the module, which is also the name of its folder in the cache.
    source : str
        Source of the module.
    dependencies : iterable of modules or functions
        Modules whose compiled functions the module calls; a function represents its module. A
        change in one of them recompiles the module.
    part : str
        Name of the module among those of its kind, for the log.
    """
    parts = [source, numba.__version__, llvmlite.__version__, np.__version__, sys.version]
    modules = [
        _compiled,
        *(inspect.getmodule(dependency) or dependency for dependency in dependencies),
    ]
    parts += map(inspect.getsource, modules)
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    name = f"{kind}_{digest[:16]}"
    with _load_lock:
        if name not in sys.modules:
            _load_or_compile(kind, name, source, part)
        return sys.modules[name]


def _load_or_compile(kind: str, name: str, source: str, part: str) -> None:
    folder = Path(os.environ.get("MGEO_CACHE_DIR") or platformdirs.user_cache_dir("mgeo"))
    path = folder / f"{kind}s" / f"{name}.py"
    cached = any(path.parent.glob(f"__pycache__/{name}.*.nbi"))
    if not cached:
        description = f"the {kind} of the filter{part and f' ({part})'}"
        _log.warning(f"compiling {description}, once per machine (some seconds)")
    start = time.perf_counter()
    try:
        if not path.exists():
            path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
            write_file(path, source.encode())
        _execute(name, str(path), source)
    except OSError as error:
        warnings.warn(
            f"the kernel cache {folder} cannot be used ({error}); compiling in memory, which is "
            "repeated in every process. Set MGEO_CACHE_DIR to a writable folder.",
            stacklevel=3,
        )
        _execute(name, name, source.replace("cache=True", "cache=False"))
    else:
        if not cached:
            _log.warning(f"compiled in {time.perf_counter() - start:.1f} s, stored in {folder}")


def _execute(name: str, filename: str, source: str) -> None:
    """Execute the source of a module after registering the module in ``sys.modules`` for numba."""
    module = sys.modules[name] = ModuleType(name)
    try:
        exec(compile(source, filename, "exec"), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise


def compute_transition(
    suite: Suite, rate: Sequence[float], duration: float
) -> tuple[Floats, Floats]:
    """Compute the transition matrix and the process noise of attitude and gyro errors in one step.

    The body rate is constant.

    Parameters
    ----------
    suite : Suite
    rate : sequence of float, shape (3,)
        Body rate [rad/s].
    duration : float
        Length of the step [s].

    Returns
    -------
    F, Q : arrays, shape (n_dynamic, n_dynamic)
    """
    A, density = suite.dynamics_matrix(np.array(rate)), suite.compute_noise_density()
    F, Q = load_driver().discretize_compiled(A, density, duration)
    return F, Q
