"""Finds, or generates and compiles, the filter step of a sensor suite, and the driver of all.

A module lives in the user's cache folder under a hash of its text and of everything
that goes into its compilation; numba keeps the machine code beside it. So a suite is compiled once
per machine. Two processes that start at once both compile and write the same bytes; threads of one
process take turns.
"""

from __future__ import annotations

import hashlib
import inspect
import logging
import os
import stat
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
from mgeo_attitude.filter.codegen import module_source
from mgeo_attitude.filter.lanewise import lanewise
from mgeo_attitude.filter.layout import NO_MONITORS, Monitors
from mgeo_attitude.sensors.suite import Suite

_log = logging.getLogger(__name__)

# A module is in sys.modules before it has been executed.
_loading = threading.Lock()


@cache
def lanes() -> int:
    """Candidates that one kernel call advances together: what fills a vector register."""
    features = llvmlite.binding.get_host_cpu_features()
    return 8 if features.get("avx512f") else 4


@cache
def load_kernel(
    suite: Suite, gated: tuple[bool, ...], monitors: Monitors = NO_MONITORS
) -> ModuleType:
    """Module of a suite, whose C functions ``step`` and ``check`` the driver calls.

    Parameters
    ----------
    gated : tuple of bool
        Which sensors are not available at every sample.
    monitors : Monitors
        What is watched along a run.
    """
    return load_module("kernel", module_source(suite, gated, monitors, lanes()), [lanewise])


@cache
def load_driver() -> ModuleType:
    """Compiled module of the text of `driver.py`; see its function ``run``."""
    source = resources.files(__package__).joinpath("driver.py").read_text(encoding="utf-8")
    return load_module("driver", source, [discretization, polynomials, lanewise])


def load_module(
    kind: str,
    source: str,
    ingredients: Iterable[ModuleType | Callable[..., object]],
    part: str = "",
) -> ModuleType:
    """A module from memory, the user's cache or its source.

    Of threads that ask for modules at once, one loads and the others wait.

    Parameters
    ----------
    kind : str
        What it is called, and where in the cache.
    source : str
        Its text.
    ingredients : modules, or a function for all of its module
        Whose compiled functions it calls: a change there must not find an old module.
    part : str
        Of several of a kind, what is told of it.
    """
    parts = [source, numba.__version__, llvmlite.__version__, np.__version__, sys.version]
    all_of = [_compiled, *(inspect.getmodule(each) or each for each in ingredients)]
    parts += map(inspect.getsource, all_of)
    digest = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    name = f"{kind}_{digest[:16]}"
    with _loading:
        if name not in sys.modules:
            _load(kind, name, source, part)
        return sys.modules[name]


def _load(kind: str, name: str, source: str, part: str) -> None:
    folder = Path(os.environ.get("MGEO_CACHE_DIR") or platformdirs.user_cache_dir("mgeo"))
    what = f"the {kind} of the filter{part and f' ({part})'}"
    message = f"compiling {what}, once per machine (some seconds)"
    begun = time.perf_counter()
    try:
        path = _stored(folder / f"{kind}s", name, source)
        kept = any(path.parent.glob(f"__pycache__/{name}.*.nbi"))
        if not kept:
            _log.warning(message)
        _execute(name, str(path), source)
        if not kept:
            _log.warning(f"compiled in {time.perf_counter() - begun:.1f} s, kept in {folder}")
        return
    except OSError as error:
        warnings.warn(
            f"kernel cache {folder} cannot be used ({error}); compiling in memory, again in every "
            "process. Set MGEO_CACHE_DIR to a folder of your own.",
            stacklevel=3,
        )
    _log.warning(message)
    _execute(name, name, source.replace("cache=True", "cache=False"))
    _log.warning(f"compiled in {time.perf_counter() - begun:.1f} s")


def _execute(name: str, filename: str, source: str) -> None:
    """Put a module into sys.modules, where numba looks for it already while it is executed."""
    module = sys.modules[name] = ModuleType(name)
    try:
        exec(compile(source, filename, "exec"), module.__dict__)
    except BaseException:
        del sys.modules[name]
        raise


def _stored(folder: Path, name: str, source: str) -> Path:
    """Path of the module in a folder that only this user can write to."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    if hasattr(os, "getuid"):
        check_private(folder)
    path = folder / f"{name}.py"
    if not path.exists() or path.read_text(encoding="utf-8") != source:
        write_file(path, source.encode())
    return path


def check_private(folder: Path) -> None:
    """Refuse a folder that somebody else can write into, or put another one in the place of.

    What is in it is executed, and numba unpickles its own files there.

    Raises
    ------
    PermissionError
        Naming the folder, the one above it or below it that is not this user's alone.
    """
    real = folder.resolve()
    for inside in (real, real / "__pycache__"):
        if inside.exists() or inside.is_symlink():
            status = inside.lstat()
            shared = status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
            if status.st_uid != os.getuid() or shared or not stat.S_ISDIR(status.st_mode):
                raise PermissionError(f"{inside} belongs to, or can be written by, somebody else")
    for above in real.parents:
        status = above.stat()
        # many systems give each user a group of his own, which may write into his folders
        others = stat.S_IWOTH if status.st_gid == os.getgid() else stat.S_IWOTH | stat.S_IWGRP
        shared = status.st_mode & others and not status.st_mode & stat.S_ISVTX
        if status.st_uid not in (os.getuid(), 0) or shared:
            raise PermissionError(f"{above} belongs to, or can be written by, somebody else")


def transition(suite: Suite, rate: Sequence[float], duration: float) -> tuple[Floats, Floats]:
    """F and Q of the dynamic states over a step at constant rate, equation (7).

    Both are of shape (n_dynamic, n_dynamic), for a body rate [rad/s] and the step's duration [s].
    """
    A, density = suite.dynamics_matrix(np.array(rate)), suite.diffusion()
    F, Q = load_driver().discretized(A, density, duration)
    return F, Q
