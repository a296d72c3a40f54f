"""What machine code is made for, as Linux describes it, so that LLVM need not be loaded to find out."""

from __future__ import annotations

import platform
import sys
from pathlib import Path

from vidstyle.core.machine.control_groups import read_text

LINES = ("vendor_id", "cpu family", "model", "model name", "stepping", "flags")
"""All on which LLVM's choice of instructions depends; `flags` names what the processor can do."""


def described_processor(root: Path = Path("/")) -> tuple[str, ...] | None:
    """Return the description of the processor, or None if it does not say all that LLVM would find.

    Args:
        root: folder with `proc`.
    """
    if sys.platform != "linux" or platform.machine() != "x86_64":
        return None
    first, _, _ = read_text(root / "proc/cpuinfo").partition("\n\n")
    pairs = (line.partition(":") for line in first.splitlines())
    found = {name.strip(): value.strip() for name, _, value in pairs}
    return tuple(found[name] for name in LINES) if found.keys() >= {*LINES} else None
