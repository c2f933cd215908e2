"""Settings of all tests."""

import gc
import os
from collections import Counter

import pytest
from hypothesis import HealthCheck, settings

# one process per core: matrices of these sizes are slower on several threads
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# output for a terminal must not depend on the machine; a test sets the variables that it is about
for name in ("CI", "NO_COLOR", "FORCE_COLOR", "COLUMNS", "LINES"):
    os.environ.pop(name, None)

# a busy machine is no fault of a test
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")

#: This module compiles the kernels of the filter and of the smoother, which most others need.
COMPILES = "tests/calibration/calibration/test_followup.py"
#: These folders need no kernel.
WITHOUT_KERNELS = ("tests/mgeo/", "tests/security/")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(items):
    """Mark cases as slow, and order modules so that two workers do not compile the same kernel."""
    seen = Counter()
    for item in items:
        if mark := item.get_closest_marker("cases"):
            test = item.nodeid.partition("[")[0]
            seen[test] += 1
            if seen[test] > mark.args[0]:
                item.add_marker("slow")
    items.sort(key=lambda item: _turn(item.nodeid))


def _turn(nodeid):
    if nodeid.startswith(COMPILES):
        return 0
    return 1 if nodeid.startswith(WITHOUT_KERNELS) else 2


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Collect no garbage while modules are imported and tests are found, which all stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()
