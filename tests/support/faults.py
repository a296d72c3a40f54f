"""Run the program with checks, and damage files, for the tests of bad input."""

from __future__ import annotations

import ctypes
import hashlib
import os
import re
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

import av
import numpy as np
import pytest

from vidstyle import cli

NOBODY_ID = 65534
"""User id without files."""


@dataclass(frozen=True)
class Outcome:
    """The result of a run.

    Attributes:
        exit_code: exit code of the program.
        lines: lines on standard error.
        target: path of the output.
    """

    exit_code: int
    lines: list[str]
    target: Path

    @property
    def said(self) -> str:
        """All lines as one text."""
        return "\n".join(self.lines)

    @property
    def left(self) -> list[str]:
        """Files in the folder of the target with its stem: the output, or its partial file."""
        return sorted(path.name for path in self.target.parent.glob(f"{self.target.stem}.*"))


class Program:
    """Runs `vidstyle render` in this process, and checks the invariants of every run."""

    def __init__(self, folder: Path, capfd: pytest.CaptureFixture[str]) -> None:
        self.folder = folder
        self._capfd = capfd

    def __call__(
        self, source: str | Path, target: str | Path = "out.mp4", *options: str, style: str = "plain"
    ) -> Outcome:
        """Render to a target in the folder of the test, without progress."""
        target = target if str(target) == "-" else self.folder / target
        before = _digests(Path(source))
        self._capfd.readouterr()
        arguments = [
            "render",
            "--style",
            style,
            "--progress",
            "none",
            *options,
            "--",
            str(source),
            str(target),
        ]
        running = own_threads()
        exit_code = cli.main(arguments)
        said = self._capfd.readouterr().err
        assert "Traceback" not in said and "Exception" not in said and "bug" not in said
        assert _digests(Path(source)) == before, "the input was changed"
        assert not own_threads() - running
        return Outcome(exit_code, said.splitlines(), Path(target))

    def refused(self, exit_code: int, words: str, *arguments: str | Path, **options: str) -> Outcome:
        """Check that a run fails with this exit code and a line with these words, and leaves no files."""
        outcome = self(*arguments, **options)
        assert outcome.exit_code == exit_code, outcome.said
        assert len(outcome.lines) == 1 and outcome.said.startswith("vidstyle: "), outcome.said
        assert words in outcome.said
        assert not list(self.folder.glob("**/*.partial.*"))
        return outcome


def own_threads() -> set[threading.Thread]:
    """Return the running threads of the package; new ones after a call are leftovers of it.

    Threads of `shared_workers`, which are started once and stay, are excluded.
    """
    names = re.compile("vidstyle(?!-bands)")
    return {thread for thread in threading.enumerate() if names.match(thread.name)}


def video(path: Path, cut_off: bool = False) -> list[av.VideoFrame]:
    """Decode all frames with PyAV only; of a file that is `cut_off`, up to the last complete one."""
    frames: list[av.VideoFrame] = []
    with av.open(str(path.absolute())) as container:
        for packet in container.demux(video=0):
            try:
                frames.extend(packet.decode())
            except av.InvalidDataError:
                assert cut_off
    return frames


def times(path: Path) -> list[float]:
    """Return the presentation times of all frames in seconds."""
    return [float(frame.pts * frame.time_base) for frame in video(path)]


def packets(path: Path, kind: str, number: int = 0) -> list[tuple[float, bytes]]:
    """Return time in seconds and content of each packet of stream `number` of a kind."""
    with av.open(str(path.absolute())) as container:
        stream = getattr(container.streams, kind)[number]
        found = [packet for packet in container.demux(stream) if packet.size and packet.pts is not None]
        return [(float(packet.pts * packet.time_base), bytes(packet)) for packet in found]


def cut(path: Path, share: float) -> Path:
    """Truncate a file to a share of its size."""
    path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
    return path


def damage_packets(path: Path, numbers: slice, seed: int = 1) -> Path:
    """Overwrite some video packets, numbered in file order, with noise."""
    with av.open(str(path.absolute())) as container:
        places = [(packet.pos, packet.size) for packet in container.demux(video=0) if packet.size]
    content = bytearray(path.read_bytes())
    noise = np.random.default_rng(seed)
    for start, size in places[numbers]:
        # After length and type of the first unit, so that the container stays intact.
        content[start + 5 : start + size] = noise.bytes(size - 5)
    path.write_bytes(content)
    return path


