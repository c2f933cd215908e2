"""Settings and order of all tests."""

import gc
import os
from collections import Counter

import pytest
from hypothesis import HealthCheck, settings

# Tests run in one process per core, and matrices of these sizes are slower on several threads.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Terminal output must not depend on the environment. A test sets the variables that it needs.
for name in ("CI", "NO_COLOR", "FORCE_COLOR", "COLUMNS", "LINES"):
    os.environ.pop(name, None)

# Tests must not fail on a busy machine.
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")

#: Module that compiles the kernels of filter and smoother, which most other modules need.
COMPILING_MODULE = "tests/calibration/calibration/test_followup.py"
#: Folders whose tests need no kernels.
WITHOUT_KERNELS = ("tests/mgeo/", "tests/security/")


@pytest.hookimpl(tryfirst=True)  # Marks must be added before tests are selected by them.
def pytest_collection_modifyitems(items):
    """Mark parameters beyond the first ``cases`` as slow, and sort the test modules.

    The order prevents two workers from compiling the same kernel at the same time.
    """
    counts = Counter()
    for item in items:
        if mark := item.get_closest_marker("cases"):
            test = item.nodeid.partition("[")[0]
            counts[test] += 1
            if counts[test] > mark.args[0]:
                item.add_marker("slow")
    items.sort(key=lambda item: _get_rank(item.nodeid))


def _get_rank(nodeid):
    if nodeid.startswith(COMPILING_MODULE):
        return 0
    return 1 if nodeid.startswith(WITHOUT_KERNELS) else 2


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Disable garbage collection while tests are collected, because all objects are kept."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
