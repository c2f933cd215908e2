"""Settings of all tests."""

import os

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
