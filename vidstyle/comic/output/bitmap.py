"""Pages as PNG, JPEG, CBZ and PDF files, by Pillow."""

from __future__ import annotations

from collections.abc import Iterable
from io import BytesIO
from zipfile import ZIP_STORED, ZipFile, ZipInfo

from vidstyle.comic.output.raster import page_image
from vidstyle.comic.output.sheet import Sheet

JPEG_QUALITY = 92
"""Quality of JPEG images in all formats, 1 to 100."""


def png(sheets: Iterable[Sheet], title: str) -> bytes:
    """A PNG file of a single page, with its resolution."""
    (sheet,) = sheets
    file = BytesIO()
    page_image(sheet).save(file, "PNG", dpi=(sheet.dpi, sheet.dpi))
    return file.getvalue()


def jpeg(sheets: Iterable[Sheet], title: str) -> bytes:
    """A JPEG file of a single page, with its resolution."""
    (sheet,) = sheets
    file = BytesIO()
    image, dpi = page_image(sheet), round(sheet.dpi)
    # Subsampled chroma would wash out coloured dots and strokes. Not with `optimize`: Pillow then fails where
    # a page of dots needs more than a byte for each pixel.
    image.save(file, "JPEG", quality=JPEG_QUALITY, subsampling=0, dpi=(dpi, dpi))
    return file.getvalue()


def cbz(sheets: Iterable[Sheet], title: str) -> bytes:
    """A ZIP archive of JPEG pages for comic readers, with constant dates, so that it is reproducible."""
    file = BytesIO()
    with ZipFile(file, "w", ZIP_STORED) as archive:
        for number, sheet in enumerate(sheets, 1):
            archive.writestr(ZipInfo(f"page-{number:03}.jpg"), jpeg([sheet], title))
    return file.getvalue()


def pdf(sheets: Iterable[Sheet], title: str) -> bytes:
    """A PDF file of all pages, without dates, so that it is reproducible."""
    (first, dpi), *rest = [(page_image(sheet), sheet.dpi) for sheet in sheets]
    file = BytesIO()
    first.save(
        *(file, "PDF"),
        save_all=True,
        append_images=[image for image, _ in rest],
        resolution=dpi,
        quality=JPEG_QUALITY,
        subsampling=0,
        title=title or None,
        producer="vidstyle",
        creationDate=None,
        modDate=None,
    )
    return file.getvalue()
