"""Settings of all tests."""

import os
import time

import pytest
from hypothesis import HealthCheck, settings

# one process a core: matrices of these sizes are slower on several threads, which wait by spinning
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# what they make of a terminal is the same on every machine: each test sets what it is about
for name in ("CI", "NO_COLOR", "FORCE_COLOR", "COLUMNS", "LINES"):
    os.environ.pop(name, None)

# a busy machine is no fault of a test
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")


_seconds: dict[str, float] = {}


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_protocol(item):
    """Measure coverage by the first case of a test that takes long: others mostly go the same ways.

    Python takes half as long again where it is traced.
    """
    test = item.nodeid.partition("[")[0]
    if _seconds.get(test, 0.0) > 0.1:
        item.add_marker("no_cover")
    start = time.process_time()
    yield
    _seconds[test] = time.process_time() - start
