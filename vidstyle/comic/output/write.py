"""Write pages to files, in the format that the extension names."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial
from io import StringIO
from pathlib import Path

import cv2
import numpy as np

from vidstyle.comic.layout.paper import MAX_PAGE_PIXELS
from vidstyle.comic.layout.storyboard import timecode
from vidstyle.comic.moment import Moment
from vidstyle.comic.output.raster import MAX_JPEG_SIDE, cbz, jpeg, pdf, png
from vidstyle.comic.output.sheet import Sheet
from vidstyle.comic.output.svg import html, svg
from vidstyle.core.closing import Closing
from vidstyle.errors import OutputError, UsageError
from vidstyle.media.write.atomic import atomic_file
from vidstyle.media.write.images import is_numbered, numbered_path

_Encoder = Callable[[Iterable[Sheet], str], bytes]
"""Encodes pages as the content of a file with a title."""

_STRIP = ".html"
"""The format that suits one long page, in which words and places can be changed."""
_FORMATS: dict[str, _Encoder] = {
    ".png": png,
    ".jpg": jpeg,
    ".jpeg": jpeg,
    ".pdf": pdf,
    ".cbz": cbz,
    ".svg": svg,
    _STRIP: partial(html, page_file=""),
}
"""Output formats by the extension of the file."""
_DRAWN_BY_VIEWERS = ".svg", _STRIP
"""Formats that hold shapes and panels instead of a picture of the page."""
_MULTI_PAGE = ".pdf", ".cbz", _STRIP
"""Formats whose files hold all pages."""


class Output:
    """The file, or files, that pages are written to.

    Attributes:
        target: its name.
        is_strip: whether the format suits one long page, which can be edited.
    """

    def __init__(self, target: Path, source: str, overwrite: bool) -> None:
        """Check the target before there are pages.

        Raises:
            UsageError: unknown extension, the file exists, or it is the source.
            OutputError: its folder is missing or not writable.
        """
        if target.suffix.lower() not in _FORMATS:
            remedy = f"end its name in {', '.join(list(_FORMATS)[:-1])} or {list(_FORMATS)[-1]}"
            raise UsageError(target, "cannot be a comic page", remedy)
        self.is_strip = target.suffix.lower() == _STRIP
        self.target, self._source, self._overwrite = target, source, overwrite
        if not is_numbered(target.name):
            with atomic_file(target, source, overwrite):
                pass

    def check_pages(self, sizes: Iterable[tuple[int, int]]) -> None:
        """Raise UsageError if pages of these widths and heights are too large for the format."""
        kind = self.target.suffix.lower()
        for width, height in sizes if kind not in _DRAWN_BY_VIEWERS else ():
            side = math.inf if kind == ".png" else MAX_JPEG_SIDE
            if width * height > MAX_PAGE_PIXELS or max(width, height) > side:
                limit = f"{MAX_PAGE_PIXELS // 10**6} megapixels"
                limit += f" and {side} pixels a side" if side < math.inf else ""
                remedy = f"{limit} are possible; make smaller pages, or write .svg or {_STRIP}"
                raise UsageError(self.target, f"has a page of {width}x{height} pixels", remedy)

    def write(self, sheets: Iterable[Sheet], pages: int, title: str, page_file: str = "") -> list[Path]:
        """Write all pages; a page with a file of its own is written as soon as it is drawn.

        Args:
            sheets: the pages.
            pages: how many.
            title: of the comic.
            page_file: what a strip saves that was edited.

        Raises:
            UsageError: one of the files exists.
            OutputError: one cannot be written.
        """
        kind = self.target.suffix.lower()
        encode = partial(html, page_file=page_file) if kind == _STRIP else _FORMATS[kind]
        is_single = kind in _MULTI_PAGE
        targets = [self.target] if is_single else page_names(self.target, pages)
        with ExitStack() as files:
            # All targets are checked before the first page is drawn, which takes long.
            writers = [
                files.enter_context(atomic_file(target, self._source, self._overwrite)) for target in targets
            ]
            if is_single:
                writers[0](encode(sheets, title))
            else:
                for write, sheet in zip(writers, sheets, strict=True):
                    write(encode([sheet], title))
        return targets


def page_names(target: Path, pages: int) -> list[Path]:
    """The name of each page's file.

    >>> [path.name for path in page_names(Path("a.png"), 2)], page_names(Path("p%02d.jpg"), 1)[0].name
    (['a-1.png', 'a-2.png'], 'p01.jpg')
    """
    if not is_numbered(target.name):
        if pages == 1:
            return [target]
        target = target.with_name(f"{target.stem}-%0{len(str(pages))}d{target.suffix}")
    return [numbered_path(str(target), number) for number in range(1, pages + 1)]


TABLE = "frames.csv"


class Frames(Closing):
    """A folder that frames are saved to, one after another; a context manager.

    Raises:
        UsageError: a file exists and may not be replaced.
        OutputError: the folder cannot be made or written to.
    """

    def __init__(self, folder: Path, count: int, overwrite: bool) -> None:
        """`count`: how many frames there will be."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = f"cannot be made ({error.strerror})"
            raise OutputError(folder, reason, "choose another folder") from error
        digits = max(2, len(str(count)))
        self._names = [f"frame-{number:0{digits}}.png" for number in range(1, count + 1)]
        self._rows = [("panel", "file", "seconds", "time", "scene", "importance")]
        with ExitStack() as files:
            self._writers = [
                files.enter_context(atomic_file(folder / name, overwrite=overwrite))
                for name in [*self._names, TABLE]
            ]
            self._files = files.pop_all()

    def close(self) -> None:
        self._files.close()

    def save(self, color: np.ndarray, moment: Moment) -> None:
        """Save the next frame, H x W x 3 uint8; after the last one, the table."""
        number = len(self._rows)
        done, content = cv2.imencode(".png", color[..., ::-1])
        assert done
        self._writers[number - 1](content.tobytes())
        time = f"{moment.time:.3f}", timecode(moment.time)
        weight = f"{moment.importance:.3f}"
        self._rows.append((str(number), self._names[number - 1], *time, str(moment.scene + 1), weight))
        if number == len(self._names):
            table = StringIO()
            csv.writer(table, lineterminator="\n").writerows(self._rows)
            self._writers[-1](table.getvalue().encode())
