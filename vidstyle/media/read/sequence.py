"""Image sequences and animated WebP as sources."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from pathlib import Path

import av
import numpy as np

from vidstyle.core.opencv_log import silent_opencv
from vidstyle.core.picture import Picture
from vidstyle.errors import InputError, log
from vidstyle.media.exif import exif_orientation
from vidstyle.media.frame import DecodedFrame, frame_from_picture
from vidstyle.media.orientation import Orientation, orientation_of_stream
from vidstyle.media.read.clock import FrameClock, fine_time_base
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.decoder import Decoder
from vidstyle.media.read.file_structure.headers import picture_size
from vidstyle.media.read.open import check_size, open_media
from vidstyle.media.read.source import choose_stream, may_be_still

NUMBER_PATTERN = re.compile(r"%(0\d+)?d")
MAX_ANIMATION_PICTURES = 4
"""Maximum size of an animated WebP, which is decoded as a whole, as a multiple of the largest picture."""


def is_pattern(source: str | os.PathLike[str]) -> bool:
    """Whether the name is a pattern of files: it has one %d or %05d, or * or ?, and no file has this name.

    >>> is_pattern("frames/%05d.png"), is_pattern("frames/*.png"), is_pattern("frames/00001.png")
    (True, True, False)
    """
    name = Path(source).name
    return (len(NUMBER_PATTERN.findall(name)) == 1 or has_wildcard(name)) and not os.path.lexists(source)


def has_wildcard(name: str) -> bool:
    """Whether a name has the wildcards * or ?."""
    return not {"*", "?"}.isdisjoint(name)


def is_animated_webp(path: Path) -> bool:
    """Whether the file is a WebP with the animation flag, which FFmpeg does not decode."""
    try:
        with path.open("rb") as file:
            head = file.read(21)
    except (OSError, ValueError):
        return False
    return head[:4] == b"RIFF" and head[8:16] == b"WEBPVP8X" and any(byte & 2 for byte in head[20:])


class SequenceSource:
    """Frames in memory or in one file per frame; see `VideoSource`."""

    container: av.container.InputContainer | None = None
    may_be_still = False

    def __init__(
        self,
        name: str,
        codec: str,
        time_base: Fraction,
        stamps: Sequence[int],
        load: Callable[[int, DecodeReport], av.VideoFrame | None],
        orientation: Orientation | None = None,
    ) -> None:
        """`stamps` are the start times of the frames, and the end of the last one."""
        self.name, self.codec, self.orientation = name, codec, orientation
        self.time_base = time_base
        self.frames: int | None = len(stamps) - 1
        self.duration: Fraction | None = stamps[-1] * time_base
        self.rate: Fraction | None = self.frames / self.duration
        self.sample_aspect: Fraction | None = None
        self.copied_streams: list[av.stream.Stream] = []
        self.damage = DecodeReport()
        self._stamps = stamps
        self._load = load
        self._first = 0

    @classmethod
    def from_pattern(cls, pattern: str, rate: Fraction, max_pixels: int) -> SequenceSource:
        """Open the files that match a pattern such as "%05d.png" or "*.png", at a constant rate.

        Raises:
            InputError: no file matches, or the first is not a picture.
        """
        paths = find_sequence_files(pattern)
        time_base = fine_time_base(1 / rate)
        ticks = round(1 / rate / time_base)
        _, codec, orientation = _load_picture(paths[0], max_pixels, DecodeReport())

        def load(number: int, damage: DecodeReport) -> av.VideoFrame | None:
            return _load_picture(paths[number], max_pixels, damage)[0]

        stamps = [number * ticks for number in range(len(paths) + 1)]
        return cls(pattern, codec, time_base, stamps, load, orientation)

    @classmethod
    def from_webp(cls, path: Path, max_pixels: int) -> SequenceSource:
        """Open an animated WebP.

        Raises:
            InputError: it is too large or not readable.
        """
        import cv2

        content = path.read_bytes()
        _check_webp(path, content, max_pixels)
        with silent_opencv():
            # One row: OpenCV 4 does not accept a column.
            ok, animation = cv2.imdecodeanimation(np.frombuffer(content, np.uint8)[np.newaxis])
        if not ok or not animation.frames:
            raise InputError(path, "not a readable video")
        stamps = np.concatenate([[0], np.cumsum(np.maximum(animation.durations, 1))]).tolist()
        pictures = animation.frames

        def load(number: int, damage: DecodeReport) -> av.VideoFrame | None:
            import cv2

            damage.decoded += 1
            order = cv2.COLOR_BGRA2RGBA if pictures[number].shape[2] == 4 else cv2.COLOR_BGR2RGB
            return frame_from_picture(Picture.from_array(cv2.cvtColor(pictures[number], order)))

        return cls(str(path), "webp", Fraction(1, 1000), stamps, load)

    def seek(self, time: Fraction) -> None:
        """Continue at the frame that is shown at a time in seconds."""
        wanted = time / self.time_base
        self._first = max((number for number, stamp in enumerate(self._stamps) if stamp <= wanted), default=0)

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Yield the frames from here on; unreadable ones are replaced by the last good one."""
        last: av.VideoFrame | None = None
        for number in range(self._first, len(self._stamps) - 1):
            frame = self._load(number, self.damage)
            stamp, duration = self._stamps[number], self._stamps[number + 1] - self._stamps[number]
            if frame is not None:
                yield DecodedFrame(frame, stamp, duration, key=True)
            elif last is not None:
                self.damage.repeated += 1
                yield DecodedFrame(last, stamp, duration, repeated=True)
            else:
                self.damage.lost += 1
            last = frame or last

    def close(self) -> None:
        """Do nothing: no file stays open between frames."""


