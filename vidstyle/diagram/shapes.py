"""Boxes and words of an SVG file; lengths are in pixels."""

from __future__ import annotations

from html import escape

from vidstyle.errors import printable


def rect(left: float, top: float, width: float, height: float, color: str, radius: float = 0) -> str:
    """A box, filled and with a line around it."""
    size = f'x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}" rx="{radius:g}"'
    return f'<rect {size} fill="{color}" stroke="#8a8a8a"/>\n'


def words_at(x: float, y: float, words: str, how: str) -> str:
    """Words whose base line begins at x, y; `how` are more attributes."""
    return f'<text x="{x:g}" y="{y:g}" {how}>{safe(words)}</text>\n'


def safe(words: str) -> str:
    """The words as they may stand in a file: a style may come from a stranger."""
    return escape(printable(words))
