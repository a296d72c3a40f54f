"""The cores, memory and disk space that the processes of a batch share."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from vidstyle.core.machine.cores import available_cores, core_count, process_cores
from vidstyle.core.machine.free_memory import free_memory
from vidstyle.media.write.atomic import MIN_FREE_BYTES

JOB_BYTES = 2**30
"""Estimated memory of a process: 720p takes 0.4 GB, 4K about 1 GB."""


@dataclass(frozen=True)
class Room:
    """What the processes of a batch share.

    Attributes:
        cores: of all machines.
        machine_cores: of the machine with the most.
        memory: free bytes of all machines.
    """

    cores: int
    machine_cores: int
    memory: int


def local_room() -> Room:
    """Return the room on this machine."""
    cores = process_cores().number if core_count().reason == "--threads" else available_cores()
    return Room(cores, cores, free_memory())


def shared_cores(jobs: int | None, films: int, room: Room) -> tuple[int, int]:
    """Return the number of parallel processes, and of the threads of each.

    Args:
        jobs: number of processes selected by the user; None: limited by cores, films and memory.
        films: number of films.
    """
    chosen = core_count()
    threads = chosen.number if chosen.reason == "--threads" else 0
    jobs = jobs or max(1, min(films, room.cores // (threads or 1), room.memory // JOB_BYTES))
    return jobs, threads or max(1, min(room.machine_cores, room.cores // jobs))


def missing_space(target: Path, needed: int, reserved: Iterable[tuple[Path, int]]) -> str:
    """Return the reason why a result does not fit on the disk, or an empty string.

    Args:
        target: the result.
        needed: expected size in bytes.
        reserved: results in progress, and the expected bytes that they still need.
    """
    folder = target.parent
    device = folder.stat().st_dev
    taken = sum(number for path, number in reserved if path.parent.stat().st_dev == device)
    free = shutil.disk_usage(folder).free - MIN_FREE_BYTES - taken
    if free >= needed:
        return ""
    return f"needs about {needed >> 20} MB, and {max(free, 0) >> 20} MB are free in {folder}"