def find_sequence_files(pattern: str) -> list[Path]:
    """Return the files that match a pattern, by number; for a pattern with * or ?, in natural order.

    Raises:
        InputError: no file matches.
    """
    folder, name = Path(pattern).parent, Path(pattern).name
    wanted = _wild_name(name) if has_wildcard(name) else _numbered_name(name)
    matches = [
        match
        for path in (folder.iterdir() if folder.is_dir() else ())
        if (match := wanted.fullmatch(path.name)) and path.is_file()  # a pipe may never end
    ]
    if not matches:
        raise InputError(pattern, "no such files")
    if has_wildcard(name):
        return [folder / each for each in sorted((match.string for match in matches), key=natural_sort_key)]
    numbers = {int(match[1]): folder / match.string for match in matches}
    gaps = max(numbers) - min(numbers) + 1 - len(numbers)
    if gaps:
        log.warning("%s: %d numbers are missing and skipped", pattern, gaps)
    return [numbers[number] for number in sorted(numbers)]


def _numbered_name(name: str) -> re.Pattern[str]:
    found = NUMBER_PATTERN.search(name)
    assert found is not None
    digits = rf"\d{{{int(found[1])},}}" if found[1] else r"\d+"
    return re.compile(re.escape(name[: found.start()]) + f"({digits})" + re.escape(name[found.end() :]))


def _wild_name(name: str) -> re.Pattern[str]:
    """Compile a pattern with wildcards; as in a shell, they do not match a dot at the start of a name."""
    parts = {"*": ".*", "?": "."}
    hidden = r"(?!\.)" if name[0] in parts else ""
    return re.compile(hidden + "".join(parts.get(each, re.escape(each)) for each in name), re.DOTALL)


def natural_sort_key(name: str) -> list[tuple[int, str]]:
    """Return a key for sorting names, so that picture 10 comes after picture 9.

    >>> sorted(["10.png", "9.png"], key=natural_sort_key)
    ['9.png', '10.png']
    """
    return [
        (int(part), "") if part.isdecimal() else (-1, part.lower()) for part in re.split("([0-9]+)", name)
    ]


def _load_picture(
    path: Path, max_pixels: int, damage: DecodeReport
) -> tuple[av.VideoFrame | None, str, Orientation | None]:
    """Return the picture in a file, or None if it is damaged, with its codec and orientation."""
    try:
        container = open_media(path, max_pixels=max_pixels)
        if not may_be_still(container):
            container.close()
            raise InputError(path, "is not a picture", "a name with %05d or * must match pictures")
    except InputError as error:
        if damage.decoded:
            log.debug("%s", error)
            return None, "", None
        raise
    with container:
        clock = FrameClock(Fraction(1, 25), Fraction(25))
        stream = choose_stream(container, str(path))
        decoder = Decoder(stream, clock, DecodeReport(), max_pixels)
        orientation = orientation_of_stream(stream)
        for packet in container.demux(stream):
            orientation = orientation or exif_orientation(memoryview(packet))
            for decoded in decoder.decode(packet if packet.size else None):
                damage.decoded += 1
                return decoded.native, decoder.codec, orientation
    return None, "", None


def _check_webp(path: Path, content: bytes, max_pixels: int) -> None:
    """Raise InputError if an animated WebP is too large, before it is decoded."""
    width, height = picture_size(content) or (0, 0)
    check_size(path, (width, height), max_pixels)
    frames = content.count(b"ANMF")
    if width * height * frames > MAX_ANIMATION_PICTURES * max_pixels:
        raise InputError(path, f"{frames} frames of {width}x{height} do not fit in memory")
