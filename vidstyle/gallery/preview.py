"""Somebody's own picture in every style, as a page or a sheet."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from vidstyle.errors import UsageError
from vidstyle.gallery.encode import encoded
from vidstyle.gallery.page import page_of
from vidstyle.gallery.samples import StyleSample, samples_of
from vidstyle.gallery.sheet import sheet_of_samples
from vidstyle.gallery.still import read_still
from vidstyle.media.read.reader import ReadOptions
from vidstyle.media.write.atomic import whole_file
from vidstyle.style import Style


def write_preview(
    source: str | Path,
    target: str | Path,
    styles: Sequence[Style],
    read: ReadOptions | None = None,
    overwrite: bool = False,
) -> str:
    """Write a picture of the source in the styles, the first of which leaves it as it is.

    Args:
        source: a picture or a film.
        target: a page (.html) or a sheet (.png, .jpg).
        styles: in the order in which they are shown.
        read: how to read the source; without a start, the middle of a film is taken.
        overwrite: whether the target may exist.

    Returns:
        What it shows, in words.

    Raises:
        UsageError: the target's ending is another, it exists, or it is the source.
        InputError: the source cannot be read.
        OutputError: the target cannot be written.
    """
    target = Path(target)
    content_of = _kind(target)
    count = len(styles) - 1
    name = "standard input" if str(source) == "-" else Path(source).name
    heading = f"{name} in {count} style{'s' * (count != 1)}"
    with whole_file(target, source, overwrite) as write:
        samples = list(samples_of(read_still(source, read), styles))
        write(content_of(heading, samples))
    return heading


def _kind(target: Path) -> Callable[[str, list[StyleSample]], bytes]:
    kinds = {".html": _page, ".png": _png, ".jpg": _jpeg}
    try:
        return kinds[target.suffix.lower()]
    except KeyError:
        raise UsageError(target, "is no kind of preview", f"end its name in {' or '.join(kinds)}") from None


def _page(heading: str, samples: list[StyleSample]) -> bytes:
    return page_of(heading, samples).encode("utf-8")


def _png(_: str, samples: list[StyleSample]) -> bytes:
    return encoded(_sheet(samples), ".png")


def _jpeg(_: str, samples: list[StyleSample]) -> bytes:
    return encoded(_sheet(samples), ".jpg")


def _sheet(samples: list[StyleSample]) -> np.ndarray:
    return sheet_of_samples([(sample.style.name, sample.picture) for sample in samples])
