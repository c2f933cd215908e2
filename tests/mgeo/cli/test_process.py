"""Start-up of the command in a separate process."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from functools import partial

COMMAND = [sys.executable, "-m", "mgeo"]


@contextmanager
def start(arguments, environment, folder):
    """Context manager that runs ``mgeo`` as a process, and kills it at the end."""
    with subprocess.Popen(
        [*COMMAND, *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # nohup ignores it
    ) as process:
        try:
            yield process
        finally:
            process.kill()  # No effect if the process has ended.


BLAS = """
import atexit, os, sys
from mgeo.cli.app import main
assert "numpy" not in sys.modules
atexit.register(lambda: print(os.environ["OPENBLAS_NUM_THREADS"]))
sys.argv = ["mgeo", "--no-color", "schema", "study.toml"]
main()
"""


def test_blas_uses_one_thread():
    """The order of sums in several threads would change fronts of equal seeds."""
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    command = [sys.executable, "-c", BLAS]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, timeout=100
    )
    assert done.stdout.splitlines()[-1] == "1"
