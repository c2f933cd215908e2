import os
import signal

import pytest

from mgeo.cli.errors import StopRequest, collect_stop_requests, print_warning


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_is_noted_and_the_handlers_are_put_back(number, code):
    before = signal.getsignal(number)
    with collect_stop_requests() as request:
        assert not request
        assert request.exit_code == 0
        os.kill(os.getpid(), number)
        assert request
        assert request.exit_code == code
    assert signal.getsignal(number) is before


def test_the_second_signal_interrupts_and_later_ones_do_not():
    request = StopRequest()
    request.receive(signal.SIGTERM)
    with pytest.raises(KeyboardInterrupt):
        request.receive(signal.SIGINT)
    request.receive(signal.SIGINT)
    assert request.exit_code == 143  # of the first


def test_a_warning_is_a_line_without_a_place_in_the_code(capsys):
    print_warning(RuntimeWarning("the budget\nis small"), RuntimeWarning, "solve.py", 3)
    assert capsys.readouterr().err == "Warning: the budget is small\n"
