"""Signals, kills, pipes and failing stages: 31 to 35 and 38 of "Bad input" in docs/rules.md."""

from __future__ import annotations

import array
import fcntl
import json
import mmap
import os
import random
import re
import signal
import subprocess
import sys
import termios
from pathlib import Path
from typing import IO, Any

import pytest
from faults import Program, own_threads, packets, video
from media import make_clip
from waiting import LONG, eventually

from vidstyle import cli
from vidstyle.cpu.passthrough import PassthroughRenderer
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.film_writer import FilmWriter

ROOT = Path(__file__).parents[2]
RENDER = [sys.executable, "-m", "vidstyle", "render", "--style", "plain"]


@pytest.fixture(scope="module")
def long_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A film that takes some ten seconds to encode with the options of `start`."""
    folder = tmp_path_factory.mktemp("long")
    return make_clip(folder / "long.mp4", frames=300, size=(320, 180), audio_tracks=1)


def start(clip: Path, target: Path, frames: int = 10) -> subprocess.Popen[str]:
    """Start a render and wait until it has written at least N frames."""
    options = ["--size", "480x270", "--preset", "medium", "--progress", "json"]
    process = subprocess.Popen([*RENDER, *options, str(clip), str(target)], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    for line in process.stderr:
        if frames_in(line) >= frames:
            return process
    raise AssertionError("it never began")


def frames_in(line: str) -> int:
    """How many frames are written by a line of progress; 0 by any other line."""
    found = re.search(r'"frames": (\d+)', line)
    return int(found[1]) if found else 0


def messages(lines: list[str]) -> list[dict[str, Any]]:
    """Return the events on standard error, which contains only JSON, except progress events."""
    return [event for event in map(json.loads, lines) if event["event"] != "progress"]


@pytest.mark.parametrize(
    ("number", "exit_code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129)]
)
def test_31_and_32_a_signal_closes_the_film(long_clip: Path, tmp_path: Path, number, exit_code):
    # The encoder may hold a second, of which a slow machine flushes little.
    process = start(long_clip, tmp_path / "out.mp4", random.Random(number).randint(45, 85))
    process.send_signal(number)
    _, said = process.communicate(timeout=LONG)
    assert process.returncode == exit_code, said
    partial = tmp_path / "out.partial.mp4"
    assert sorted(os.listdir(tmp_path)) == ["out.mp4.partial.jsonl", partial.name]
    told = [event["text"] for event in messages(said.splitlines())]
    assert len(told) == 1 and str(partial) in told[0]
    # Far from all: rendering stopped.
    assert 5 < len(video(partial)) < 250
    assert packets(partial, "audio") == packets(long_clip, "audio")[: len(packets(partial, "audio"))]


def test_31_a_second_signal_ends_at_once_and_the_film_still_plays(long_clip: Path, tmp_path: Path):
    process = start(long_clip, tmp_path / "out.mp4", 60)
    process.send_signal(signal.SIGINT)
    # Two signals of one kind at once are one, so that some more are sent.
    eventually(lambda: process.poll() is not None or process.send_signal(signal.SIGINT))
    process.communicate(timeout=LONG)
    assert process.returncode == 130
    assert len(video(tmp_path / "out.partial.mp4")) > 5


def test_33_killed_films_play(long_clip: Path):
    kill(
        2,
        "--film",
        str(long_clip),
        "--within",
        "1",
        "--options",
        "--size 960x540 --preset veryfast",
    )


@pytest.mark.thorough
def test_33_films_killed_at_any_time_play():
    options = ["--repeats", "3", "--within", "2", "--seed", os.environ["VIDSTYLE_TEST_SEED"]]
    options += ["--options", "--size 640x360 --preset veryfast", "--resume", "2", "--pairs", "3"]
    options += ["--neighbors", "3"]
    kill(9, *options, "--endings", ".mp4", ".mkv", ".mov")


def kill(times: int, *options: str) -> None:
    command = [sys.executable, str(ROOT / "tools" / "kill_test.py"), "--times", str(times)]
    ended = subprocess.run([*command, *options], capture_output=True, text=True, timeout=20 * LONG, cwd=ROOT)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_33_a_file_that_is_no_leftover_is_refused(program: Program):
    clip = make_clip(program.folder / "clip.mp4", frames=3)
    (program.folder / "out.partial.mp4").write_bytes(b"mine")
    for options in ([], ["-y"]):
        outcome = program(clip, "out.mp4", *options)
        assert outcome.exit_code == 2 and "rename or remove it" in outcome.said
        assert outcome.left == ["out.partial.mp4"]


def test_34_standard_output_closed_early(long_clip: Path):
    options = ["--format", "nut", "--codec", "libx264", "--preset", "ultrafast", "--crf", "1"]
    options += ["--progress", "json"]
    command = [*RENDER, *options, str(long_clip), "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.read(1_000_000)
        process.stdout.close()
        lines = process.stderr.read().decode().splitlines()
    assert process.returncode in (0, 5)
    assert max(map(frames_in, lines), default=0) < 250  # it did not go on
    said = [event["text"] for event in messages(lines)]
    assert len(said) <= 1 and not re.search("Traceback|bug", "".join(said))


def test_35_a_slow_reader_loses_nothing_and_fills_no_memory(long_clip: Path, tmp_path: Path):
    options = ["--format", "y4m", "--size", "640x360", "--progress", "none", "--frames", "100"]
    process = subprocess.Popen([*RENDER, *options, str(long_clip), "-"], stdout=subprocess.PIPE)
    target = tmp_path / "out.y4m"
    memory = []
    with target.open("wb") as file, process:
        assert process.stdout is not None
        while part := process.stdout.read(500_000):
            file.write(part)
            # Never faster than the writer, who has filled the pipe and waits.
            eventually(lambda: is_full(process.stdout) or process.poll() is not None)
            memory.append(resident(process.pid))
    assert process.returncode == 0
    assert len(video(target)) == 100
    settled = [size for size in memory if size][len(memory) // 3 :]
    assert max(settled) - min(settled) < 10 * 2**20


def is_full(pipe: IO[bytes]) -> bool:
    """Whether no more fits into a pipe, or not another page."""
    waiting = array.array("i", [0])
    fcntl.ioctl(pipe, termios.FIONREAD, waiting)
    return waiting[0] > fcntl.fcntl(pipe, fcntl.F_GETPIPE_SZ) - mmap.PAGESIZE


def resident(pid: int) -> int:
    """Memory in RAM, in bytes; 0 when the process is gone."""
    try:
        return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except (FileNotFoundError, ProcessLookupError, IndexError):
        return 0


def fail_at(number: int, original):  # type: ignore[no-untyped-def]
    """The function, raising at its call of this number."""
    calls = iter(range(1, 10_000))

    def failing(*arguments, **named):  # type: ignore[no-untyped-def]
        if next(calls) == number:
            raise RuntimeError("injected")
        return original(*arguments, **named)

    return failing


def failing_reader(original):  # type: ignore[no-untyped-def]
    def iterate(self):  # type: ignore[no-untyped-def]
        for number, item in enumerate(original(self)):
            if number == 40:
                raise RuntimeError("injected")
            yield item

    return iterate


@pytest.mark.parametrize("stage", ["read", "style", "write"])
def test_38_a_stage_that_fails_ends_all(tmp_path: Path, monkeypatch, capfd, stage):
    clip = make_clip(tmp_path / "clip.mp4", frames=90)
    target = tmp_path / "out.mp4"
    if stage == "read":
        monkeypatch.setattr(Reader, "__iter__", failing_reader(Reader.__iter__))
    elif stage == "style":
        monkeypatch.setattr(PassthroughRenderer, "restyle", fail_at(40, PassthroughRenderer.restyle))
    else:
        monkeypatch.setattr(FilmWriter, "write", fail_at(40, FilmWriter.write))
    running = own_threads()
    exit_code = cli.main(["render", "--style", "plain", "--progress", "none", str(clip), str(target)])
    said = capfd.readouterr().err
    partial = tmp_path / "out.partial.mp4"
    assert exit_code == 1 and said.count("\n") == 1, said
    assert "injected" in said and str(partial) in said
    assert 10 < len(video(partial)) <= 40 and not target.exists()
    assert not own_threads() - running


LOADED = r"""import av, numpy, re
print(re.search(r"VmPeak:\s+(\d+)", open("/proc/self/status").read())[1])"""
"""Prints the address space of the libraries, in KiB; with less, they end the process themselves."""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only Linux limits the address space")
def test_a_small_address_space_is_named_as_the_cause(tmp_path: Path) -> None:
    """Neither the encoder nor a bug is. The limits approach the need, which depends on the machine.

    One thread: libraries that cannot start another may end the process.
    """
    make_clip(tmp_path / "in.mp4", frames=5, size=(256, 144))
    arguments = ["render", tmp_path / "in.mp4", tmp_path / "out.mp4", "-y", "-s", "plain", "--threads", "1"]
    command = [sys.executable, "-m", "vidstyle", *map(str, arguments), "--progress", "none"]
    one_thread = os.environ | {"OPENBLAS_NUM_THREADS": "1"}

    def suffices(kibibytes: int) -> bool:
        limited = ["sh", "-c", f'ulimit -v {kibibytes}; exec "$@"', "sh", *command]
        done = subprocess.run(limited, capture_output=True, text=True, timeout=LONG, env=one_thread)
        if done.returncode:
            assert done.returncode == 5, done.stderr
            assert "not enough memory; " in done.stderr.splitlines()[-1]
        return done.returncode == 0

    too_little = int(subprocess.check_output([sys.executable, "-c", LOADED], env=one_thread))
    enough = 4 << 20
    assert not suffices(too_little) and suffices(enough)
    while enough - too_little > 16 << 10:
        middle = (too_little + enough) // 2
        too_little, enough = (too_little, middle) if suffices(middle) else (middle, enough)
