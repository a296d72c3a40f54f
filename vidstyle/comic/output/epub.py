"""Pages as an EPUB 3 file of fixed layout, as comic readers and shops expect it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from hashlib import sha256
from io import BytesIO
from uuid import UUID
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo

from vidstyle.comic.lettering.characters import xml_text
from vidstyle.comic.output.raster import jpeg
from vidstyle.comic.output.sheet import Sheet

_HEAD = '<?xml version="1.0" encoding="utf-8"?>\n'
_CONTAINER = (
    '<container version="1.0" xmlns="urn:oasis:names:tc:opendocument:xmlns:container"><rootfiles>'
    '<rootfile full-path="comic.opf" media-type="application/oebps-package+xml"/></rootfiles></container>'
)
_PAGE_STYLE = "html,body{margin:0;padding:0}img{display:block;width:100%;height:100%}"
_SENTENCE_ENDINGS = tuple(".!?…")
_MODIFIED = "2000-01-01T00:00:00Z"
"""The required time of the last change: constant, so that the file is reproducible."""


def epub(sheets: Iterable[Sheet], title: str) -> bytes:
    """Encode all pages as an EPUB file; the words of each page are its alternative text."""
    file, title, names = BytesIO(), title or "Comic", list[str]()
    digest, backwards = sha256(title.encode()), False
    with ZipFile(file, "w") as archive:
        # Readers recognize the format by this entry, which must be the first one and not compressed.
        archive.writestr(ZipInfo("mimetype"), "application/epub+zip", ZIP_STORED)
        _write(archive, "META-INF/container.xml", _CONTAINER)
        for number, sheet in enumerate(sheets, 1):
            picture, name = jpeg([sheet], title), f"page-{number:03}"
            digest.update(picture)
            archive.writestr(ZipInfo(f"{name}.jpg"), picture, ZIP_STORED)
            _write(archive, f"{name}.xhtml", _page(sheet, name, f"{title}, page {number}"))
            names.append(name)
            backwards = sheet.right_to_left
        _write(archive, "contents.xhtml", _contents(names, title))
        identifier = UUID(bytes=digest.digest()[:16]).urn
        _write(archive, "comic.opf", _package(names, title, identifier, backwards))
    return file.getvalue()


def _write(archive: ZipFile, name: str, content: str) -> None:
    archive.writestr(ZipInfo(name), _HEAD + content, ZIP_DEFLATED)


def _page(sheet: Sheet, name: str, title: str) -> str:
    said = " ".join(_end_sentence(panel.note) for panel in sheet.panels if panel.note) or title
    return _document(
        title,
        f'<meta name="viewport" content="width={sheet.width}, height={sheet.height}"/>'
        f"<style>{_PAGE_STYLE}</style>",
        f'<img src="{name}.jpg" alt="{xml_text(said)}"/>',
    )


def _end_sentence(text: str) -> str:
    """Return the text with a full stop, unless it ends in a mark."""
    return text if text.endswith(_SENTENCE_ENDINGS) else f"{text}."


def _contents(names: list[str], title: str) -> str:
    entries = "".join(
        f'<li><a href="{name}.xhtml">Page {number}</a></li>' for number, name in enumerate(names, 1)
    )
    body = f'<nav epub:type="toc"><h1>{xml_text(title)}</h1><ol>{entries}</ol></nav>'
    return _document(title, "", body)


def _document(title: str, head: str, body: str) -> str:
    return (
        '<html xmlns="http://www.w3.org/1999/xhtml" xmlns:epub="http://www.idpf.org/2007/ops">'
        f"<head><title>{xml_text(title)}</title>{head}</head><body>{body}</body></html>\n"
    )


def _package(names: list[str], title: str, identifier: str, backwards: bool) -> str:
    direction = "rtl" if backwards else "ltr"
    spine = "".join(f'<itemref idref="{name}"/>' for name in names)
    return (
        '<package xmlns="http://www.idpf.org/2007/opf" version="3.0" unique-identifier="id">'
        '<metadata xmlns:dc="http://purl.org/dc/elements/1.1/">'
        f'<dc:identifier id="id">{identifier}</dc:identifier><dc:title>{xml_text(title)}</dc:title>'
        f'<dc:language>und</dc:language><meta property="dcterms:modified">{_MODIFIED}</meta>'
        '<meta property="rendition:layout">pre-paginated</meta>'
        '<meta property="rendition:spread">none</meta></metadata><manifest>'
        '<item id="contents" href="contents.xhtml" media-type="application/xhtml+xml" properties="nav"/>'
        f"{''.join(_manifest(names))}"
        f'</manifest><spine page-progression-direction="{direction}">{spine}</spine></package>\n'
    )


def _manifest(names: list[str]) -> Iterator[str]:
    for number, name in enumerate(names):
        cover = ' properties="cover-image"' if number == 0 else ""
        yield f'<item id="{name}" href="{name}.xhtml" media-type="application/xhtml+xml"/>'
        yield f'<item id="{name}-picture" href="{name}.jpg" media-type="image/jpeg"{cover}/>'
