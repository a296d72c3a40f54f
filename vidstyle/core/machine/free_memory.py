"""How much memory the frames of a film may take."""

from __future__ import annotations

import ctypes
import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from vidstyle.core.machine.control_groups import group_folders, read_text

DEFAULT_MEMORY_SHARE = 4
"""Without --memory, frames take at most this fraction (1/4) of the free memory."""
MIN_MEMORY_BYTES, MAX_MEMORY_BYTES = 1 << 20, 1 << 44
_UNITS = {"K": 10, "M": 20, "G": 30, "T": 40}

_from_option: int | None = None
_reserved = 0


def parse_memory(text: str) -> int:
    """Return a number of bytes.

    Raises:
        ValueError: the text is not a size of memory from 1M to 16T.

    >>> parse_memory("1.5G"), parse_memory("800m")
    (1610612736, 838860800)
    """
    match = re.fullmatch(r"(\d{1,9}(?:\.\d{1,9})?)([KMGT])?B?", text, re.ASCII | re.IGNORECASE)
    if match is None:
        raise ValueError(f"{text!r} is not a size of memory such as 800M or 2G")
    size = int(float(match[1]) * (1 << _UNITS.get((match[2] or "").upper(), 0)))
    if not MIN_MEMORY_BYTES <= size <= MAX_MEMORY_BYTES:
        raise ValueError(f"{text} is outside {MIN_MEMORY_BYTES >> 20}M to {MAX_MEMORY_BYTES >> 40}T")
    return size


@contextmanager
def use_memory(size: int) -> Iterator[None]:
    """Use at most this many bytes within the block, as --memory asks for."""
    global _from_option
    before, _from_option = _from_option, size
    try:
        yield
    finally:
        _from_option = before


def reserve_memory(size: int) -> None:
    """Count these bytes as memory of this process, for other processes; negative: no longer."""
    global _reserved
    _reserved += size


def frame_memory() -> int:
    """Return the bytes that frames may take in addition to what this process has now.

    This is the number of --memory less the memory of the process, otherwise a fraction of the free memory.
    """
    if _from_option is not None:
        return max(0, _from_option - resident_memory() - _reserved)
    return free_memory() // DEFAULT_MEMORY_SHARE


def memory_option() -> int | None:
    """Return the bytes that --memory allows, or None without it."""
    return _from_option


def resident_memory(root: Path = Path("/")) -> int:
    """Return the bytes of main memory that this process has; 0 if the system does not report it.

    Args:
        root: folder with `proc`.
    """
    words = read_text(root / "proc/self/statm").split()
    return int(words[1]) * os.sysconf("SC_PAGE_SIZE") if len(words) > 1 else 0


def free_memory(root: Path = Path("/")) -> int:
    """Return the bytes that this process may still take: of the machine, and of its control groups.

    Args:
        root: folder with `proc` and `sys`.
    """
    groups = [_group_memory(folder) for folder in group_folders(root, "memory")]
    return max(0, min([_machine_memory(root), *(each for each in groups if each is not None)]))


def _machine_memory(root: Path) -> int:
    if found := re.search(r"^MemAvailable:\s+(\d+) kB", read_text(root / "proc/meminfo"), re.M):
        return int(found[1]) << 10
    if sys.platform == "win32":
        return _windows_memory()
    with suppress(ValueError, OSError):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")  # macOS reports no free memory
    return sys.maxsize


def _group_memory(folder: Path) -> int | None:
    """Return the bytes that one control group still allows, or None if it sets no limit."""
    names = ("max", "current"), ("limit_in_bytes", "usage_in_bytes")  # versions 2 and 1
    for limit, usage in names:
        most, used = (read_text(folder / f"memory.{name}").strip() for name in (limit, usage))
        if most.isdecimal() and used.isdecimal():
            return int(most) - int(used) + _reclaimable(folder)
    return None


def _reclaimable(folder: Path) -> int:
    """Return the bytes of files that the system drops when memory is short; groups count them as used."""
    # Version 1 has a second line, which includes the groups within this one.
    found = re.findall(r"^(?:total_)?inactive_file (\d+)$", read_text(folder / "memory.stat"), re.M)
    return max(map(int, found), default=0)


def _windows_memory() -> int:
    class Status(ctypes.Structure):
        _fields_ = [("size", ctypes.c_uint32), ("load", ctypes.c_uint32)] + [
            (name, ctypes.c_uint64)
            for name in (
                "total",
                "free",
                "total_page",
                "free_page",
                "total_virtual",
                "free_virtual",
                "extended",
            )
        ]

    status = Status(size=ctypes.sizeof(Status))
    is_known = ctypes.windll.kernel32.GlobalMemoryStatusEx(ctypes.byref(status))  # type: ignore[attr-defined]
    return int(status.free) if is_known else sys.maxsize
