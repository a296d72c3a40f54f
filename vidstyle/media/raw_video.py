"""Raw video: frames one after another, without a header."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from vidstyle.errors import UsageError

RAW = "rawvideo"
"""FFmpeg's name for it."""


@dataclass(frozen=True)
class RawVideo:
    """What the user has to say about it.

    Attributes:
        size: width and height; None: it was not said.
        pix_fmt: FFmpeg's name of the pixel format.
    """

    size: tuple[int, int] | None = None
    pix_fmt: str = "yuv420p"

    def check(self) -> None:
        """Raise UsageError if it cannot be read so."""
        if self.size is None:
            raise UsageError("raw video", "its size is not known", "say it with --input-size")

    def demuxer_options(self, rate: Fraction) -> dict[str, str]:
        """What FFmpeg is told to read it at so many frames a second; raises UsageError as `check`."""
        self.check()
        assert self.size is not None
        return {
            "video_size": "{}x{}".format(*self.size),
            "pixel_format": self.pix_fmt,
            "framerate": str(rate),
        }
