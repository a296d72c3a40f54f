"""How a page measures the pictures that it has shown."""

from __future__ import annotations

from io import BytesIO

from live_page import live_frame, showing
from PIL import Image

from vidstyle.live.page.viewer import JpegQuality
from vidstyle.media.capture.monotonic import Clock


class FixedClock(Clock):
    """A clock that stands still: all pictures are shown at once."""

    def now(self) -> float:
        return 100.0


def tables_of(jpeg: bytes) -> object:
    """The quantization tables of a picture, which its quality decides."""
    return Image.open(BytesIO(jpeg)).quantization  # type: ignore[attr-defined]


def test_pictures_that_are_shown_at_once_keep_their_quality() -> None:
    with showing(clock=FixedClock()) as (page, _, visitor), visitor.look() as window:
        number, first = window.picture()
        for following in range(1, 3 * JpegQuality.FEW):
            window.say(do="shown", number=number)
            page.offer(live_frame(following))
            number, data = window.picture()
    assert tables_of(data) == tables_of(first)
