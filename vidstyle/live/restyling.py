"""Captured frames restyled as is wished, at a working size that holds the rate."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TYPE_CHECKING

from vidstyle.live.budget import Budget
from vidstyle.live.capture import Capture
from vidstyle.live.control import Controls
from vidstyle.live.pictures import Pictures
from vidstyle.live.setting import LiveOptions
from vidstyle.live.styler import Styler
from vidstyle.media.capture.input import Captured

if TYPE_CHECKING:
    import av


class Restyling:
    """What lies between a captured frame and a restyled one."""

    def __init__(self, controls: Controls, options: LiveOptions, tell: Callable[[str], None]) -> None:
        """`tell`: is told when the style or the working size changes, and why a style does not run."""
        self._controls, self._tell = controls, tell
        self._keeps_rate = options.budget
        self._styler = Styler(controls.style, options.device, tell)
        self._pictures = Pictures(options.size)
        self._budget: Budget | None = None
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

    def frame(self, captured: Captured, capture: Capture, name: str) -> av.VideoFrame:
        """The frame restyled; `name` is that of the source."""
        picture = self._pictures.picture(captured, capture, name)
        style = None if self._controls.bypassed else self._controls.style
        before = self.style
        result, changed = self._styler.run(picture, captured.time, self._pictures.encoding, style)
        if self.style != before:  # not for every step of a slider
            self._tell(f"style {self.style}")
        if changed and self._budget is not None:
            self._budget.restart()
        return self._pictures.frame(result)

    def hold(self, rate: Fraction) -> None:
        """From now on frames have to be done at this rate, if the options say so."""
        self._rate = rate
        self._budget = Budget(float(1 / rate)) if self._keeps_rate else None

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
