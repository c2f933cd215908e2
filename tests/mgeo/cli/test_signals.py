"""Signals during a run, and warnings."""

import os
import signal

import pytest

from mgeo.cli.errors import StopRequest, collect_stop_requests, print_warning


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signal_is_stored_and_handlers_are_restored(number, code):
    before = signal.getsignal(number)
    with collect_stop_requests() as request:
        assert not request
        assert request.exit_code == 0
        os.kill(os.getpid(), number)
        assert request
        assert request.exit_code == code
    assert signal.getsignal(number) is before


def test_only_the_second_signal_interrupts():
    request = StopRequest()
    request.receive(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt):
        request.receive(signal.SIGINT)
    request.receive(signal.SIGINT)
    assert request.exit_code == 143  # The first signal sets the exit code.


def test_warning_is_one_line_without_a_code_location(capsys):
    print_warning(RuntimeWarning("the budget\nis small"), RuntimeWarning, "solve.py", 3)
    assert capsys.readouterr().err == "Warning: the budget is small\n"
