"""A program as the reference filter of a bank: it reads a picture file and writes another."""

from __future__ import annotations

import shlex
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

from vidstyle.blade.photographs import Photograph
from vidstyle.blade.reference_filter import ReferenceFilter, check_size
from vidstyle.errors import InputError, UsageError

MAX_COMMAND_SECONDS = 600
"""Maximum run time of a command for one picture."""
MAX_CODES = {8: 255, 16: 65535}
"""White in the pictures that a program receives, by bits per channel."""


def reference_by_command(command: str, depth: int = 8) -> ReferenceFilter:
    """Return a filter that runs a program, such as "ffmpeg -i {in} -vf nlmeans {out}", without a shell.

    Args:
        command: `{in}` and `{out}` stand for PNG files.
        depth: bits per channel of the picture that the program receives, 8 or 16. It may return either.

    Raises:
        UsageError: {in} or {out} is missing.
    """
    words = shlex.split(command)
    if not all(any(mark in word for word in words) for mark in ("{in}", "{out}")):
        raise UsageError(command, "does not name its pictures", "write {in} and {out}")

    def apply(color: np.ndarray, photograph: Photograph) -> list[np.ndarray]:
        with tempfile.TemporaryDirectory() as folder:
            source, target = Path(folder, "in.png"), Path(folder, "out.png")
            codes = (color[..., ::-1] * MAX_CODES[depth] + 0.5).astype(f"uint{depth}")
            cv2.imwrite(str(source), codes)
            said = _run([word.replace("{in}", str(source)).replace("{out}", str(target)) for word in words])
            result = _read(target, f"'{words[0]}'", photograph.path.name, said)
            return [check_size(result, color, words[0], "command")]

    return ReferenceFilter(command, apply)


def _read(target: Path, program: str, name: str, said: str) -> np.ndarray:
    """Return the picture that a program has written, RGB, or raise InputError with what it has printed."""
    printed = f"; it printed: {said}" if said else ""
    if not target.exists():
        raise InputError(program, f"wrote no picture for {name}{printed}", "try it by hand")
    try:
        return Photograph(target, 1 << 20).color()
    except InputError as error:
        reason = f"wrote a file for {name} that cannot be read ({error.reason}){printed}"
        raise InputError(program, reason, "write a PNG picture to {out}") from None


def _run(words: list[str]) -> str:
    """Run a program and return the last line that it has printed to standard error."""
    try:
        run = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=MAX_COMMAND_SECONDS
        )
    except OSError as error:
        raise UsageError(words[0], f"cannot be run ({error.strerror})", "give its full path") from None
    except subprocess.TimeoutExpired:
        raise InputError(
            words[0], f"took more than {MAX_COMMAND_SECONDS} s", "use smaller pictures"
        ) from None
    said = run.stderr.decode(errors="replace").strip().rpartition("\n")[2].strip()
    if run.returncode:
        raise InputError(words[0], f"failed with exit code {run.returncode} ({said})", "try it by hand")
    return said
