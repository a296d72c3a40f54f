"""Captured frames, restyled at a working size that holds the rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from statistics import median

from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.errors import VidstyleError, log
from vidstyle.live.capture import Capture
from vidstyle.live.control import Controls, LiveOptions
from vidstyle.live.hot_swap import HotSwapRenderer
from vidstyle.media.capture.input import CapturedFrame
from vidstyle.media.color_tags import MIN_HD_HEIGHT
from vidstyle.media.read.frame_converter import FrameConverter
from vidstyle.media.resize import letterbox_picture, output_size, resize_picture


class FrameProcessor:
    """Turns captured frames into restyled pictures."""

    def __init__(self, controls: Controls, options: LiveOptions, notify: Callable[[str], None]) -> None:
        """`notify`: receives messages when the style or the working size changes, and errors of styles."""
        self._controls, self._notify = controls, notify
        self._is_adaptive = options.budget
        self._renderer = HotSwapRenderer(controls.style, options.device, notify)
        self._normalizer = FrameNormalizer(options.size)
        self._scale: AdaptiveScale | None = None
        self._rate = Fraction(0)

    @property
    def style(self) -> str:
        """The name of the style that runs."""
        return self._renderer.style.name

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the output; 0 before the first frame."""
        return self._normalizer.size

    @property
    def degraded(self) -> str:
        """A description of the reduced working size, or ""."""
        if self._renderer.scale == 1:
            return ""
        width, height = self._renderer.working_size(*self.size)
        return f"smaller picture to keep up: {width} × {height}"

    def process(self, captured: CapturedFrame, capture: Capture, name: str) -> Picture:
        """Restyle a frame; `name` is the name of the source."""
        picture = self._normalizer.normalize(captured, capture, name)
        try:
            self._controls.follow(captured.time)
        except VidstyleError as error:  # a style file that has changed since
            self._notify(str(error))
        style = None if self._controls.bypassed else self._controls.look
        before = self.style
        result, changed = self._renderer.run(picture, captured.time, self._normalizer.encoding, style)
        if self.style != before:  # not for every step of a slider
            self._notify(f"style {self.style}")
        if changed and self._scale is not None:
            self._scale.reset()
        return result

    def set_rate(self, rate: Fraction) -> None:
        """From now on, adapt the working size to this rate, if the options allow it."""
        self._rate = rate
        self._scale = AdaptiveScale(float(1 / rate), min(self.size)) if self._is_adaptive else None

    def record_time(self, seconds: float) -> None:
        """Record the time that a frame took, by which the working size is adapted."""
        if self._controls.full_size:
            return self._keep_full_size()
        if self._scale is None or self._controls.bypassed or not self._scale.update(seconds):
            return
        self._renderer.scale = self._scale.scale
        rate, degraded, reached = f"{float(self._rate):.4g} fps", self.degraded, self._scale.lower_rate
        fewer = f" and about {reached:.3g} fps" if reached else ""
        slow = f"too slow for {rate} at full size: {degraded}{fewer}"
        self._notify(
            f"{self.style} is {slow}" if degraded else f"{self.style} holds {rate} at full size again"
        )
        if degraded:  # in the terminal only: the page has no command line
            log.info("%s: --budget off keeps the size", self.style)

    def _keep_full_size(self) -> None:
        if self._renderer.scale != 1:
            self._renderer.scale = 1
            self.set_rate(self._rate)

    def close(self, timeout: float) -> None:
        """Release everything; only when no frame is being processed."""
        self._renderer.close(timeout)


class FrameNormalizer:
    """Brings all frames to the size and orientation of the first, however the source may change.

    Attributes:
        size: width and height of the pictures; 0 before the first.
        encoding: of the output.
    """

    def __init__(self, size: tuple[int, int] | None) -> None:
        """`size`: the output size, one side may be -1 or -2; None: the size of the first frame."""
        self._wanted = size
        self._square = (0, 0)
        self._converter: FrameConverter | None = None
        self.size = (0, 0)
        self.encoding = Encoding()

    def normalize(self, captured: CapturedFrame, capture: Capture, name: str) -> Picture:
        """Return the frame upright, at the size of the session, without alpha; letterbox another shape.

        Args:
            name: the name of the source.
        """
        if self._converter is None:
            self._converter = self._begin(captured, capture, name)
        picture = replace(self._converter.convert(captured.native)[0], alpha=None)
        square = resize_picture(picture, *self._square)
        return square if self.size == self._square else letterbox_picture(square, *self.size)

    def _begin(self, first: CapturedFrame, capture: Capture, name: str) -> FrameConverter:
        aspect = capture.sample_aspect
        converter = FrameConverter(first.native, capture.codec, name, sample_aspect=aspect)
        _report_mapped(converter, converter.convert(first.native)[0].encoding.depth)
        # Neither a camera nor a page can say that its pixels are not square.
        self._square = max(1, round(converter.width * (converter.sample_aspect or 1))), converter.height
        self.size = output_size(self._wanted, *self._square) if self._wanted else self._square
        self.encoding = output_encoding(converter.convert(first.native)[0])
        return converter


