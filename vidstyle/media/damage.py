"""What was wrong with an input, counted."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

CONCEALED_SHARE = 0.01
"""Up to this share of frames that a decoder has patched by itself nobody need hear of."""
TAIL = Fraction(1, 2)
"""Seconds by which a file may end before its header says so; headers round, and count the sound."""


@dataclass
class Damage:
    """Counts of a reading that is still under way or over.

    Attributes:
        decoded: frames delivered from packets of their own.
        held: frames that could not be decoded, in whose place the last good one was shown again.
        lost: frames that could not be decoded and left nothing.
        concealed: frames that the decoder delivered, but flagged as patched.
        missing_frames: frames that the header announces and the file does not hold.
        missing_seconds: how much earlier than its header says the file ends, where frames are not counted.
        header_seconds: what the header says.
        broken_reads: places where the container itself could not be read.
    """

    decoded: int = 0
    held: int = 0
    lost: int = 0
    concealed: int = 0
    missing_frames: int = 0
    missing_seconds: Fraction = Fraction(0)
    header_seconds: Fraction = Fraction(0)
    broken_reads: int = 0

    @property
    def is_notable(self) -> bool:
        """Whether a program should end with another code than success."""
        undone = self.held + self.lost + self.missing_frames
        return bool(undone or self.missing_seconds) or self.concealed > CONCEALED_SHARE * self.decoded

    def report(self) -> str:
        """One line for people, or "" when nothing was found.

        >>> Damage(decoded=72, missing_frames=78).report()
        'the input is damaged: 78 frames missing of 150'
        """
        total = self.decoded + self.held + self.lost + self.missing_frames
        found = [
            (self.missing_frames, f"{_frames(self.missing_frames)} missing of {total}"),
            (self.held, f"{_frames(self.held)} damaged, the last good one held"),
            (self.lost, f"{_frames(self.lost)} damaged and left out"),
            (self.concealed, f"{_frames(self.concealed)} patched by the decoder"),
            (self.missing_seconds, self._seconds_text()),
        ]
        words = [text for count, text in found if count]
        return "the input is damaged: " + ", ".join(words) if words else ""

    def _seconds_text(self) -> str:
        missing, announced = float(self.missing_seconds), float(self.header_seconds)
        return f"it ends {missing:.1f} s before the {announced:.1f} s that its header says"


def _frames(count: int) -> str:
    return f"{count} frame" + "s" * (count != 1)
