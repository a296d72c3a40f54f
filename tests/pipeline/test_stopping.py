"""Signals: the first one stops cleanly, the second one exits at once."""

from __future__ import annotations

import os
import signal
import subprocess
import sys

import pytest
from media import make_clip, make_picture
from waiting import LONG

from vidstyle import cli
from vidstyle.media.write.atomic import OutputFile
from vidstyle.pipeline.stopping import stop_on_signals


@pytest.mark.parametrize(
    ("number", "exit_code"), [(signal.SIGHUP, 129), (signal.SIGINT, 130), (signal.SIGTERM, 143)]
)
def test_a_signal_asks_to_stop_and_the_handlers_come_back(number, exit_code):
    before = signal.getsignal(number)
    with stop_on_signals() as stop:
        assert not stop.is_set()
        os.kill(os.getpid(), number)
        assert stop.wait(LONG)
        assert stop.exit_code == exit_code
    assert signal.getsignal(number) == before


@pytest.mark.parametrize(
    ("arguments", "number", "exit_code"),
    [
        (["comic", "film.mp4", "page.png", "--storyboard"], signal.SIGTERM, 143),
        (["train", "bank.npz", "--images", ".", "--reference", "detail_base"], signal.SIGHUP, 129),
    ],
)
def test_a_command_that_is_stopped_says_so_and_leaves_nothing(
    tmp_path, monkeypatch, capfd, arguments, number, exit_code
):
    monkeypatch.chdir(tmp_path)
    make_clip(tmp_path / "film.mp4", frames=3, size=(64, 48))
    for name in ("a.png", "b.png"):
        make_picture(tmp_path / name, size=(64, 48))
    before = sorted(os.listdir())
    left = []

    def stop(_: OutputFile) -> None:
        left.append(sorted(os.listdir()))
        os.kill(os.getpid(), number)

    monkeypatch.setattr(OutputFile, "finish", stop)
    assert cli.main(arguments) == exit_code
    assert left != [before] and sorted(os.listdir()) == before
    assert capfd.readouterr().err.splitlines()[-1] == "vidstyle: stopped"


def test_a_second_signal_ends_the_program_at_once():
    program = (
        "import os, signal, threading; from vidstyle.pipeline.stopping import stop_on_signals\n"
        "with stop_on_signals() as stop:\n"
        "    os.kill(os.getpid(), signal.SIGINT); assert stop.wait(10)\n"
        "    os.kill(os.getpid(), signal.SIGINT); threading.Event().wait(10); print('still here')\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, timeout=LONG)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, b"", b"")


def test_a_hangup_that_nohup_ignores_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with stop_on_signals() as stop:
            os.kill(os.getpid(), signal.SIGHUP)
            assert not stop.is_set()
    finally:
        signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize(("library", "said"), [("click", ""), ("av", "vidstyle: stopped")])
def test_an_interrupt_while_libraries_are_loaded_ends_the_program(library: str, said: str):
    program = (
        "import os, signal, sys\n"
        "class Interrupt:\n"
        "    def find_spec(self, name, *_):\n"
        f"        if name == {library!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "sys.meta_path.insert(0, Interrupt())\n"
        "sys.argv[1:] = ['render', 'a.mp4', 'b.mp4', '--style', 'plain']\n"
        "from vidstyle.__main__ import main\n"
        "sys.exit(main())\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert (ended.returncode, ended.stdout, ended.stderr.strip()) == (130, "", said)
