"""What was found wrong in a source."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

CONCEALED_SHARE = 0.01
"""Up to this share of frames that a decoder has patched by itself nobody need hear of."""
DURATION_TOLERANCE = Fraction(1, 2)
"""Seconds by which a file may end before its header says so; headers round, and count the sound."""


@dataclass
class DecodeReport:
    """Counts of a reading that is still under way or over.

    Attributes:
        decoded: frames delivered from packets of their own.
        repeated: frames that could not be decoded and were replaced by the last good one.
        lost: frames that could not be decoded and left nothing.
        concealed: frames that the decoder delivered, but flagged as patched.
        missing_frames: frames that the header announces, or a gap has time for, and the file does not hold.
        missing_seconds: how much earlier than its header says the file ends, where frames are not counted.
        header_seconds: what the header says.
        leaps: how often its clock leaps where a film cannot, which was bridged.
        broken_streams: video streams of which no frame could be decoded, and another was taken.
        unmatched_packets: packets of sound and other streams in a later part that continue no stream.
        has_bad_index: whether the index announces more frames than fit in the file.
        cut_off: whether the file ends before its structure does.
    """

    decoded: int = 0
    repeated: int = 0
    lost: int = 0
    concealed: int = 0
    missing_frames: int = 0
    missing_seconds: Fraction = Fraction(0)
    header_seconds: Fraction = Fraction(0)
    leaps: int = 0
    broken_streams: int = 0
    unmatched_packets: int = 0
    has_bad_index: bool = False
    cut_off: bool = False

    @property
    def is_significant(self) -> bool:
        """Whether a program should end with another code than success."""
        undone = self.repeated + self.lost + self.missing_frames
        lost = undone or self.missing_seconds or self.unmatched_packets or self.cut_off
        return bool(lost or self.leaps or self.broken_streams or self.has_bad_index) or (
            self.concealed > CONCEALED_SHARE * self.decoded
        )

    def clear(self) -> None:
        """Begin anew, for another reading of the same source."""
        self.__init__()  # type: ignore[misc]

    def report(self) -> str:
        """One line for people, or "" when nothing was found.

        >>> DecodeReport(decoded=72, missing_frames=78).report()
        'the input is damaged: 78 frames missing of 150'
        """
        total = self.decoded + self.repeated + self.lost + self.missing_frames
        missing, said = float(self.missing_seconds), float(self.header_seconds)
        found = [
            (self.missing_frames, f"{_frames(self.missing_frames)} missing of {total}"),
            (self.repeated, f"{_frames(self.repeated)} damaged, the last good one held"),
            (self.lost, f"{_frames(self.lost)} left out that could not be decoded"),
            (self.concealed, f"{_frames(self.concealed)} patched by the decoder"),
            (self.missing_seconds, f"it ends {missing:.1f} s before the {said:.1f} s that its header says"),
            (self.leaps, f"its clock leaps {_times(self.leaps)}, bridged"),
            (self.broken_streams, f"no frame of {_tracks(self.broken_streams)} could be decoded"),
            (self.unmatched_packets, f"{self.unmatched_packets} packets left out that continue no stream"),
            (self.has_bad_index, "its index cannot be right"),
            (self.cut_off and not (self.missing_frames or missing), "the file is cut off"),
        ]
        words = [text for count, text in found if count]
        return "the input is damaged: " + ", ".join(words) if words else ""


def _frames(count: int) -> str:
    return f"{count} frame" + "s" * (count != 1)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"


def _tracks(count: int) -> str:
    return "its longest video track" if count == 1 else f"its {count} longest video tracks"
