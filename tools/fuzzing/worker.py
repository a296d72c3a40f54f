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

from tools.fuzzing.cases import Case, make_file
from tools.fuzzing.processes import (
    MAX_MEMORY_BYTES,
    MAX_PROCESSOR_SECONDS,
    BrokenPromiseError,
    memory_bytes,
    wait_for_answer,
)
from vidstyle.errors import VidstyleError

MAX_ADDRESS_BYTES = 2**33
"""Address space of a worker, so that a finding does not exhaust the machine."""
Trial = Callable[[Path, Path], None]
"""Uses a file and writes to a folder."""


class Worker:
    """A process that tries files one after another; it is restarted after a crash or a hang."""

    def __init__(self, whole: dict[str, list[Path]], trial: Trial) -> None:
        self._arguments = whole, trial
        self._process: BaseProcess | None = None

    def outcome(self, case: Case, seconds: float = MAX_PROCESSOR_SECONDS) -> str:
        """Try a case and return "used", "refused", or a description of the finding."""
        process = self._process or self._start()
        self._pipe.send(case)
        try:
            answered = wait_for_answer(psutil.Process(process.pid), self._pipe.poll, seconds)
            found = self._pipe.recv() if answered else "hang"
        except (EOFError, psutil.NoSuchProcess):
            process.join()
            found = f"crash: exit code {process.exitcode}"
        if found not in ("used", "refused"):
            self.close()
        return found

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _start(self) -> BaseProcess:
        context = multiprocessing.get_context("spawn")
        self._pipe, far = context.Pipe()
        self._process = context.Process(target=serve_cases, args=(far, *self._arguments), daemon=True)
        self._process.start()
        far.close()
        self._pipe.recv()
        return self._process


def serve_cases(pipe: Connection, whole: dict[str, list[Path]], trial: Trial) -> None:
    """Send the outcome of each case received from the pipe."""
    os.nice(10)
    logging.disable(logging.CRITICAL)  # the command line would override a level
    resource.setrlimit(resource.RLIMIT_AS, (MAX_ADDRESS_BYTES, MAX_ADDRESS_BYTES))
    gc.freeze()  # makes collecting garbage after each case fast
    pipe.send("ready")
    while True:
        kind, seed, number = pipe.recv()
        suffix, content = make_file(kind, seed, number, whole)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, f"case{suffix}")
            path.write_bytes(content)
            Path(folder, "out").mkdir()
            pipe.send(_outcome(trial, path, Path(folder, "out")))


def _outcome(trial: Trial, path: Path, folder: Path) -> str:
    Path("/proc/self/clear_refs").write_text("5")  # resets the peak memory
    before = memory_bytes("VmRSS")
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
    more = memory_bytes("VmHWM") - before
    return f"memory: {more >> 20} MiB" if more > MAX_MEMORY_BYTES else found
