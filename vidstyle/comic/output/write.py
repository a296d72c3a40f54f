"""Pages into files: which kind the name asks for, and how many there are."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path

from vidstyle.comic.output.formats import cbz, html, jpeg, pdf, png, svg
from vidstyle.comic.output.sheet import Sheet
from vidstyle.errors import UsageError
from vidstyle.media.write.atomic import whole_file

Content = Callable[[Iterable[Sheet], str], bytes]

_KINDS = {".png": png, ".jpg": jpeg, ".jpeg": jpeg, ".pdf": pdf, ".cbz": cbz, ".svg": svg, ".html": html}
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
        if target.suffix.lower() not in _KINDS:
            remedy = f"end its name in {', '.join(list(_KINDS)[:-1])} or {list(_KINDS)[-1]}"
            raise UsageError(target, "is no kind of comic", remedy)
        self._kind = _KINDS[target.suffix.lower()]
        self.is_strip = self._kind is html
        self._target, self._source, self._overwrite = target, source, overwrite
        if not _PATTERN.search(target.name):
            with whole_file(target, source, overwrite):
                pass

    def targets(self, pages: int) -> list[Path]:
        """The names of the files for so many pages."""
        return [self._target] if self._kind.SEVERAL else page_names(self._target, pages)

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
                files.enter_context(whole_file(target, self._source, self._overwrite)) for target in targets
            ]
            if self._kind.SEVERAL:
                writers[0](self._kind.content(sheets, title))
            else:
                for write, sheet in zip(writers, sheets, strict=True):
                    write(self._kind.content([sheet], title))
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
