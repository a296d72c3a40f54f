"""Captured frames restyled as is wished, at a working size that holds the rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from statistics import median

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.live.capture import Capture
from vidstyle.live.control import Controls
from vidstyle.live.hot_swap import HotSwapRenderer
from vidstyle.live.options import LiveOptions
from vidstyle.media.capture.input import CapturedFrame
from vidstyle.media.color_tags import HD_LINES
from vidstyle.media.read.convert import FrameConverter
from vidstyle.media.resize import letterboxed, resized, wanted_size


class FrameProcessor:
    """What lies between a captured frame and a restyled one."""

    def __init__(self, controls: Controls, options: LiveOptions, tell: Callable[[str], None]) -> None:
        """`tell`: is told when the style or the working size changes, and why a style does not run."""
        self._controls, self._tell = controls, tell
        self._keeps_rate = options.budget
        self._styler = HotSwapRenderer(controls.style, options.device, tell)
        self._pictures = FrameNormalizer(options.size)
        self._budget: AdaptiveScale | None = None
        self._rate = Fraction(0)

    @property
    def style(self) -> str:
        """The name of the style that runs."""
        return self._styler.style.name

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures; 0 before the first."""
        return self._pictures.size

    @property
    def given_up(self) -> str:
        """What was given up to hold the rate, or ""."""
        if self._styler.scale == 1:
            return ""
        width, height = self._styler.working_size(*self.size)
        return f"works at {width}x{height}"

    def frame(self, captured: CapturedFrame, capture: Capture, name: str) -> Picture:
        """The frame restyled; `name` is that of the source."""
        picture = self._pictures.picture(captured, capture, name)
        style = None if self._controls.bypassed else self._controls.style
        before = self.style
        result, changed = self._styler.run(picture, captured.time, self._pictures.encoding, style)
        if self.style != before:  # not for every step of a slider
            self._tell(f"style {self.style}")
        if changed and self._budget is not None:
            self._budget.restart()
        return result

    def hold(self, rate: Fraction) -> None:
        """From now on frames have to be done at this rate, if the options say so."""
        self._rate = rate
        self._budget = AdaptiveScale(float(1 / rate)) if self._keeps_rate else None

    def took(self, seconds: float) -> None:
        """A frame took so long in all; the working size goes by that."""
        if self._budget is None or self._controls.bypassed or not self._budget.spent(seconds):
            return
        self._styler.scale = self._budget.scale
        rate = f"{float(self._rate):.4g} fps"
        if self.given_up:
            self._tell(f"{self.style} {self.given_up} to hold {rate}")
        else:
            self._tell(f"{self.style} holds {rate} at its full size again")

    def close(self, seconds: float) -> None:
        """Let go of everything; only when no frame is being restyled."""
        self._styler.close(seconds)


class FrameNormalizer:
    """What the first frame decides for a session, whatever the source may become later.

    Attributes:
        size: width and height of the pictures; 0 before the first.
        encoding: of what goes out.
    """

    def __init__(self, size: tuple[int, int] | None) -> None:
        """`size`: wanted, one side perhaps -1 or -2; None: that of the first frame, with square pixels."""
        self._wanted = size
        self._square = (0, 0)
        self._maker: FrameConverter | None = None
        self.size = (0, 0)
        self.encoding = Encoding()

    def picture(self, captured: CapturedFrame, capture: Capture, name: str) -> Picture:
        """The frame upright, at the session's size, without alpha; `name` is that of the source."""
        if self._maker is None:
            self._begin(captured, capture, name)
        assert self._maker is not None
        picture = replace(self._maker.convert(captured.native)[0], alpha=None)
        return self._fitted(picture)

    def _begin(self, first: CapturedFrame, capture: Capture, name: str) -> None:
        aspect = capture.sample_aspect
        maker = FrameConverter(first.native, capture.codec, name, sample_aspect=aspect)
        maker.warn_if_hdr()
        # Neither a camera nor a page can say that its pixels are not square.
        self._square = max(1, round(maker.width * (maker.sample_aspect or 1))), maker.height
        self.size = wanted_size(self._wanted, *self._square) if self._wanted else self._square
        self.encoding = outgoing(maker.convert(first.native)[0])
        self._maker = maker

    def _fitted(self, picture: Picture) -> Picture:
        """The whole picture at the session's size, with bars where that has another shape."""
        square = resized(picture, *self._square)
        return square if self.size == self._square else letterboxed(square, *self.size)


def outgoing(picture: Picture) -> Encoding:
    """What pictures like this one go out in: 8 bit, 4:2:0, limited range, which every reader understands."""
    matrix = picture.encoding.matrix if picture.color is None else ""
    if matrix not in ("bt601", "bt709"):
        matrix = "bt709" if picture.shape[0] >= HD_LINES else "bt601"
    return Encoding(matrix, full_range=False, depth=8, step=(2, 2), siting=SITINGS["left"])


SCALES = (1.0, 0.75, 0.5, 0.375, 0.25)
"""Working sizes, as shares of the picture's width and height."""
FULL, ROOMY = 0.95, 0.65
"""Shares of the time between two frames: above the first a size is too large, below the second it fits."""
LOOK, PATIENCE, MAX_PATIENCE = 0.5, 2.0, 60.0
"""Seconds to look before going down; before going up; and that at most, after tries that failed."""
MIN_FRAMES, MAX_FRAMES = 3, 30
"""How many frames are looked at."""


class AdaptiveScale:
    """Chooses the working size from how long frames take.

    Attributes:
        scale: of SCALES.
    """

    def __init__(self, seconds: float, scales: tuple[float, ...] = SCALES) -> None:
        """`seconds`: between two frames, all of which the style may take."""
        self._seconds, self._scales = seconds, scales
        self._place = 0
        self._patience = PATIENCE
        self._since = self._rose = 0.0
        self._times: deque[float] = deque(maxlen=MAX_FRAMES)

    @property
    def scale(self) -> float:
        """The share of the width and of the height to work at."""
        return self._scales[self._place]

    def spent(self, seconds: float) -> bool:
        """Tell how long a frame took at the present size; whether the size changes for the next."""
        self._times.append(seconds)
        passed = max(seconds, self._seconds)
        self._since += passed
        self._rose += passed
        if self._since < LOOK or len(self._times) < MIN_FRAMES:
            return False
        usual = median(self._times)
        if usual > FULL * self._seconds and self._place + 1 < len(self._scales):
            # A rise that did not last is tried again later and later.
            self._patience = min(2 * self._patience, MAX_PATIENCE) if self._rose < 2 * LOOK else PATIENCE
            return self._go(self._fitting(usual))
        if self._place and self._since >= self._patience:
            larger = self._scales[self._place - 1]
            if usual * (larger / self.scale) ** 2 < ROOMY * self._seconds:
                self._rose = 0.0
                return self._go(self._place - 1)
        return False

    def restart(self) -> None:
        """Forget what was measured: another style runs now."""
        self._times.clear()
        self._since, self._patience = 0.0, PATIENCE

    def _fitting(self, usual: float) -> int:
        """The largest size below the present one that should do, or the smallest there is."""
        for place in range(self._place + 1, len(self._scales)):
            if usual * (self._scales[place] / self.scale) ** 2 < FULL * self._seconds:
                return place
        return len(self._scales) - 1

    def _go(self, place: int) -> bool:
        self._place = place
        self._times.clear()
        self._since = 0.0
        return True
