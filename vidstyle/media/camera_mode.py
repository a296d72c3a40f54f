"""Which of a camera's modes reaches the wanted size and rate."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from vidstyle.media.v4l2 import FORMATS, Mode

USUAL_SIZE = (1280, 720)
"""Larger pictures are taken only if they are asked for."""
SLACK = Fraction(98, 100)
"""29.97 will do for 30."""
EASE = {name: place for place, name in enumerate(FORMATS.values())}


def choose_mode(modes: Sequence[Mode], size: tuple[int, int] | None, rate: Fraction) -> Mode | None:
    """The mode that is nearest to what is wanted, or None if the camera has none that we can take.

    The rate comes first, for a slow mode cannot be helped, while another size is scaled. Of several the one
    that takes the least decoding is taken: MJPEG only where raw pictures would come too slowly.

    Args:
        size: width and height; None: the largest up to 1280x720.
        rate: frames per second.

    >>> slow, fast = Mode("yuyv422", 1280, 720, (Fraction(10),)), Mode("mjpeg", 1280, 720, (Fraction(30),))
    >>> choose_mode([slow, fast], (1280, 720), Fraction(30)).format
    'mjpeg'
    """
    return min(modes, key=lambda mode: _distance(mode, size, rate), default=None)


def mode_rate(mode: Mode, rate: Fraction) -> Fraction:
    """The slowest of the mode's rates that is enough, else its fastest; `rate` itself if it does not say."""
    enough = [each for each in mode.rates if each >= rate * SLACK]
    return min(enough) if enough else max(mode.rates, default=rate)


def _distance(mode: Mode, size: tuple[int, int] | None, rate: Fraction) -> tuple[float, ...]:
    reached = mode_rate(mode, rate)
    missing = 0.0 if reached >= rate * SLACK else float(rate - reached)
    pixels = mode.width * mode.height
    wanted = size or USUAL_SIZE
    too_small = max(0, wanted[0] - mode.width) + max(0, wanted[1] - mode.height)
    too_large = max(0, mode.width - wanted[0]) + max(0, mode.height - wanted[1])
    if size is None:
        # Any size up to the usual one will do, the largest of them best.
        return (missing, float(too_large > 0), float(-pixels if not too_large else pixels), EASE[mode.format])
    return (missing, float(too_small > 0), float(too_small + too_large), EASE[mode.format])
