"""Pages as a web page to scroll through, in one file that needs nothing else."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from itertools import accumulate
from pathlib import Path
from string import Template

from vidstyle.comic.output.sheet import Sheet
from vidstyle.comic.output.svg import svg_element

_TEMPLATE = Path(__file__).with_name("strip.html")


def html(sheets: Iterable[Sheet], title: str) -> bytes:
    """The file of all sheets, one below the other, as wide as the window or as they are."""
    drawn = list(sheets)
    before = accumulate((len(sheet.panels) for sheet in drawn), initial=0)
    pages = (
        svg_element(sheet, "", count, with_font=number == 0)
        for number, (sheet, count) in enumerate(zip(drawn, before, strict=False))
    )
    return (
        Template(_TEMPLATE.read_text(encoding="utf-8"))
        .substitute(
            title=escape(title or "Comic"),
            width=max(sheet.width for sheet in drawn),
            pages="".join(pages),
        )
        .encode()
    )
