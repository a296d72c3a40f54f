"""Pages as SVG, alone or in a web page: panels are images; balloons and captions are shapes and text."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Iterable, Iterator
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from string import Template

from vidstyle.comic.layout.paper import MM_PER_INCH
from vidstyle.comic.layout.slant import corners
from vidstyle.comic.lettering.bubble import DASH_LENGTH_RATIO, Bubble
from vidstyle.comic.lettering.characters import xml_text
from vidstyle.comic.lettering.fonts import split_stress, thickness
from vidstyle.comic.output.raster import JPEG_QUALITY
from vidstyle.comic.output.sheet import Label, RenderedPanel, Sheet
from vidstyle.errors import counted
from vidstyle.export import join_modules, module_text
from vidstyle.media.picture_bytes import jpeg_bytes
from vidstyle.regions.boxes import Rectangle

_TEMPLATE_PATH, _READER_PATH, _EDITOR_PATH = (
    Path(__file__).parent / "web_page" / name for name in ("strip.html", "reader.js", "edit.js")
)


def html(sheets: Iterable[Sheet], title: str, page_file: str) -> bytes:
    """Encode all sheets as a self-contained web page, one below the other, no wider than the window.

    On it, balloons can be dragged, words changed, and the page or its page file with these changes saved.

    Args:
        sheets: pages.
        title: of the comic.
        page_file: the file that can be edited, see `page_file`; empty: nothing can be edited.
    """
    drawn = list(sheets)
    before = accumulate((len(sheet.panels) for sheet in drawn), initial=0)
    pages = (
        svg_element(sheet, "", count, with_font=number == 0)
        for number, (sheet, count) in enumerate(zip(drawn, before, strict=False))
    )
    width = max(sheet.width for sheet in drawn)
    template = Template(_TEMPLATE_PATH.read_text(encoding="utf-8"))
    reader = join_modules(_READER_PATH)
    editor = join_modules(_EDITOR_PATH) if page_file else ""
    # JSON in a page must not contain the end tag of its element.
    data = json.dumps(page_file).replace("<", "\\u003c")
    return template.substitute(
        title=xml_text(title or "Comic"),
        count=", ".join(
            (counted(len(drawn), "page"), counted(sum(len(sheet.panels) for sheet in drawn), "panel"))
        ),
        orientation="landscape" if drawn[0].width > drawn[0].height else "portrait",
        style=module_text("components.css"),
        width=width,
        pages="".join(pages),
        data=data,
        reader=reader,
        editor=editor,
        digests=" ".join(map(_digest, (reader, editor))),
    ).encode()


def _digest(script: str) -> str:
    """Return the source of a content security policy that allows only this script."""
    return f"'sha256-{b64encode(sha256(script.encode()).digest()).decode('ascii')}'"


def svg(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode a single page as an SVG file."""
    (sheet,) = sheets
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{svg_element(sheet, title)}'.encode()


def svg_element(sheet: Sheet, title: str, before: int = 0, with_font: bool = True) -> str:
    """Return the sheet as an `svg` element of its size on paper.

    Args:
        sheet: a page.
        title: of the comic.
        before: number of panels before it in the document.
        with_font: whether to embed the font; one element of a document does.
    """
    fonts = xml_text(f"'{sheet.letters.family}', Helvetica, Arial, sans-serif")
    wide, high = (f"{length * MM_PER_INCH / sheet.dpi:.2f}mm" for length in (sheet.width, sheet.height))
    rows = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}"'
        f' viewBox="0 0 {sheet.width} {sheet.height}" font-family="{fonts}">',
        f"<title>{xml_text(title)}</title>" if title else "",
        _font_face(sheet) if with_font else "",
        '<rect width="100%" height="100%" fill="#fff"/>',
        *(row for number, panel in enumerate(sheet.panels, before + 1) for row in _panel(panel, number)),
        *map(_label, sheet.labels),
        "</svg>",
    ]
    return "\n".join(row for row in rows if row) + "\n"


def _font_face(sheet: Sheet) -> str:
    """Return the font, embedded if its licence allows that."""
    font = sheet.letters.free_font
    if font is None:
        return ""
    source = f"url(data:font/ttf;base64,{b64encode(font).decode('ascii')})"
    return f"<style>@font-face {{ font-family: '{sheet.letters.family}'; src: {source}; }}</style>"


def _panel(panel: RenderedPanel, number: int) -> Iterator[str]:
    yield f'<g id="panel-{number}" data-border="{panel.border}">'
    if panel.note:
        yield f"<title>{xml_text(panel.note)}</title>"
    if panel.leans == (0, 0):
        yield f'<rect class="frame" {_place(panel.rectangle)} fill="#000"/>'
    else:
        outside = _points(corners(panel.rectangle, panel.leans))
        yield f'<polygon class="frame" points="{outside}" fill="#000"/>'
        inside = _points(corners(panel.inside, panel.leans))
        yield f'<clipPath id="edge-{number}"><polygon points="{inside}"/></clipPath>'
        yield f'<g clip-path="url(#edge-{number})">'
    if panel.band:
        yield f'<rect {_place(panel.band)} fill="#fff"/>'
    yield (
        f'<image {_place(panel.picture)} preserveAspectRatio="none"'
        f' href="data:image/jpeg;base64,{b64encode(jpeg_bytes(panel.color, JPEG_QUALITY)).decode("ascii")}"/>'
    )
    if panel.leans != (0, 0):
        yield "</g>"
    for bubble in panel.bubbles:
        yield from _bubble(bubble)
    yield "</g>"


def _points(points: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def _place(rectangle: Rectangle) -> str:
    return f'x="{rectangle.left}" y="{rectangle.top}" width="{rectangle.width}" height="{rectangle.height}"'


def _bubble(bubble: Bubble) -> Iterator[str]:
    place = " ".join(f"{side:.10g}" for side in bubble.box)
    tip = f' data-tip="{bubble.tip[0]:.10g} {bubble.tip[1]:.10g}"' if bubble.tip else ""
    yield f'<g class="{bubble.kind}" data-place="{place}"{tip}>'
    dash = DASH_LENGTH_RATIO * bubble.block.size
    dashes = f' stroke-dasharray="{dash:.1f}"' if bubble.kind == "whisper" else ""
    for outline in bubble.outlines:
        yield (
            f'<polygon points="{_points(map(tuple, outline.tolist()))}" fill="#fff" stroke="#000"'
            f' stroke-width="{bubble.line_width:.2f}" stroke-linejoin="round"{dashes}/>'
        )
    yield f'<text font-size="{bubble.block.size}">'
    # textLength keeps the width if another font is used.
    for text, left, foot, width in bubble.lines:
        yield (
            f'<tspan x="{left:.1f}" y="{foot:.1f}" textLength="{width:.1f}"'
            f' lengthAdjust="spacingAndGlyphs">{_runs(text, bubble.block.size)}</tspan>'
        )
    yield "</text>"
    yield "</g>"


def _runs(text: str, size: int) -> str:
    """Return a line with stressed words in bold."""
    bold = f'<tspan stroke="#000" stroke-width="{2 * thickness(size)}">'
    return "".join(
        f"{bold}{xml_text(part)}</tspan>" if stressed else xml_text(part)
        for part, stressed in split_stress(text)
    )


def _label(label: Label) -> str:
    return (
        f'<text x="{label.middle:.1f}" y="{label.foot:.1f}" font-size="{label.size}"'
        f' text-anchor="middle" stroke="#000" stroke-width="{2 * label.thickness}">'
        f"{xml_text(label.text)}</text>"
    )
