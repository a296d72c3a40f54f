"""A page as JPEG, with its size on paper."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO

from vidstyle.comic.output.raster import page_image
from vidstyle.comic.output.sheet import Sheet

SEVERAL = False
QUALITY = 92


def content(sheets: Iterable[Sheet], title: str) -> bytes:
    """The file of one sheet."""
    (sheet,) = sheets
    file = BytesIO()
    image, dpi = page_image(sheet), round(sheet.dpi)
    # Reduced chroma would wash out coloured dots and strokes. Not with `optimize`: Pillow then fails where a
    # page of dots needs more than a byte for each pixel.
    image.save(file, "JPEG", quality=QUALITY, subsampling=0, dpi=(dpi, dpi))
    return file.getvalue()
