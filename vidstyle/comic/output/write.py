"""Pages into files: which kind the name asks for, and how many there are."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.comic.layout.storyboard import timecode
from vidstyle.comic.moment import Moment
from vidstyle.comic.output.bitmap import cbz, jpeg, pdf, png
from vidstyle.comic.output.html import html
from vidstyle.comic.output.sheet import Sheet
from vidstyle.comic.output.svg import svg
from vidstyle.errors import OutputError, UsageError
from vidstyle.media.write.atomic import atomic_file


class _Format(NamedTuple):
    """How a file is made of pages and a title, and whether it holds all pages."""

    content: Callable[[Iterable[Sheet], str], bytes]
    holds_all: bool = False


_FORMATS = {
    ".png": _Format(png),
    ".jpg": _Format(jpeg),
    ".jpeg": _Format(jpeg),
    ".pdf": _Format(pdf, holds_all=True),
    ".cbz": _Format(cbz, holds_all=True),
    ".svg": _Format(svg),
    ".html": _Format(html, holds_all=True),
}
"""Output formats by the extension of the file."""

_PATTERN = re.compile(r"%0?\d*d")


class Output:
    """The file, or files, that pages are written to.

    Attributes:
        is_strip: whether it is to be scrolled through, so that pages make little sense.
    """

    def __init__(self, target: Path, source: str, overwrite: bool) -> None:
        """Check all that can be known before there are pages.

        Raises:
            UsageError: its ending is none of ours, it exists, or it is the source.
            OutputError: its folder is missing or cannot be written to.
        """
        if target.suffix.lower() not in _FORMATS:
            remedy = f"end its name in {', '.join(list(_FORMATS)[:-1])} or {list(_FORMATS)[-1]}"
            raise UsageError(target, "is no kind of comic", remedy)
        self._format = _FORMATS[target.suffix.lower()]
        self.is_strip = self._format.content is html
        self._target, self._source, self._overwrite = target, source, overwrite
        if not _PATTERN.search(target.name):
            with atomic_file(target, source, overwrite):
                pass

    def targets(self, pages: int) -> list[Path]:
        """The names of the files for so many pages."""
        return [self._target] if self._format.holds_all else page_names(self._target, pages)

    def write(self, sheets: Iterable[Sheet], pages: int, title: str) -> list[Path]:
        """Write all pages, each as soon as it is there where each has a file of its own.

        Raises:
            UsageError: one of the files exists.
            OutputError: one cannot be written.
        """
        targets = self.targets(pages)
        with ExitStack() as files:
            # All are claimed before the first page is drawn, which takes long.
            writers = [
                files.enter_context(atomic_file(target, self._source, self._overwrite)) for target in targets
            ]
            if self._format.holds_all:
                writers[0](self._format.content(sheets, title))
            else:
                for write, sheet in zip(writers, sheets, strict=True):
                    write(self._format.content([sheet], title))
        return targets


def page_names(target: Path, pages: int) -> list[Path]:
    """A name for each page, where each has a file of its own.

    >>> [path.name for path in page_names(Path("a.png"), 2)], page_names(Path("p%02d.jpg"), 1)[0].name
    (['a-1.png', 'a-2.png'], 'p01.jpg')
    """
    if _PATTERN.search(target.name):
        return [target.with_name(_numbered(target.name, number)) for number in range(1, pages + 1)]
    if pages == 1:
        return [target]
    digits = len(str(pages))
    return [
        target.with_name(f"{target.stem}-{number:0{digits}}{target.suffix}") for number in range(1, pages + 1)
    ]


def _numbered(pattern: str, number: int) -> str:
    return _PATTERN.sub(lambda found: found[0] % number, pattern)


TABLE = "frames.csv"


class Frames:
    """A folder that frames are saved in, as they come; a context manager.

    Raises:
        UsageError: a file exists and may not be replaced.
        OutputError: the folder cannot be made or written to.
    """

    def __init__(self, folder: Path, count: int, overwrite: bool) -> None:
        """`count`: how many frames there will be."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(
                folder, f"cannot be made ({error.strerror})", "choose another folder"
            ) from error
        digits = max(2, len(str(count)))
        self._names = [f"frame-{number:0{digits}}.png" for number in range(1, count + 1)]
        self._rows = [("panel", "file", "seconds", "time", "scene", "importance")]
        with ExitStack() as files:
            self._writers = [
                files.enter_context(atomic_file(folder / name, overwrite=overwrite))
                for name in [*self._names, TABLE]
            ]
            self._files = files.pop_all()

    def __enter__(self) -> Frames:
        return self

    def __exit__(self, *_: object) -> None:
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
