"""Signals: the first one stops cleanly, the second one exits at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from waiting import LONG

from vidstyle.pipeline.stopping import stop_on_signals


@pytest.mark.parametrize(("number", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_asks_to_stop_and_the_handlers_come_back(number, exit_code):
    before = signal.getsignal(number)
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.wait(LONG)
        assert stop.exit_code == exit_code
    assert signal.getsignal(number) == before


def test_a_second_signal_ends_the_program_at_once():
    program = (
        "import os, signal, threading; from vidstyle.pipeline.stopping import stop_on_signals\n"
        "with stop_on_signals() as stop:\n"
        "    os.kill(os.getpid(), signal.SIGINT); assert stop.wait(10)\n"
        "    os.kill(os.getpid(), signal.SIGINT); threading.Event().wait(10); print('still here')\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=LONG)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, b"", b"")
