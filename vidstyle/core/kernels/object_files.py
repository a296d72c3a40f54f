"""Object files of kernels in the user's cache folder.

Loaded files are executed. So a file is used only if this user wrote it, no other user could have changed it,
and its checksum matches its machine code and its name, which has a hash of all dependencies of the code. Any
other file is compiled again and replaced.
"""

from __future__ import annotations

import functools
import hashlib
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from vidstyle.core.machine.user_cache import exposure_of, temporary_cache, user_cache
from vidstyle.errors import log

MAGIC = b"vidstyle kernel 1\n"
MAX_FILE_BYTES = 1 << 24
"""Hundreds of times the size of any kernel."""
REMEDY = "set XDG_CACHE_HOME to a folder that only you can write to"


def load(name: str) -> bytes | None:
    """Return the machine code that was stored under a name, or None where it has to be compiled."""
    file = _folder() / f"{name}.o"
    try:
        return _verified(name, _read(file))
    except FileNotFoundError:
        return None
    except (OSError, ValueError):
        _report(file.parent, f"{file.parent} has damaged or foreign files; these kernels are compiled again")
        return None


def store(name: str, code: bytes) -> None:
    """Store machine code; report a folder that cannot be written."""
    folder = _folder()
    try:
        _create(folder)
        descriptor, unfinished = tempfile.mkstemp(dir=folder)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(_header(name, code) + code)
            _replace(Path(unfinished), folder / f"{name}.o")
        finally:
            Path(unfinished).unlink(missing_ok=True)
    except OSError as error:
        reason = f"{folder} cannot be written ({error.strerror})"
        _report(folder, f"{reason}: kernels are compiled again in each run; {REMEDY}")


def cache_state() -> str:
    """Return where kernels are kept, how many, and why none are, for a diagnosis."""
    folder = user_cache() / "kernels"
    if reason := exposure_of(folder):
        return f"{folder} (not used, as {reason}: kernels are compiled again in each run; {REMEDY})"
    there = next(path for path in (folder, *folder.parents) if path.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        return f"{folder} (not writable: kernels are compiled again in each run; {REMEDY})"
    files = sorted(folder.glob("*.o"))
    sound = sum(map(_is_sound, files))
    others = f", {len(files) - sound} damaged or of other versions" if sound < len(files) else ""
    return f"{folder} ({sound} kernels{others})"


def _header(name: str, code: bytes) -> bytes:
    return MAGIC + hashlib.sha256(name.encode() + b"\0" + code).digest()


def _verified(name: str, content: bytes) -> bytes:
    code = content[len(_header("", b"")) :]
    if not content.startswith(_header(name, code)):
        raise ValueError("is not the kernel of this name")
    return code


def _is_sound(file: Path) -> bool:
    try:
        return bool(_verified(file.stem, _read(file)))
    except (OSError, ValueError):
        return False


def _read(file: Path) -> bytes:
    """Return the content of a file of this user, without waiting for a pipe and without following a link."""
    with open(file, "rb", opener=_open_itself) as opened:
        status = os.fstat(opened.fileno())
        if not stat.S_ISREG(status.st_mode) or status.st_size > MAX_FILE_BYTES:
            raise ValueError("is not a file of a possible size")
        is_own = not hasattr(os, "geteuid") or status.st_uid == os.geteuid()
        if not is_own or (os.name == "posix" and status.st_mode & (stat.S_IWGRP | stat.S_IWOTH)):
            raise ValueError("may be another user's")
        return opened.read(MAX_FILE_BYTES)


def _open_itself(path: str, flags: int) -> int:
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0))


def _replace(unfinished: Path, file: Path) -> None:
    with suppress(OSError):
        file.rmdir()  # only an empty folder, which no file can replace
    unfinished.replace(file)


def _create(folder: Path) -> None:
    """Create a folder and those above it for this user only."""
    for each in [*reversed(folder.parents), folder]:
        if not each.exists():
            each.mkdir(mode=0o700, exist_ok=True)


def _folder() -> Path:
    return _trusted(user_cache() / "kernels")


@functools.cache
def _trusted(folder: Path) -> Path:
    """Return a folder, or a temporary one in its place if other users could put files into it."""
    if not (reason := exposure_of(folder)):
        return folder
    _report(folder, f"{reason}: kernels are not loaded from {folder}, but compiled in each run; {REMEDY}")
    return temporary_cache() / "kernels"


_reported: set[Path] = set()


def _report(folder: Path, notice: str) -> None:
    """Log the first problem of a folder; it includes the remedy."""
    if folder not in _reported:
        _reported.add(folder)
        log.warning("%s", notice)
