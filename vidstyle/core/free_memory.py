"""Tells a lack of memory from other failures of libraries that do not say why they failed."""

from __future__ import annotations

import mmap

_SPARE_BYTES = 1 << 28
"""What a codec and its threads may take for a small picture: libx264 needs about 200 MB of addresses."""


def is_memory_short() -> bool:
    """Whether the system refuses this process another 256 MiB, as it does where `ulimit -v` is low."""
    try:
        mmap.mmap(-1, _SPARE_BYTES).close()
    except OSError:
        return True
    return False
