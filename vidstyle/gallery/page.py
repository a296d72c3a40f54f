"""A page of samples in one file, which needs nothing else: it works offline."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path
from string import Template

from vidstyle.errors import printable
from vidstyle.gallery.encode import encoded
from vidstyle.gallery.samples import StyleSample

_TEMPLATE = Path(__file__).with_name("page.html")

_FIGURE = Template("""\
<figure>
<button type="button" aria-label="Show $name large"><img src="$picture" alt="$name" width="$width"
 height="$height"></button>
<figcaption><strong>$name</strong> <span>$note</span></figcaption>
</figure>
""")


def page_of(heading: str, samples: Sequence[StyleSample]) -> str:
    """The page, with a picture for each sample; the first is the source itself.

    Args:
        heading: what stands above.
        samples: at least one.
    """
    return Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        heading=escape(printable(heading)),
        figures="".join(map(_figure, samples)),
    )


def _figure(sample: StyleSample) -> str:
    height, width = sample.picture.shape[:2]
    return _FIGURE.substitute(
        name=escape(sample.style.name),
        note=_marked(sample.style.note or "The picture itself."),
        picture=f"data:image/jpeg;base64,{b64encode(encoded(sample.picture, '.jpg')).decode('ascii')}",
        width=width,
        height=height,
    )


def _marked(note: str) -> str:
    """The note as HTML; what stands in backquotes is code.

    >>> _marked("Tune `a.b` & <c>.")
    'Tune <code>a.b</code> &amp; &lt;c&gt;.'
    """
    return re.sub("`([^`]*)`", r"<code>\1</code>", escape(note))
