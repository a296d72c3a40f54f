"""Simulated control groups that limit a process."""

from __future__ import annotations

from pathlib import Path


def machine(root: Path, groups: str, files: dict[str, str]) -> Path:
    """Write the files of /proc and /sys with the limits of a process, and return their root folder."""
    texts = {"proc/self/cgroup": groups} | {f"sys/fs/cgroup/{name}": text for name, text in files.items()}
    for name, text in texts.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return root
