"""Small pictures in the terminal: by the protocols of kitty and iTerm2, else two pixels a character."""

from __future__ import annotations

import os
import sys
from base64 import b64encode
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

MIN_COLUMNS, MAX_COLUMNS = 24, 48
"""Width of one picture, in characters."""
GAP_COLUMNS = 1
"""Columns between two pictures."""
MAX_CHUNK_BYTES = 4096
"""Bytes of a picture in one escape sequence of kitty."""


def protocol_of(environment: Mapping[str, str] = os.environ) -> str:
    """Return how the terminal shows pictures: "kitty", "iterm", "blocks", or "" if it cannot."""
    program, kind = environment.get("TERM_PROGRAM", ""), environment.get("TERM", "dumb")
    if not sys.stdout.isatty() or kind == "dumb" or "NO_COLOR" in environment:
        return ""
    if kind in ("xterm-kitty", "xterm-ghostty"):
        return "kitty"
    if program in ("iTerm.app", "WezTerm"):
        return "iterm"
    shows_blocks = "utf" in sys.stdout.encoding.lower() and environment.get("COLORTERM") in (
        "truecolor",
        "24bit",
    )
    return "blocks" if shows_blocks else ""


def sheet_lines(named: Sequence[tuple[str, np.ndarray]], protocol: str, columns: int) -> Iterator[str]:
    """Pictures of one size with their names below, in rows.

    Args:
        named: names and pictures, H x W x 3 uint8 RGB.
        protocol: as `protocol_of` says, not "".
        columns: of the terminal.
    """
    across = min(len(named), max(1, (columns + GAP_COLUMNS) // (MIN_COLUMNS + GAP_COLUMNS)))
    width = min(MAX_COLUMNS, (columns + GAP_COLUMNS) // across - GAP_COLUMNS)
    for first in range(0, len(named), across):
        row = named[first : first + across]
        yield from row_lines([picture for _, picture in row], protocol, width)
        names = (" " * GAP_COLUMNS).join(f"{name[:width]:{width}}" for name, _ in row).rstrip()
        yield from [names] if names else []


def row_lines(pictures: Sequence[np.ndarray], protocol: str, width: int) -> Iterator[str]:
    """Pictures side by side, each `width` characters wide; see `sheet_lines`."""
    height = max(1, round(width * pictures[0].shape[0] / pictures[0].shape[1] / 2))
    if protocol == "blocks":
        blocks = [_block_lines(picture, width, height) for picture in pictures]
        yield from ((" " * GAP_COLUMNS).join(parts) for parts in zip(*blocks, strict=True))
        return
    strip = _png_strip(pictures, width)
    columns = len(pictures) * (width + GAP_COLUMNS) - GAP_COLUMNS
    yield (_kitty if protocol == "kitty" else _iterm)(strip, columns, height)


def _block_lines(picture: np.ndarray, width: int, height: int) -> Iterator[str]:
    """Yield lines of half blocks: the upper pixel is the text colour, the lower the background."""
    import cv2

    small = cv2.resize(picture, (width, 2 * height), interpolation=cv2.INTER_AREA)
    for upper, lower in zip(small[::2].tolist(), small[1::2].tolist(), strict=True):
        cells = (
            "\x1b[38;2;{};{};{};48;2;{};{};{}m▀".format(*top, *bottom)
            for top, bottom in zip(upper, lower, strict=True)
        )
        yield "".join(cells) + "\x1b[0m"


def _png_strip(pictures: Sequence[np.ndarray], width: int) -> bytes:
    """Return the pictures in a row, with transparent columns between them."""
    import cv2
    import numpy as np

    from vidstyle.media.picture_bytes import png_bytes

    gap = round(pictures[0].shape[1] * GAP_COLUMNS / width)
    opaque = (cv2.cvtColor(picture, cv2.COLOR_RGB2RGBA) for picture in pictures)
    framed = [cv2.copyMakeBorder(each, 0, 0, 0, gap, cv2.BORDER_CONSTANT) for each in opaque]
    return png_bytes(np.hstack(framed)[:, :-gap])


def _kitty(png: bytes, columns: int, rows: int) -> str:
    """See https://sw.kovidgoyal.net/kitty/graphics-protocol/."""
    data = b64encode(png).decode()
    chunks = [data[start : start + MAX_CHUNK_BYTES] for start in range(0, len(data), MAX_CHUNK_BYTES)]
    keys = [f"a=T,f=100,q=2,c={columns},r={rows},"] + [""] * (len(chunks) - 1)
    more = [1] * (len(chunks) - 1) + [0]
    return "".join(
        f"\x1b_G{key}m={follows};{chunk}\x1b\\"
        for key, follows, chunk in zip(keys, more, chunks, strict=True)
    )


def _iterm(png: bytes, columns: int, rows: int) -> str:
    """See https://iterm2.com/documentation-images.html."""
    size = f"size={len(png)};width={columns};height={rows};preserveAspectRatio=0"
    return f"\x1b]1337;File=inline=1;{size}:{b64encode(png).decode()}\a"
