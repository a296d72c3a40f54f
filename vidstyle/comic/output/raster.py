"""Pages as pixels, and their PNG, JPEG, CBZ and PDF files by Pillow."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import pairwise
from typing import TYPE_CHECKING, Any
from zipfile import ZIP_STORED, ZipFile, ZipInfo

import numpy as np

from vidstyle.comic.layout.slant import corners
from vidstyle.comic.lettering.bubble import DASH_LENGTH_RATIO, Bubble
from vidstyle.comic.lettering.characters import xml_text
from vidstyle.comic.lettering.fonts import split_stress, thickness
from vidstyle.comic.output.sheet import RenderedPanel, Sheet
from vidstyle.regions.boxes import Point, Rectangle

if TYPE_CHECKING:
    from PIL.Image import Image

JPEG_QUALITY = 92
"""Quality of JPEG images in all formats, 1 to 100."""

MAX_JPEG_SIDE_PX = 65_500
"""Maximum width and height of a JPEG image in pixels (libjpeg), also of those in CBZ and PDF files."""

PAPER_LEVEL, INK_LEVEL = 255, 0
"""Gray levels."""

_SUPERSAMPLING_FACTOR = 4
"""Supersampling factor of outlines."""
_MAX_BAND_PIXELS = 1 << 22
"""Maximum number of pixels in which outlines are drawn at once: a mask takes 48 bytes for each."""


def png(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode a single page as a PNG file with its resolution."""
    (sheet,) = sheets
    return _encode(page_image(sheet), "PNG", dpi=(sheet.dpi, sheet.dpi))


