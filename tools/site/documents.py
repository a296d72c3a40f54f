"""The documents of the repository as pages of the site."""

from __future__ import annotations

import os
import re
import shutil
from functools import cache
from pathlib import Path

import cv2

ROOT = Path(__file__).parents[2]
GALLERY = "docs/gallery.md"
OTHER_DOCUMENTS = {
    "filters_bank/README.md": "filters.md",
    "CONTRIBUTING.md": "contributing.md",
    "SECURITY.md": "security.md",
    "CHANGELOG.md": "changelog.md",
}
"""Documents outside `docs`, and their pages."""
MAX_PICTURE_WIDTH_PX = 1000
PICTURE_QUALITY = 60
_IMAGE = re.compile(r'(<img [^>]*src=")([^"]+)(")')
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def heading_id(text: str, separator: str) -> str:
    """Return the anchor of a heading, as used by links in the documents.

    >>> heading_id("Bad input: 1, 2 & `x`", "-")
    'bad-input-1-2--x'
    """
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", separator)


@cache
def documents() -> dict[str, str]:
    """Return the page of each document: first the README, then in the order of its links."""
    names = [f"docs/{path.name}" for path in sorted((ROOT / "docs").glob("*.md"))]
    links = [address.partition("#")[0] for _, _, address in _LINK.findall(_read("README.md"))]
    ordered = [name for name in dict.fromkeys([*links, *names]) if name in names and name != GALLERY]
    return {"README.md": "index.md"} | {name: Path(name).name for name in ordered} | OTHER_DOCUMENTS


def page_titles() -> list[dict[str, str]]:
    """Return the title and page of each document except the README, for the navigation."""
    named = list(documents().items())[1:]
    return [
        {_read(name).partition("\n")[0].removeprefix("# ").replace("`", ""): page} for name, page in named
    ]


def copy_documents(pages: Path) -> None:
    """Write all documents to a folder, with links between the pages, and their pictures."""
    for source, target in documents().items():
        (pages / target).write_text(_with_page_links(_read(source), source, pages), encoding="utf-8")
    shutil.copy(Path(__file__).with_name("site.css"), pages / "site.css")


def _read(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def _with_page_links(text: str, source: str, pages: Path) -> str:
    """Rewrite the links of a document to pages and pictures of the site; links to other files become text."""

    def replace(match: re.Match[str]) -> str:
        mark, label, address = match.groups()
        if address.startswith(("#", "http:", "https:", "mailto:")):
            return match[0]
        path, _, anchor = address.partition("#")
        name = os.path.normpath(os.path.join(os.path.dirname(source), path))
        if mark:
            return f"![{label}]({copy_picture(ROOT / name, pages)})"
        if name == GALLERY:
            return f"[{label}](styles/{anchor or 'index'}.md)"
        if name in documents():
            return f"[{label}]({documents()[name]}{'#' + anchor if anchor else ''})"
        if Path(name).suffix in (".jpg", ".webp"):
            return f"[{label}]({copy_picture(ROOT / name, pages)})"
        return _LINK.sub(replace, label)

    def replace_image(match: re.Match[str]) -> str:
        return match[1] + copy_picture(ROOT / os.path.dirname(source) / match[2], pages) + match[3]

    return _IMAGE.sub(replace_image, _LINK.sub(replace, text))


def copy_picture(path: Path, pages: Path, width: int = MAX_PICTURE_WIDTH_PX) -> str:
    """Copy a picture to the folder `pictures`, scaled down, and return its address relative to the root."""
    target = pages / "pictures" / (path.name if path.suffix != ".jpg" else f"{path.stem}-small.webp")
    target.parent.mkdir(exist_ok=True)
    picture = cv2.imread(str(path)) if path.suffix == ".jpg" else None
    if picture is None:  # a drawing or an animation
        shutil.copy(path, target)
    else:
        factor = min(1, width / picture.shape[1])
        small = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(target), small, [cv2.IMWRITE_WEBP_QUALITY, PICTURE_QUALITY])
    return f"pictures/{target.name}"
