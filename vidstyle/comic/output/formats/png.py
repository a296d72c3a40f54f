"""A page as PNG, with its size on paper."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO

from vidstyle.comic.output.raster import page_image
from vidstyle.comic.output.sheet import Sheet

SEVERAL = False


def content(sheets: Iterable[Sheet], title: str) -> bytes:
    """The file of one sheet."""
    (sheet,) = sheets
    file = BytesIO()
    page_image(sheet).save(file, "PNG", dpi=(sheet.dpi, sheet.dpi))
    return file.getvalue()
