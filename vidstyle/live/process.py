"""Captured frames, restyled at a working size that holds the rate."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from statistics import median

import numpy as np

from vidstyle.core.convert import convert
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
    """Turns captured frames into restyled pictures.

    Attributes:
        original: the last picture before it was restyled; None before the first.
        undivided: the last restyled picture without the comparison; None if it had none.
    """

    def __init__(self, controls: Controls, options: LiveOptions, notify: Callable[[str], None]) -> None:
        """`notify`: receives messages when the style or the working size changes, and errors of styles."""
        self._controls, self._notify = controls, notify
        self._is_adaptive = options.budget
        self._renderer = HotSwapRenderer(controls.style, options.device, notify)
        self._normalizer = FrameNormalizer(options.size)
        self._scale: AdaptiveScale | None = None
        self._rate = Fraction(0)
        self.original: Picture | None = None
        self.undivided: Picture | None = None

    @property
    def style(self) -> str:
        """The name of the style that runs."""
        return self._renderer.style.name

    @property
    def preparing(self) -> str:
        """The name of the style that will run once it is prepared, or ""."""
        wanted = self._controls.look
        is_next = not self._controls.bypassed and not self._renderer.has_request(wanted)
        return wanted.name if is_next and wanted.name != self.style else self._renderer.preparing

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
        self.original = picture = self._normalizer.normalize(captured, capture, name)
        try:
            self._controls.follow(captured.time)
        except VidstyleError as error:  # a style file that has changed since
            self._notify(str(error))
        style = None if self._controls.bypassed else self._controls.look
        before = self.style
        target = self._normalizer.encoding
        result, changed = self._renderer.run(picture, captured.time, target, style)
        self.undivided = None
        if style is not None and self._controls.split:
            self.undivided = result
            result = beside(convert(picture, target), result, self._controls.split)
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
        degraded, slow = self.degraded, self._scale.slow_rate
        reached = f"{self.style} reached only {slow:.3g} fps: {degraded}"
        self._notify(reached if slow else f"{self.style}: {degraded or 'back to full detail'}")
        if slow:  # in the terminal only: the page has no command line
            log.info("%s: --budget off keeps the size", self.style)

    def _keep_full_size(self) -> None:
        if self._renderer.scale != 1:
            self._renderer.scale = 1
            self.set_rate(self._rate)

    def close(self, timeout: float) -> None:
        """Release everything; only when no frame is being processed."""
        self._renderer.close(timeout)


def beside(before: Picture, after: Picture, share: float) -> Picture:
    """Return a picture whose left share is `before` and whose rest is `after`, of the same encoding."""
    planes = [
        np.concatenate((old[:, : (across := round(share * old.shape[1]))], new[:, across:]), axis=1)
        for old, new in zip(_planes(before), _planes(after), strict=True)
    ]
    return Picture(after.encoding, planes[0], (planes[1], planes[2]))


def _planes(picture: Picture) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return luma and chroma, which is neutral for gray pictures."""
    assert picture.luma is not None
    encoding = picture.encoding
    shape, neutral = encoding.chroma_shape(*picture.shape), encoding.chroma_levels[0]
    return picture.luma, *(picture.chroma or (np.full(shape, neutral, encoding.dtype),) * 2)


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
MIN_SMOOTH_RATE = 24
"""Frames per second at which films look smooth; the size is not reduced for more."""
PREFERRED_MIN_SCALE, MIN_RATE_SHARE = 0.5, 0.5
"""Below this scale, the size is only reduced once the rate has fallen to this share."""
MIN_LINES = 180
"""Minimum height below the preferred scale; smaller pictures look pixelated."""
OVERLOAD_SHARE, HEADROOM_SHARE = 0.95, 0.65
"""Shares of the frame time: a smaller size must take less than the first, a larger one than the second."""
MEASURE_SECONDS, RAISE_SECONDS, MAX_RAISE_SECONDS = 2.0, 2.0, 60.0
"""Time before the size is reduced; before it is raised; and maximum of the latter after failed attempts."""
MIN_FRAMES, MAX_FRAMES = 3, 30
"""Number of frames measured."""
MAX_USEFUL_SHARE = 0.9
"""A smaller size may take at most this share of the time of the larger one; else size is not the cause."""


class AdaptiveScale:
    """Chooses the working size by the time that frames take; time passes by the frames that are recorded.

    The rate needs no choice: where a frame takes longer than the time between two, frames are dropped.

    Attributes:
        scale: the share of the width and of the height to work at, of WORKING_SCALES.
        slow_rate: frames per second that were measured last, if they were too few; else 0.
    """

    def __init__(self, seconds: float, lines: int) -> None:
        """`seconds`: between two frames; `lines`: the shorter side of the picture."""
        self._seconds, self._level = max(seconds, 1 / MIN_SMOOTH_RATE), 0
        self._scales = [
            scale for scale in WORKING_SCALES if scale >= PREFERRED_MIN_SCALE or scale * lines >= MIN_LINES
        ]
        self.slow_rate = 0.0
        self._is_slow_known = False
        self._larger: tuple[int, float] | None = None
        self._lower_after, self._raise_after = MEASURE_SECONDS, RAISE_SECONDS
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
        if self._larger and typical > MAX_USEFUL_SHARE * self._larger[1]:
            self._lower_after = MAX_RAISE_SECONDS
            return self._set_level(self._larger[0])
        self._larger = None
        is_slow = not self._fits(typical, self._level, 1) and self._since_change >= self._lower_after
        if is_slow and self._level + 1 < len(self._scales):
            # A rise that did not last is attempted again later and later.
            failed = self._since_rise < 2 * MEASURE_SECONDS
            self._raise_after = min(2 * self._raise_after, MAX_RAISE_SECONDS) if failed else RAISE_SECONDS
            larger = self._level, typical
            self._set_level(self._fitting_level(typical), slow_rate=1 / typical)
            self._larger, self._lower_after = larger, MEASURE_SECONDS
            return True
        if self._level and self._since_change >= self._raise_after:
            if self._fits(typical, self._level - 1, HEADROOM_SHARE):
                self._since_rise = 0.0
                return self._set_level(self._level - 1)
        if self._level and not self._is_slow_known and typical > self._seconds:
            self.slow_rate, self._is_slow_known = 1 / typical, True
            return True
        return False

    def reset(self) -> None:
        """Discard the measurements: another style runs now."""
        self._times.clear()
        self._is_slow_known, self._since_change, self._larger = False, 0.0, None
        self._lower_after, self._raise_after = MEASURE_SECONDS, RAISE_SECONDS

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

    def _set_level(self, level: int, slow_rate: float = 0.0) -> bool:
        self._level, self.slow_rate, self._is_slow_known = level, slow_rate, False
        self._times.clear()
        self._since_change, self._larger = 0.0, None
        return True
