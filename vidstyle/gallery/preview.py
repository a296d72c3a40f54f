"""Preview of one picture in several styles, as a self-contained HTML page or a sheet."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from fractions import Fraction
from html import escape
from pathlib import Path
from string import Template

import cv2
import numpy as np

from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError, UsageError, counted, log, printable
from vidstyle.export import join_modules, module_text
from vidstyle.gallery.search_words import search_words
from vidstyle.gallery.style_samples import (
    StyleSample,
    encode_picture,
    jpeg_address,
    samples_of,
    sheet_of_samples,
)
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader, open_source
from vidstyle.media.write.atomic import atomic_file
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress
from vidstyle.style import Style, table_from_style
from vidstyle.style.knobs import knobs_of
from vidstyle.style.model import KINDS

MAX_SIDE = 960
"""Maximum longer side of the picture in pixels; styles take seconds at this size."""

_PREVIEW_SUFFIXES = (".html", ".png", ".jpg")

_FIGURE_TEMPLATE = Template("""\
<figure data-command="$command" data-kinds="$kinds" data-aliases="$aliases"
 data-words="$words">
<button type="button" aria-label="Enlarge"><img src="$picture" alt="$name" width="$width"
 height="$height"></button>
<button type="button" class="star plain" aria-pressed="false" aria-label="Star"
 title="Star (S)"></button>
<figcaption><strong>$name</strong> <span class="about">$about</span>
<span class="note" hidden>$note</span></figcaption>
</figure>
""")
_SHEET_FOLDER = Path(__file__).with_name("preview_sheet")


def write_preview(
    source: str | Path,
    target: str | Path,
    styles: Sequence[Style],
    read: ReadOptions | None = None,
    overwrite: bool = False,
    on_step: ProgressCallback = ignore_progress,
) -> str:
    """Write a picture of the source in several styles.

    Args:
        source: a picture or a film.
        target: a page (.html) or a sheet (.png, .jpg).
        styles: the styles in order; the first leaves the picture unchanged.
        read: read options; without a start, the middle of a film is used.
        overwrite: whether to replace an existing target.
        on_step: receives progress.

    Returns:
        The heading of the preview.

    Raises:
        UsageError: the target has another suffix, exists, or is the source.
        InputError: the source cannot be read.
        OutputError: the target cannot be written.
    """
    target = Path(target)
    suffix = target.suffix.lower()
    if suffix not in _PREVIEW_SUFFIXES:
        raise UsageError(target, "cannot be a preview", f"end its name in {' or '.join(_PREVIEW_SUFFIXES)}")
    count = len(styles) - 1
    name = "standard input" if str(source) == "-" else Path(source).name
    heading = f"{name} in {counted(count, 'style')}"
    with atomic_file(target, source, overwrite) as write:
        picture = read_still(source, read)
        samples = []
        on_step("drawing styles", 0, len(styles))
        for sample in samples_of(picture, styles):
            samples.append(sample)
            on_step("drawing styles", len(samples), len(styles))
        if suffix == ".html":
            write(preview_page(name, name, samples).encode("utf-8"))
        else:
            sheet = sheet_of_samples([(sample.style.name, sample.picture) for sample in samples])
            write(encode_picture(sheet, suffix))
    return heading


def preview_page(name: str, source: str, samples: Sequence[StyleSample], ending: str = "") -> str:
    """Return a self-contained HTML page with a picture for each sample.

    Args:
        name: the file name of the picture, to show.
        source: the file name of the source, for commands.
        samples: at least one.
        ending: of the files of the styles; empty for styles that have a name only.
    """
    template = Template((_SHEET_FOLDER / "sheet.html").read_text(encoding="utf-8"))
    return template.substitute(
        name=escape(printable(name)),
        count=counted(sum(sample.style.name != "plain" for sample in samples), "look"),
        kinds=escape(", ".join(KINDS.values())),
        ending=escape(ending),
        choose=", with the style file" if ending else ", and choose",
        figures="".join(_figure(source, ending, sample) for sample in samples),
        style=module_text("components.css"),
        script=join_modules(_SHEET_FOLDER / "sheet.js"),
    )


def _figure(source: str, ending: str, sample: StyleSample) -> str:
    height, width = sample.picture.shape[:2]
    style, name = sample.style, sample.style.name
    labels = [knob.label for knob in knobs_of(style, table_from_style(style)).values()]
    note = f"{style.about} Adjust: {', '.join(labels)}." if labels else style.about
    path = Path(printable(source))
    output = f"{path.stem}-{name}{path.suffix}"
    files = f"{shlex.quote(str(path))} {shlex.quote(output)}"
    command = f"vidstyle render {files} --style {shlex.quote(name + ending)}"
    return _FIGURE_TEMPLATE.substitute(
        name=escape(name),
        command=escape(command),
        kinds=escape(", ".join(KINDS[kind] for kind in style.kinds)),
        aliases=escape(style.aliases),
        words=escape(", ".join(search_words(style))),
        about=_to_html(style.about),
        note=_to_html(note),
        picture=jpeg_address(sample.picture),
        width=width,
        height=height,
    )


def _to_html(note: str) -> str:
    """Convert a note to HTML; text in backquotes becomes code.

    >>> _to_html("Tune `a.b` & <c>.")
    'Tune <code>a.b</code> &amp; &lt;c&gt;.'
    """
    return re.sub("`([^`]*)`", r"<code>\1</code>", escape(note))


def read_still(source: str | Path, read: ReadOptions | None = None, max_side: float = MAX_SIDE) -> np.ndarray:
    """Read one picture, upright, with square pixels and no side above a maximum: H x W x 3 uint8.

    Args:
        source: the input, see `open_reader`.
        read: read options; without a start, the middle of a film or the first picture of a pipe is used.
        max_side: in pixels.

    Raises:
        InputError: the source cannot be read, or has no picture at that time.
    """
    read = read or ReadOptions()
    middle = _middle(source, read) if read.start is None and str(source) != "-" else None
    if middle is not None:
        try:
            return _read(source, replace(read, start=middle), max_side)
        except InputError:
            log.warning("%s: no frame in the middle of its nominal duration; showing the first one", source)
    return _read(source, read, max_side)


def _middle(source: str | Path, read: ReadOptions) -> Fraction | None:
    """Return half of the duration of a film; None for a single picture."""
    with closing(open_source(source, read)) as opened:
        return opened.duration / 2 if opened.duration and opened.frames != 1 else None


def _read(source: str | Path, read: ReadOptions, max_side: float) -> np.ndarray:
    with open_reader(source, read) as reader:
        color = to_rgb(next(item for item in reader if isinstance(item, Frame)).picture)
        return _resize(color, round(color.shape[1] * (reader.info.sample_aspect or 1)), max_side)


def _resize(color: np.ndarray, width: int, max_side: float) -> np.ndarray:
    """Resize to this width, for square pixels, and reduce to `max_side`."""
    height = color.shape[0]
    factor = min(1, max_side / max(width, height))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    smaller = size[0] <= color.shape[1] and size[1] <= height
    return cv2.resize(color, size, interpolation=cv2.INTER_AREA if smaller else cv2.INTER_LINEAR)
