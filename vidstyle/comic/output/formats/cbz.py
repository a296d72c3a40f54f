"""Pages as CBZ, which comic readers open: a ZIP of pictures."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from zipfile import ZIP_STORED, ZipFile, ZipInfo

from vidstyle.comic.output.formats import jpeg
from vidstyle.comic.output.sheet import Sheet

SEVERAL = True


def content(sheets: Iterable[Sheet], title: str) -> bytes:
    """The file of all sheets; its entries bear the first date there is."""
    file = BytesIO()
    with ZipFile(file, "w", ZIP_STORED) as archive:
        for number, sheet in enumerate(sheets, 1):
            archive.writestr(ZipInfo(f"page-{number:03}.jpg"), jpeg.content([sheet], title))
    return file.getvalue()