def _report_mapped(converter: FrameConverter, depth: int) -> None:
    """Report what of a source has no place in 8-bit SDR, which all targets take."""
    if not converter.warn_if_hdr() and depth > LIVE_DEPTH_BITS:
        log.warning("the source has %d bits per sample; they become %d", depth, LIVE_DEPTH_BITS)


LIVE_DEPTH_BITS = 8


def output_encoding(picture: Picture) -> Encoding:
    """The encoding that pictures like this one are delivered in: 8 bit, 4:2:0, limited range."""
    matrix = picture.encoding.matrix if picture.color is None else ""
    if matrix not in ("bt601", "bt709"):
        matrix = "bt709" if picture.shape[0] >= MIN_HD_HEIGHT else "bt601"
    return Encoding(
        matrix, full_range=False, depth=LIVE_DEPTH_BITS, subsampling=(2, 2), siting=SITINGS["left"]
    )


WORKING_SCALES = (1.0, 0.75, 0.5, 0.375, 0.25)
"""Working sizes, as shares of the picture's width and height."""
PREFERRED_MIN_SCALE, MIN_RATE_SHARE = 0.5, 0.4
"""Below this scale, the size is only reduced once the rate has fallen to this share."""
MIN_LINES = 180
"""Minimum height below the preferred scale; smaller pictures look pixelated."""
OVERLOAD_SHARE, HEADROOM_SHARE = 0.95, 0.65
"""Shares of the frame time: above the first, a size is too large; below the second, it fits."""
MEASURE_SECONDS, RAISE_SECONDS, MAX_RAISE_SECONDS = 0.5, 2.0, 60.0
"""Time before the size is reduced; before it is raised; and maximum of the latter after failed attempts."""
MIN_FRAMES, MAX_FRAMES = 3, 30
"""Number of frames measured."""


class AdaptiveScale:
    """Chooses the working size by the time that frames take; time passes by the frames that are recorded.

    The rate needs no choice: where a frame takes longer than the time between two, frames are dropped.

    Attributes:
        scale: the share of the width and of the height to work at, of WORKING_SCALES.
        lower_rate: frames per second that were measured at that size, if the rate cannot be held; else 0.
    """

    def __init__(self, seconds: float, lines: int) -> None:
        """`seconds`: between two frames; `lines`: the shorter side of the picture."""
        self._seconds, self._level = seconds, 0
        self._scales = [
            scale for scale in WORKING_SCALES if scale >= PREFERRED_MIN_SCALE or scale * lines >= MIN_LINES
        ]
        self.lower_rate = 0.0
        self._raise_after = RAISE_SECONDS
        self._since_change = self._since_rise = 0.0
        self._times: deque[float] = deque(maxlen=MAX_FRAMES)

    @property
    def scale(self) -> float:
        return self._scales[self._level]

    def update(self, seconds: float) -> bool:
        """Record the time of a frame at the present size.

        Returns:
            Whether the size changes for the next, or the rate turns out to be too high even so.
        """
        self._times.append(seconds)
        passed = max(seconds, self._seconds)
        self._since_change += passed
        self._since_rise += passed
        if self._since_change < MEASURE_SECONDS or len(self._times) < MIN_FRAMES:
            return False
        typical = median(self._times)
        if not self._fits(typical, self._level, OVERLOAD_SHARE) and self._level + 1 < len(self._scales):
            # A rise that did not last is attempted again later and later.
            failed = self._since_rise < 2 * MEASURE_SECONDS
            self._raise_after = min(2 * self._raise_after, MAX_RAISE_SECONDS) if failed else RAISE_SECONDS
            return self._set_level(self._fitting_level(typical))
        if self._level and self._since_change >= self._raise_after:
            if self._fits(typical, self._level - 1, HEADROOM_SHARE):
                self._since_rise = 0.0
                return self._set_level(self._level - 1)
        if self._level and not self.lower_rate and OVERLOAD_SHARE * typical > self._seconds:
            self.lower_rate = 1 / typical
            return True
        return False

    def reset(self) -> None:
        """Discard the measurements: another style runs now."""
        self._times.clear()
        self.lower_rate, self._since_change, self._raise_after = 0.0, 0.0, RAISE_SECONDS

    def _fitting_level(self, typical: float) -> int:
        """The largest size below the present one that should do, or the smallest there is."""
        level = self._level + 1
        while level + 1 < len(self._scales) and not self._fits(typical, level, OVERLOAD_SHARE):
            level += 1
        return level

    def _fits(self, typical: float, level: int, share: float) -> bool:
        """Whether a frame should take less than a share of the time that it may take at a size."""
        slots = 1 if self._scales[level] > PREFERRED_MIN_SCALE else 1 / MIN_RATE_SHARE
        return typical * (self._scales[level] / self.scale) ** 2 < share * slots * self._seconds

    def _set_level(self, level: int) -> bool:
        self._level, self.lower_rate = level, 0.0
        self._times.clear()
        self._since_change = 0.0
        return True
