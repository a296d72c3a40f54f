"""The damage that was found in a source."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

MAX_CONCEALED_SHARE = 0.01
"""Maximum share of frames with concealed errors that is not reported."""
DURATION_TOLERANCE_SECONDS = Fraction(1, 2)
"""Seconds by which a file may be shorter than its header states; headers round, and include the sound."""


@dataclass
class DecodeReport:
    """Counts of damage, while a source is read or after that.

    Attributes:
        decoded: decoded frames.
        repeated: frames that could not be decoded and were replaced by the last good one.
        lost: frames that could not be decoded and were dropped.
        concealed: frames that the decoder flagged as corrupt, with concealed errors.
        missing_frames: frames that are missing according to the header, or by the length of a gap.
        missing_seconds: missing duration according to the header, if it does not count frames.
        header_seconds: duration according to the header.
        clock_jumps: implausible jumps of the clock, which were bridged.
        broken_streams: video streams without a decodable frame, which were replaced by another stream.
        unmatched_packets: packets of streams that start in mid-file and continue no other stream.
        late_streams: streams that start in mid-file and cannot be read.
        is_followed: whether another film follows in the file, which is not read.
        has_bad_index: whether the index lists more frames than fit in the file.
        cut_off: whether the file is truncated.
    """

    decoded: int = 0
    repeated: int = 0
    lost: int = 0
    concealed: int = 0
    missing_frames: int = 0
    missing_seconds: Fraction = Fraction(0)
    header_seconds: Fraction = Fraction(0)
    clock_jumps: int = 0
    broken_streams: int = 0
    unmatched_packets: int = 0
    late_streams: int = 0
    is_followed: bool = False
    has_bad_index: bool = False
    cut_off: bool = False

    @property
    def is_significant(self) -> bool:
        """Whether a program should end with the exit code for damage."""
        undone = self.repeated + self.lost + self.missing_frames
        lost = undone or self.missing_seconds or self.unmatched_packets or self.late_streams or self.cut_off
        lost = lost or self.clock_jumps or self.broken_streams or self.is_followed or self.has_bad_index
        return bool(lost) or self.concealed > MAX_CONCEALED_SHARE * self.decoded

    def clear(self) -> None:
        """Reset all counts except `broken_streams`, before the source is read again."""
        self.__init__(broken_streams=self.broken_streams)  # type: ignore[misc]

    def report(self) -> str:
        """Return one line for users, or "" if there is no damage.

        >>> DecodeReport(decoded=72, missing_frames=78).report()
        'the input is damaged: 78 frames missing of 150'
        """
        total = self.decoded + self.repeated + self.lost + self.missing_frames
        missing, said = float(self.missing_seconds), float(self.header_seconds)
        found = [
            (self.missing_frames, f"{_frames(self.missing_frames)} missing of {total}"),
            (self.repeated, f"{_frames(self.repeated)} damaged and replaced by the last good one"),
            (self.lost, f"{_frames(self.lost)} could not be decoded"),
            (self.concealed, f"{_frames(self.concealed)} with errors concealed by the decoder"),
            (self.missing_seconds, f"it ends {missing:.1f} s before the {said:.1f} s in its header"),
            (self.clock_jumps, f"its clock jumps {describe_count(self.clock_jumps)} (bridged)"),
            (self.broken_streams, f"no frame of {_tracks(self.broken_streams)} could be decoded"),
            (self.unmatched_packets, f"{_packets(self.unmatched_packets)} without a matching stream"),
            (self.late_streams, f"unreadable streams that start in mid-file: {self.late_streams}"),
            (self.is_followed, "another film follows in the file, which is not read"),
            (self.has_bad_index, "its index is invalid"),
            (self.cut_off and not (self.missing_frames or missing), "the file is cut off"),
        ]
        words = [text for count, text in found if count]
        return "the input is damaged: " + ", ".join(words) if words else ""


def _frames(count: int) -> str:
    return f"{count} frame" + "s" * (count != 1)


def _packets(count: int) -> str:
    return f"{count} packet" + "s" * (count != 1)


def describe_count(count: int) -> str:
    """Return "once" or "N times"."""
    return "once" if count == 1 else f"{count} times"


def _tracks(count: int) -> str:
    return "its longest video track" if count == 1 else f"its {count} longest video tracks"
