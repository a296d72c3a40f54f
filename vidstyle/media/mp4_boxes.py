"""The outermost boxes of an MP4 or MOV file (ISO/IEC 14496-12)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

MAX_BOXES = 10_000


def top_boxes(path: Path) -> Iterator[tuple[bytes, int, int]]:
    """The kind, offset and size in bytes of each outermost box, as far as they make sense."""
    end = path.stat().st_size
    with path.open("rb") as file:
        offset = 0
        for _ in range(MAX_BOXES):
            file.seek(offset)
            header = file.read(16)
            if len(header) < 8:
                return
            size, kind = int.from_bytes(header[:4], "big"), header[4:8]
            if size == 1:
                size = int.from_bytes(header[8:16], "big")
            elif size == 0:
                size = end - offset
            yield kind, offset, size
            if size < 8:
                return
            offset += size


def has_no_index(path: Path) -> bool:
    """Whether the file starts as MP4 or MOV but was never given its "moov" box."""
    kinds = [kind for kind, _, _ in top_boxes(path)]
    return kinds[:1] in ([b"ftyp"], [b"wide"], [b"mdat"]) and b"moov" not in kinds