def jpeg(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode a single page as a JPEG file with its resolution."""
    (sheet,) = sheets
    dpi = round(sheet.dpi)
    # Subsampled chroma would wash out coloured dots and strokes. With `optimize`, Pillow fails if a page of
    # dots needs more than one byte per pixel.
    return _encode(page_image(sheet), "JPEG", quality=JPEG_QUALITY, subsampling=0, dpi=(dpi, dpi))


def cbz(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode JPEG pages as a ZIP archive for comic readers, with constant dates, so that it is reproducible.

    Its ComicInfo.xml states the title, the number of pages and the reading order.
    """
    file, number, backwards = BytesIO(), 0, False
    with ZipFile(file, "w", ZIP_STORED) as archive:
        for number, sheet in enumerate(sheets, 1):
            archive.writestr(ZipInfo(f"page-{number:03}.jpg"), jpeg([sheet], title))
            backwards = sheet.right_to_left
        manga = "YesAndRightToLeft" if backwards else "No"
        entries = f"<Title>{xml_text(title)}</Title><PageCount>{number}</PageCount><Manga>{manga}</Manga>"
        head = '<?xml version="1.0" encoding="utf-8"?>'
        archive.writestr(ZipInfo("ComicInfo.xml"), f"{head}\n<ComicInfo>{entries}</ComicInfo>\n")
    return file.getvalue()


def pdf(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode all pages as a PDF file, without dates, so that it is reproducible."""
    (first, dpi), *rest = [(page_image(sheet), sheet.dpi) for sheet in sheets]
    pages = {"save_all": True, "append_images": [image for image, _ in rest], "resolution": dpi}
    quality = {"quality": JPEG_QUALITY, "subsampling": 0}
    notes = {"title": title or None, "producer": "vidstyle", "creationDate": None, "modDate": None}
    return _encode(first, "PDF", **pages, **quality, **notes)


def _encode(image: Image, kind: str, **options: Any) -> bytes:
    file = BytesIO()
    image.save(file, kind, **options)
    return file.getvalue()


def page_image(sheet: Sheet) -> Image:
    """Return the page as an RGB image of Pillow at the size of the sheet."""
    from PIL import Image, ImageDraw

    canvas = np.full((sheet.height, sheet.width, 3), PAPER_LEVEL, np.uint8)
    for panel in sheet.panels:
        _draw_panel(canvas, panel)
    image = Image.fromarray(canvas)
    draw = ImageDraw.Draw(image)
    for panel in sheet.panels:
        for bubble in panel.bubbles:
            size = bubble.block.size
            font, bold = sheet.letters.font(size), thickness(size)
            for text, left, foot, _ in bubble.lines:
                for part, stressed in split_stress(text):
                    place, width = (left, foot), bold * stressed
                    draw.text(place, part, font=font, fill=(INK_LEVEL,) * 3, anchor="ls", stroke_width=width)
                    left += font.getlength(part)
    for label in sheet.labels:
        place, font = (label.middle, label.foot), sheet.letters.font(label.size)
        width = label.thickness
        draw.text(place, label.text, font=font, fill=(INK_LEVEL,) * 3, anchor="ms", stroke_width=width)
    return image


def _draw_panel(canvas: np.ndarray, panel: RenderedPanel) -> None:
    rectangle = panel.rectangle
    paper = canvas[rectangle.top : rectangle.bottom, rectangle.left : rectangle.right].copy()
    _fill(canvas, rectangle, INK_LEVEL)
    if panel.band:
        _fill(canvas, panel.band, PAPER_LEVEL)
    _fill(canvas, panel.picture, panel.color)
    if panel.leans != (0, 0):
        drawn = canvas[rectangle.top : rectangle.bottom, rectangle.left : rectangle.right]
        for top, rows in _bands(drawn):
            first, below = (rectangle.left, rectangle.top + top), paper[top : top + len(rows)]
            outer, inner = (
                _masks(
                    (np.array(corners(box, panel.leans)) - first) * _SUPERSAMPLING_FACTOR, rows.shape, 0, 0
                )[0]
                for box in (rectangle, panel.inside)
            )
            rows[:] = np.rint(
                below * (1 - outer) + INK_LEVEL * (outer - outer * inner) + rows * (outer * inner)
            )
    for bubble in panel.bubbles:
        for outline in bubble.outlines:
            _draw_outline(canvas, bubble, outline)


def _fill(canvas: np.ndarray, place: Rectangle, color: np.ndarray | int) -> None:
    canvas[place.top : place.bottom, place.left : place.right] = color


def _draw_outline(canvas: np.ndarray, bubble: Bubble, points: np.ndarray) -> None:
    """Draw a shape in white with the bubble's black line."""
    room = math.ceil(bubble.line_width) + 1
    height, width = canvas.shape[:2]
    left, top = (max(0, math.floor(low) - room) for low in points.min(axis=0))
    right, bottom = (math.ceil(high) + room for high in points.max(axis=0))
    part = canvas[top : min(height, bottom), left : min(width, right)]
    dash = DASH_LENGTH_RATIO * bubble.block.size * _SUPERSAMPLING_FACTOR if bubble.kind == "whisper" else 0.0
    for row, rows in _bands(part):
        first = left, top + row
        body, line = _masks(
            (points - first) * _SUPERSAMPLING_FACTOR,
            rows.shape,
            bubble.line_width * _SUPERSAMPLING_FACTOR,
            dash,
        )
        rows[:] = np.rint(rows * (1 - np.maximum(body, line)) + np.minimum(body, 1 - line) * PAPER_LEVEL)


def _bands(part: np.ndarray) -> Iterator[tuple[int, np.ndarray]]:
    """Bands of rows of at most `_MAX_BAND_PIXELS`, each with the number of its first row; all views."""
    height = max(1, _MAX_BAND_PIXELS // max(1, part.shape[1]))
    for top in range(0, len(part), height):
        yield top, part[top : top + height]


def _masks(points: np.ndarray, shape: tuple[int, ...], line_width: float, dash: float) -> list[np.ndarray]:
    """Return the coverage of each pixel by the polygon, and by its line: H x W x 1, 0..1.

    `dash`: length of the line's dashes and gaps in pixels; 0: a solid line.
    """
    from PIL import Image, ImageDraw

    corners = [(float(x), float(y)) for x, y in points]
    masks = [
        Image.new("L", (shape[1] * _SUPERSAMPLING_FACTOR, shape[0] * _SUPERSAMPLING_FACTOR)) for _ in range(2)
    ]
    body, line = map(ImageDraw.Draw, masks)
    body.polygon(corners, fill=255)
    for piece in _dashes([*corners, *corners[:2]], dash):
        line.line(piece, fill=255, width=max(1, round(line_width)), joint="curve")
    return [
        np.asarray(mask.reduce(_SUPERSAMPLING_FACTOR), np.float32)[..., np.newaxis] / 255 for mask in masks
    ]


def _dashes(corners: list[Point], dash: float) -> Iterator[list[Point]]:
    """Yield the pieces of a line that are drawn."""
    if not dash:
        yield corners
        return
    piece, way = [corners[0]], 0.0
    for start, end in pairwise(corners):
        way += math.dist(start, end)
        if way // dash % 2 == 0:
            piece.append(end)
        elif len(piece) > 1:
            yield piece
            piece = [end]
        else:
            piece = [end]
    if len(piece) > 1:
        yield piece
