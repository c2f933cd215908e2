"""Settings of all tests."""

import gc
import os
from collections import Counter

import pytest
from hypothesis import HealthCheck, settings

try:
    import resource  # noqa: F401
except ImportError:  # Windows: these limit and measure what a process takes
    collect_ignore = ["benchmarks/test_load.py", "campaign/test_campaign.py"]

# one process a core: matrices of these sizes are slower on several threads, which wait by spinning
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# what they make of a terminal is the same on every machine: each test sets what it is about
for name in ("CI", "NO_COLOR", "FORCE_COLOR", "COLUMNS", "LINES"):
    os.environ.pop(name, None)

COMPILES = "tests/calibration/calibration/test_after.py"  # the filter and the smoother
COMPILED = (
    *(f"tests/{name}/" for name in ("attitude", "benchmarks", "calibration", "campaign", "suite")),
    *(f"tests/{name}.py" for name in ("docs/test_pages", "test_readme")),
)
#: They compile, too, and take longest: the first of those that do.
PAGES = ("tests/docs/test_reference", "tests/test_docs_", "tests/test_plans_doc")

# a busy machine is no fault of a test
settings.register_profile(
    "any machine", deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("any machine")


@pytest.hookimpl(tryfirst=True)  # before tests are chosen by their marks
def pytest_collection_modifyitems(config, items):
    """Put first what compiles most, then what compiles nothing: on two workers not both compile."""
    _mark_cases(items)
    items.sort(key=lambda item: _turn(item.nodeid))
    if config.pluginmanager.hasplugin("_cov"):
        _cover_each_test_once(items)


def _mark_cases(items):
    """Of ``cases(fast)`` the other parameters are slow, of ``cases(fast, n)`` after n campaign."""
    seen = Counter()
    for item in items:
        if mark := item.get_closest_marker("cases"):
            fast, *slow = mark.args
            test = item.nodeid.partition("[")[0]
            seen[test] += 1
            if seen[test] > fast:
                item.add_marker("slow")
            if slow and seen[test] > slow[0]:
                item.add_marker("campaign")


def _turn(nodeid):
    if nodeid.startswith(COMPILES):
        return 0
    return 2 if nodeid.startswith(PAGES) else 1 + 2 * nodeid.startswith(COMPILED)


def _cover_each_test_once(items):
    """Of a test with many parameters measure the first: traced, Python takes half as long again."""
    seen = set()
    for item in items:
        test = item.nodeid.partition("[")[0]
        if test in seen:
            item.add_marker("no_cover")
        seen.add(test)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no garbage while modules are imported and tests are found, which all stay."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()


def pytest_collection_finish():
    """Keep the garbage collector from going through thousands of modules and tests ever again."""
    gc.collect()
    gc.freeze()