def remux(
    source: Path,
    target: Path,
    *,
    stamp: dict[int, int] | None = None,
    offset: float = 0,
    kinds: tuple[str, ...] = ("video", "audio", "subtitle"),
    **options: str,
) -> Path:
    """Copy all packets in decoding order to another container.

    Args:
        source, target: paths of the files.
        stamp: maps the number of a video packet to the packet whose presentation time it gets.
        offset: seconds by which all packets are shifted.
        kinds: kinds of streams to copy.
        options: muxer options.
    """
    with (
        av.open(str(source.absolute())) as given,
        av.open(str(target), "w", container_options=options) as made,
    ):
        streams = {
            stream.index: made.add_stream_from_template(stream)
            for stream in given.streams
            if stream.type in kinds
        }
        found = [packet for packet in given.demux() if packet.size and packet.stream.index in streams]
        pictures = [packet for packet in found if packet.stream.type == "video"]
        stamps = [packet.pts for packet in pictures]
        for number, other in (stamp or {}).items():
            pictures[number].pts = stamps[other]
        for packet in sorted(found, key=lambda packet: packet.dts * packet.time_base):
            # Decoding times must precede the changed presentation times.
            ahead = round(Fraction(1, 2) / packet.time_base) if stamp else 0
            move = round(Fraction(offset) / packet.time_base)
            packet.pts, packet.dts = packet.pts + move + ahead, packet.dts + move
            packet.stream = streams[packet.stream.index]
            made.mux(packet)
    return target


@contextmanager
def assert_not_opened(path: Path) -> Iterator[None]:
    """Assert that no library opens the file within the block (Linux inotify)."""
    libc = ctypes.CDLL(None, use_errno=True)
    watch = libc.inotify_init1(os.O_NONBLOCK)
    in_open = 0x20
    assert libc.inotify_add_watch(watch, os.fsencode(path), in_open) >= 0
    try:
        yield
        with pytest.raises(BlockingIOError):
            os.read(watch, 4096)
        path.read_bytes()
        assert struct.unpack_from("iI", os.read(watch, 4096))[1] & in_open, "the watch itself does not work"
    finally:
        os.close(watch)


@contextmanager
def drop_file_privileges() -> Iterator[None]:
    """Apply file modes to the superuser, too, within the block (Linux capabilities).

    Another user may have no access to the checkout and the folder of the test. Applies to this thread and the
    threads that it starts.
    """
    if os.geteuid() != 0:
        yield
        return
    libc = ctypes.CDLL(None, use_errno=True)
    version_3, dac_override, dac_read_search = 0x20080522, 1, 2
    header = (ctypes.c_uint32 * 2)(version_3, 0)
    effective_permitted_inheritable = (ctypes.c_uint32 * 6)()
    assert libc.capget(header, effective_permitted_inheritable) == 0
    before = effective_permitted_inheritable[0]
    effective_permitted_inheritable[0] &= ~(1 << dac_override | 1 << dac_read_search)
    assert libc.capset(header, effective_permitted_inheritable) == 0
    try:
        yield
    finally:
        effective_permitted_inheritable[0] = before
        assert libc.capset(header, effective_permitted_inheritable) == 0


def _digests(source: Path) -> str:
    try:
        return hashlib.sha256(source.read_bytes()).hexdigest() if source.is_file() else ""
    except (OSError, ValueError):
        return ""


_SMALL_PARENT = """
import resource, subprocess, sys
code = subprocess.call(sys.argv[1:], stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(code)
"""
"""Runs a command from a small process, because a new process first counts the memory of its parent."""
MEMORY_UNIT_BYTES = 1 if sys.platform == "darwin" else 1024
"""Unit of `ru_maxrss`."""


class Measured(NamedTuple):
    """Exit code, standard error and peak memory of a command."""

    exit_code: int
    errors: str
    peak_bytes: int


def measure_peak_memory(command: Sequence[str | Path]) -> Measured:
    """Run a command and measure its peak memory, independently of the test process."""
    parent = [sys.executable, "-c", _SMALL_PARENT, *map(str, command)]
    done = subprocess.run(parent, capture_output=True, text=True)
    return Measured(done.returncode, done.stderr, int(done.stdout) * MEMORY_UNIT_BYTES)
