"""Options of the choice of key frames."""

from __future__ import annotations

from dataclasses import dataclass

from vidstyle.errors import UsageError

MAX_PANELS = 300
"""Maximum number of panels that can be requested."""


@dataclass(frozen=True)
class KeyFrameOptions:
    """How key frames are chosen.

    Attributes:
        panels: number of panels; None: a default that depends on the film.
        min_panels: minimum number if `panels` is None and the film has enough different pictures.
        spoken: start and end in seconds of speech by people who may be visible.
        at: times in seconds of frames that must be shown.
        skip: start and end in seconds of parts to exclude.
        words: times in seconds of words that need a panel nearby, if `panels` is None.
        seed: random seed of a choice that is nearly as good as the best one, which 0 gives.
    """

    panels: int | None = None
    at: tuple[float, ...] = ()
    skip: tuple[tuple[float, float], ...] = ()
    min_panels: int = 0
    spoken: tuple[tuple[float, float], ...] = ()
    words: tuple[float, ...] = ()
    seed: int = 0

    def check(self) -> None:
        """Raise UsageError if they contradict each other; needs no film."""
        if self.panels is not None and not 1 <= self.panels <= MAX_PANELS:
            raise UsageError("--panels", f"{self.panels} is outside 1 to {MAX_PANELS}")
        for first, last in self.skip:
            if not 0 <= first < last:
                raise UsageError("--skip", f"{first:g}-{last:g} s is not a valid range")
        for time in self.at:
            if time < 0:
                raise UsageError("--at", f"{time:g} s is before the start of the film")
            if self.skips(time):
                raise UsageError("--at", f"{time:g} s is in a part that --skip excludes")

    def skips(self, time: float) -> bool:
        """Whether a time is in a skipped part."""
        return any(first <= time < last for first, last in self.skip)
