"""The control groups of this process (cgroup v1 and v2), which limit a container."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path


def group_folders(root: Path, controller: str) -> Iterator[Path]:
    """Yield the folders of the groups that this process is in, and of those around them.

    Args:
        root: folder with `proc` and `sys`.
        controller: "cpu" or "memory".
    """
    for line in read_text(root / "proc/self/cgroup").splitlines():
        _, _, rest = line.partition(":")
        controllers, _, path = rest.partition(":")
        if controllers and controller not in controllers.split(","):
            continue
        mount = root / "sys/fs/cgroup" / controllers  # version 2 names no controllers
        # A container may see its own group as the root, but the path that the host uses.
        inside = mount / path.lstrip("/") if ".." not in path else mount
        yield from (each for each in (inside, *inside.parents) if each.is_relative_to(mount))


def read_text(file: Path) -> str:
    """Return the text of a file of the system, or an empty string if it cannot be read."""
    try:
        return file.read_text("utf-8", "replace")
    except OSError:
        return ""
