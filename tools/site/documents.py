"""The documents of the repository as pages of the site."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import cv2

ROOT = Path(__file__).parents[2]
DOCUMENTS = {
    "README.md": ("Start", "index.md"),
    "docs/commands.md": ("Commands by example", "commands.md"),
    "docs/camera.md": ("Cameras and video calls", "camera.md"),
    "docs/design.md": ("Design a style", "design.md"),
    "docs/explore.md": ("Explore random styles", "explore.md"),
    "docs/cues.md": ("Change styles over time", "cues.md"),
    "docs/focus.md": ("Faces", "focus.md"),
    "docs/masks.md": ("People and background", "masks.md"),
    "docs/steady.md": ("Temporal stabilization", "steady.md"),
    "docs/everywhere.md": ("Browser, mpv, FFmpeg", "everywhere.md"),
    "docs/plug-in.md": ("In your own program", "plug-in.md"),
    "docs/batch.md": ("Many films", "batch.md"),
    "docs/scale.md": ("Clusters", "scale.md"),
    "docs/training.md": ("Train filters", "training.md"),
    "docs/networks.md": ("Neural networks", "networks.md"),
    "filters_bank/README.md": ("Shipped filters", "filters.md"),
    "docs/performance.md": ("Performance", "performance.md"),
    "docs/architecture.md": ("Architecture", "architecture.md"),
    "docs/reliability.md": ("Reliability", "reliability.md"),
    "docs/rules.md": ("Rules", "rules.md"),
    "CONTRIBUTING.md": ("Contribute", "contributing.md"),
    "SECURITY.md": ("Security", "security.md"),
    "CHANGELOG.md": ("Changes", "changelog.md"),
}
"""The title and the page of each document."""
GALLERY = "docs/gallery.md"
MAX_PICTURE_WIDTH_PX = 1000
PICTURE_QUALITY = 60
_IMAGE = re.compile(r'(<img [^>]*src=")([^"]+)(")')
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")


def heading_id(text: str, separator: str) -> str:
    """Return the identifier of a heading, as links in the documents have it.

    >>> heading_id("Bad input: 1, 2 & `x`", "-")
    'bad-input-1-2--x'
    """
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", separator)


def copy_documents(pages: Path) -> None:
    """Write all documents to a folder, with links between the pages, and their pictures.

    Raises:
        SystemExit: a document is missing in `DOCUMENTS`.
    """
    found = {f"docs/{path.name}" for path in (ROOT / "docs").glob("*.md")} - {GALLERY}
    if missing := found - DOCUMENTS.keys():
        raise SystemExit(f"add {', '.join(sorted(missing))} to DOCUMENTS in tools/site/documents.py")
    for source, (_, target) in DOCUMENTS.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        (pages / target).write_text(_with_page_links(text, source, pages), encoding="utf-8")
    shutil.copy(Path(__file__).with_name("site.css"), pages / "site.css")


def _with_page_links(text: str, source: str, pages: Path) -> str:
    """Return a document with links to pages and pictures of the site; links to other files become text."""

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
        if name in DOCUMENTS:
            return f"[{label}]({DOCUMENTS[name][1]}{'#' + anchor if anchor else ''})"
        if Path(name).suffix in (".jpg", ".webp"):
            return f"[{label}]({copy_picture(ROOT / name, pages)})"
        return _LINK.sub(replace, label)

    def replace_image(match: re.Match[str]) -> str:
        return match[1] + copy_picture(ROOT / os.path.dirname(source) / match[2], pages) + match[3]

    return _IMAGE.sub(replace_image, _LINK.sub(replace, text))


def copy_picture(path: Path, pages: Path, width: int = MAX_PICTURE_WIDTH_PX) -> str:
    """Copy a picture to the folder `pictures` of the pages, smaller; return its address from the top."""
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
