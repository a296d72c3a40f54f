"""Pages as PDF."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO

from vidstyle.comic.output.formats.jpeg import QUALITY
from vidstyle.comic.output.raster import page_image
from vidstyle.comic.output.sheet import Sheet

SEVERAL = True


def content(sheets: Iterable[Sheet], title: str) -> bytes:
    """The file of all sheets; without a date, so that the same pages are the same file."""
    kept = [(page_image(sheet), sheet.dpi) for sheet in sheets]
    (first, dpi), *rest = kept
    file = BytesIO()
    first.save(
        *(file, "PDF"),
        save_all=True,
        append_images=[image for image, _ in rest],
        resolution=dpi,
        quality=QUALITY,
        subsampling=0,
        title=title or None,
        producer="vidstyle",
        creationDate=None,
        modDate=None,
    )
    return file.getvalue()
