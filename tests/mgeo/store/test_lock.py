import subprocess
import sys

import pytest

from mgeo.store.atomic import lock

HOLD = "import sys, time\nfrom pathlib import Path\nfrom mgeo.store.atomic import lock\n" + (
    "with lock(Path(sys.argv[1])): print('in', flush=True); time.sleep(60)"
)


def test_one_process_holds_the_lock_of_a_folder_until_it_ends(tmp_path):
    with subprocess.Popen([sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE) as other:
        assert other.stdout.readline() == b"in\n"
        with pytest.raises(ValueError, match="is in use"), lock(tmp_path):
            pass
        other.kill()
    with lock(tmp_path, 10.0):
        pass
    assert list(tmp_path.iterdir()) == []
