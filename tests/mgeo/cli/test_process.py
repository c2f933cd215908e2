"""Start-up of the command as a process of its own."""

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from functools import partial

COMMAND = [sys.executable, "-m", "mgeo"]


@contextmanager
def started(arguments, environment, folder):
    with subprocess.Popen(
        [*COMMAND, *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),  # ignored under nohup
    ) as process:
        try:
            yield process
        finally:
            process.kill()  # does nothing to one that has ended


BLAS = """
import atexit, os, sys
from mgeo.cli.app import main
assert "numpy" not in sys.modules
atexit.register(lambda: print(os.environ["OPENBLAS_NUM_THREADS"]))
sys.argv = ["mgeo", "--no-color", "schema", "study"]
main()
"""


def test_blas_has_one_thread_however_many_processors_there_are():
    """It adds in another order in several: a seed's front and a study's tables would differ."""
    environment = {k: v for k, v in os.environ.items() if k != "OPENBLAS_NUM_THREADS"}
    command = [sys.executable, "-c", BLAS]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, check=True, timeout=100
    )
    assert done.stdout.splitlines()[-1] == "1"
