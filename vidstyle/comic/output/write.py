"""Output of pages to files, in the format that the suffix names."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial
from io import StringIO
from pathlib import Path

import numpy as np

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.paper import DEFAULT_DPI, MAX_PAGE_PIXELS, PRINT_DPI
from vidstyle.comic.layout.storyboard import format_timecode
from vidstyle.comic.output.epub import epub
from vidstyle.comic.output.raster import MAX_JPEG_SIDE_PX, cbz, jpeg, pdf, png
from vidstyle.comic.output.sheet import Sheet
from vidstyle.comic.output.svg import html, svg
from vidstyle.core.closing import Closing
from vidstyle.errors import OutputError, UsageError
from vidstyle.media.picture_bytes import png_bytes
from vidstyle.media.write.atomic import atomic_file
from vidstyle.media.write.images import is_numbered, numbered_path

_Encoder = Callable[[Iterable[Sheet], str], bytes]
"""Encodes pages as the content of a file with a title."""

_STRIP_SUFFIX = ".html"
"""The format for a browser, in which words and places can be changed."""
_PAGE_ENCODERS: dict[str, _Encoder] = {
    ".png": png,
    ".jpg": jpeg,
    ".jpeg": jpeg,
    ".pdf": pdf,
    ".cbz": cbz,
    ".epub": epub,
    ".svg": svg,
    _STRIP_SUFFIX: partial(html, page_file=""),
}
"""Output formats by the suffix of the file."""
_VIEWER_DRAWN_SUFFIXES = ".svg", _STRIP_SUFFIX
"""Formats that contain shapes and panels instead of a picture of the page."""
_MULTI_PAGE_SUFFIXES = ".pdf", ".cbz", ".epub", _STRIP_SUFFIX
"""Formats whose files contain all pages."""
_PRINT_SUFFIX = ".pdf"
"""The format for print, with the resolution of a printer."""


class Output:
    """The file or files to which pages are written.

    Attributes:
        target: its name.
        is_strip: whether the format is for a browser, in which it can be edited.
        is_printed: whether the format is for print, on paper of a fixed size.
        dpi: default resolution, pixels per inch.
    """

    def __init__(self, target: Path, source: str, overwrite: bool) -> None:
        """Check the target before the pages are made.

        Raises:
            UsageError: unknown suffix, the file exists, or it is the source.
            OutputError: its folder is missing or not writable.
        """
        if target.suffix.lower() not in _PAGE_ENCODERS:
            remedy = f"end its name in {', '.join(list(_PAGE_ENCODERS)[:-1])} or {list(_PAGE_ENCODERS)[-1]}"
            raise UsageError(target, "cannot be a comic page", remedy)
        self.is_strip = target.suffix.lower() == _STRIP_SUFFIX
        self.is_printed = target.suffix.lower() == _PRINT_SUFFIX
        self.dpi = PRINT_DPI if self.is_printed else DEFAULT_DPI
        self.target, self._source, self._overwrite = target, source, overwrite
        if not is_numbered(target.name):
            with atomic_file(target, source, overwrite):
                pass

    def check_pages(self, sizes: Iterable[tuple[int, int]]) -> None:
        """Raise UsageError if pages of these widths and heights are too large for the format."""
        kind = self.target.suffix.lower()
        for width, height in sizes if kind not in _VIEWER_DRAWN_SUFFIXES else ():
            side = math.inf if kind == ".png" else MAX_JPEG_SIDE_PX
            if width * height > MAX_PAGE_PIXELS or max(width, height) > side:
                limit = f"{MAX_PAGE_PIXELS // 10**6} megapixels"
                limit += f" and {side} pixels a side" if side < math.inf else ""
                remedy = f"{limit} are possible; make smaller pages, or write .svg or {_STRIP_SUFFIX}"
                raise UsageError(self.target, f"has a page of {width}x{height} pixels", remedy)

    def write(self, sheets: Iterable[Sheet], pages: int, title: str, page_file: str = "") -> list[Path]:
        """Write all pages; in formats with one file per page, each page is written when it is drawn.

        Args:
            sheets: the pages.
            pages: number of pages.
            title: of the comic.
            page_file: the page file that an edited strip saves.

        Raises:
            UsageError: one of the files exists.
            OutputError: one cannot be written.
        """
        kind = self.target.suffix.lower()
        if kind == _STRIP_SUFFIX:
            title = title or _title_of(Path(self._source))
        encode = partial(html, page_file=page_file) if kind == _STRIP_SUFFIX else _PAGE_ENCODERS[kind]
        is_single = kind in _MULTI_PAGE_SUFFIXES
        targets = [self.target] if is_single else page_names(self.target, pages)
        with ExitStack() as files:
            # All targets are checked before the first page is drawn, as drawing is slow.
            writers = [
                files.enter_context(atomic_file(target, self._source, self._overwrite)) for target in targets
            ]
            if is_single:
                writers[0](encode(sheets, title))
            else:
                for write, sheet in zip(writers, sheets, strict=True):
                    write(encode([sheet], title))
        return targets


_NO_TITLE = re.compile(
    r"(IMG|VID|MVI|PXL|DJI|DSC[A-Z]?|GOPRO?|G[HX])\d*|\d+(p|i|fps|k)|\d+x\d+|[hx]26[45]|hevc|av1|\d{5,}"
    r"|(?=.*\d)[0-9a-f]{8,}",
    re.IGNORECASE,
)
"""Parts of file names that are no words: those of cameras, sizes, rates, codecs, dates and digests."""


def _title_of(source: Path) -> str:
    """Return the name of a source as a title; empty if it holds no words.

    >>> _title_of(Path("summer_holiday-at-sea.mp4")), _title_of(Path("BigBuckBunny_1080p_30fps.mp4"))
    ('Summer holiday at sea', 'Big Buck Bunny')
    >>> _title_of(Path("IMG_20250816_101112.mov")), _title_of(Path("DSC04711.jpg"))
    ('', '')
    """
    words = re.split(r"[\s_.-]+|(?<=[a-z])(?=[A-Z])", source.stem)
    title = " ".join(word for word in words if word and not _NO_TITLE.fullmatch(word))
    return title[:1].upper() + title[1:]


def page_names(target: Path, pages: int) -> list[Path]:
    """Return the name of each page's file.

    >>> [path.name for path in page_names(Path("a.png"), 2)], page_names(Path("p%02d.jpg"), 1)[0].name
    (['a-1.png', 'a-2.png'], 'p01.jpg')
    """
    if not is_numbered(target.name):
        if pages == 1:
            return [target]
        target = target.with_name(f"{target.stem}-%0{len(str(pages))}d{target.suffix}")
    return [numbered_path(str(target), number) for number in range(1, pages + 1)]


TABLE_NAME = "frames.csv"


class Frames(Closing):
    """A folder to which frames are saved, one after another; a context manager.

    Raises:
        UsageError: a file exists and must not be replaced.
        OutputError: the folder cannot be created or written to.
    """

    def __init__(self, folder: Path, count: int, overwrite: bool) -> None:
        """`count`: number of frames."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = f"cannot be created ({error.strerror})"
            raise OutputError(folder, reason, "choose another folder") from error
        digits = max(2, len(str(count)))
        self._names = [f"frame-{number:0{digits}}.png" for number in range(1, count + 1)]
        self._rows = [("panel", "file", "seconds", "time", "scene", "importance")]
        with ExitStack() as files:
            self._writers = [
                files.enter_context(atomic_file(folder / name, overwrite=overwrite))
                for name in [*self._names, TABLE_NAME]
            ]
            self._list_font_files = files.pop_all()

    def close(self) -> None:
        self._list_font_files.close()

    def save(self, color: np.ndarray, key_frame: KeyFrame) -> None:
        """Save the next frame, H x W x 3 uint8; after the last one, also save the table."""
        number = len(self._rows)
        self._writers[number - 1](png_bytes(color))
        time = f"{key_frame.time:.3f}", format_timecode(key_frame.time)
        weight = f"{key_frame.importance:.3f}"
        self._rows.append((str(number), self._names[number - 1], *time, str(key_frame.scene + 1), weight))
        if number == len(self._names):
            table = StringIO()
            csv.writer(table, lineterminator="\n").writerows(self._rows)
            self._writers[-1](table.getvalue().encode())
