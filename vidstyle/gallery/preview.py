"""A picture in every style, as a self-contained HTML page or as a sheet."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

from vidstyle.errors import UsageError, printable
from vidstyle.gallery.still import read_still
from vidstyle.gallery.style_samples import StyleSample, encoded, samples_of, sheet_of_samples
from vidstyle.media.read.reader import ReadOptions
from vidstyle.media.write.atomic import atomic_file
from vidstyle.style import Style

_SUFFIXES = (".html", ".png", ".jpg")

_FIGURE = Template("""\
<figure>
<button type="button" aria-label="Show $name large"><img src="$picture" alt="$name" width="$width"
 height="$height"></button>
<figcaption><strong>$name</strong> <span>$note</span></figcaption>
</figure>
""")


def write_preview(
    source: str | Path,
    target: str | Path,
    styles: Sequence[Style],
    read: ReadOptions | None = None,
    overwrite: bool = False,
) -> str:
    """Write a picture of the source in several styles.

    Args:
        source: a picture or a film.
        target: a page (.html) or a sheet (.png, .jpg).
        styles: in the order in which they are shown; the first leaves the picture unchanged.
        read: how to read the source; without a start, the middle of a film is taken.
        overwrite: whether the target may exist.

    Returns:
        The heading of the preview.

    Raises:
        UsageError: the target has another suffix, exists, or is the source.
        InputError: the source cannot be read.
        OutputError: the target cannot be written.
    """
    target = Path(target)
    suffix = target.suffix.lower()
    if suffix not in _SUFFIXES:
        raise UsageError(target, "is no kind of preview", f"end its name in {' or '.join(_SUFFIXES)}")
    count = len(styles) - 1
    name = "standard input" if str(source) == "-" else Path(source).name
    heading = f"{name} in {count} style{'s' * (count != 1)}"
    with atomic_file(target, source, overwrite) as write:
        samples = list(samples_of(read_still(source, read), styles))
        if suffix == ".html":
            write(page_of(heading, samples).encode("utf-8"))
        else:
            sheet = sheet_of_samples([(sample.style.name, sample.picture) for sample in samples])
            write(encoded(sheet, suffix))
    return heading


def page_of(heading: str, samples: Sequence[StyleSample]) -> str:
    """A self-contained HTML page with a picture for each sample, at least one."""
    template = Template(Path(__file__).with_name("page.html").read_text(encoding="utf-8"))
    figures = "".join(map(_figure, samples))
    return template.substitute(heading=escape(printable(heading)), figures=figures)


def _figure(sample: StyleSample) -> str:
    height, width = sample.picture.shape[:2]
    return _FIGURE.substitute(
        name=escape(sample.style.name),
        note=_to_html(sample.style.note or "The picture itself."),
        picture=f"data:image/jpeg;base64,{b64encode(encoded(sample.picture, '.jpg')).decode('ascii')}",
        width=width,
        height=height,
    )


def _to_html(note: str) -> str:
    """The note as HTML; text in backquotes becomes code.

    >>> _to_html("Tune `a.b` & <c>.")
    'Tune <code>a.b</code> &amp; &lt;c&gt;.'
    """
    return re.sub("`([^`]*)`", r"<code>\1</code>", escape(note))
