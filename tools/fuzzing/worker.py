"""A process that tries cases and reports the outcome of each."""

from __future__ import annotations

import gc
import logging
import multiprocessing
import os
import resource
import tempfile
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

import psutil

from tools.fuzzing.cases import Case, mutated
from tools.fuzzing.processes import MAX_MEMORY, SECONDS, BrokenPromiseError, answers, memory
from vidstyle.errors import VidstyleError

MAX_ADDRESSES = 2**33
"""Bytes of addresses that a worker may take, so that a find does not exhaust the machine."""
Trial = Callable[[Path, Path], None]
"""Uses a file, and writes into a folder."""


class Worker:
    """A process that tries one file after another; a new one is started after a crash or a hang."""

    def __init__(self, whole: dict[str, list[Path]], trial: Trial) -> None:
        self._arguments = whole, trial
        self._process: BaseProcess | None = None

    def outcome(self, case: Case, seconds: float = SECONDS) -> str:
        """Whether the file was used or refused, or what was found."""
        if self._process is None:
            self._start()
        self._pipe.send(case)
        try:
            answered = answers(psutil.Process(self._process.pid), self._pipe.poll, seconds)
            found = self._pipe.recv() if answered else "hang"
        except (EOFError, psutil.NoSuchProcess):
            self._process.join()
            found = f"crash: exit code {self._process.exitcode}"
        if found not in ("used", "refused"):
            self.close()
        return found

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(target=work, args=(far, *self._arguments), daemon=True)
        self._process.start()
        far.close()
        self._pipe.recv()


def work(pipe: Connection, whole: dict[str, list[Path]], trial: Trial) -> None:
    """Answer each case from the pipe by its outcome."""
    os.nice(10)
    logging.disable(logging.CRITICAL)  # a level would be changed by the command line
    resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESSES, MAX_ADDRESSES))
    gc.freeze()  # so that collecting garbage after each case takes little time
    pipe.send("ready")
    while True:
        kind, seed, number = pipe.recv()
        suffix, content = mutated(kind, seed, number, whole)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"case{suffix}")
            path.write_bytes(content)
            Path(folder, "out").mkdir()
            pipe.send(_outcome(trial, path, Path(folder, "out")))


def _outcome(trial: Trial, path: Path, folder: Path) -> str:
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak memory
    before = memory("VmRSS")
    try:
        trial(path, folder)
        found = "used"
    except VidstyleError:
        found = "refused"
    except BrokenPromiseError as error:
        found = str(error)
    except BaseException as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        found = f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}"
    gc.collect()
    more = memory("VmHWM") - before
    return f"memory: {more >> 20} MiB" if more > MAX_MEMORY else found
