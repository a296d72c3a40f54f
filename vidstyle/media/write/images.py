"""Writes pictures: one file, or one for each frame by a pattern such as `%05d.png`."""

from __future__ import annotations

import re
from pathlib import Path

import av

from vidstyle.errors import UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.write.atomic import PartialFile, partial_name
from vidstyle.media.write.base import Writer, write_error
from vidstyle.media.write.encoder import encoder_frame
from vidstyle.media.write.file_lock import lock_file

NUMBER = re.compile(r"%(0?\d*)d")
"""Where the number goes in a pattern."""


class PictureWriter(Writer):
    """Writes each frame to a file of its own, atomically.

    Raises:
        UsageError: at the second frame, if the name is no pattern.
    """

    def _open(self) -> None:
        self._pattern = is_pattern(str(self.target))
        path = self._source_path
        if self._pattern and path and Path(path).absolute() == self.target.absolute():
            raise UsageError(
                self.name, "is the input itself, and would be overwritten", "choose another name"
            )
        self._written: Path | None = None
        self._lock_path = self.target.with_name(partial_name(self.target.name, ".lock"))
        # Each picture is locked by itself; two runs would still write every other one.
        self._lock = lock_file(self._lock_path, self.target) if self._pattern else None
        self._file: PartialFile | None = None
        try:
            self._file = self._next_file()
        finally:
            if self._file is None:
                self._unlock()
        self.partial = self._file.path

    def write(self, item: Frame | av.Packet) -> None:
        """See Writer; packets of other streams are ignored."""
        if not isinstance(item, Frame):
            return
        if self._file is None:
            if not self._pattern:
                pattern = f"{self.target.stem}_%05d{self.target.suffix}"
                raise UsageError(self.target, "holds one picture, and there are more", f"name it {pattern}")
            self._file = self._next_file()
            self.partial = self._file.path
        try:
            self._file.path.write_bytes(self._encoded(item))
            self._file.check()
            self._file.finish()
        except (av.FFmpegError, OSError) as error:
            kept = f"{self.frames} pictures are written" if self.frames else "nothing is kept"
            raise write_error(self.target, error, kept) from error
        self._written, self._file, self.partial = self._file.target, None, None
        self.frames += 1

    def finish(self) -> None:
        """See Writer."""
        if self._file is not None:
            self._file.remove()
            self._file = self.partial = None
        self._unlock()

    def abandon(self) -> Path | None:
        """See Writer; returns the last complete picture."""
        self.finish()
        return self._written

    def _unlock(self) -> None:
        if self._lock is not None:
            self._lock_path.unlink(missing_ok=True)
            self._lock.release()
            self._lock = None

    def _next_file(self) -> PartialFile:
        """The file of the next frame; the first has the number 1."""
        path = numbered_path(str(self.target), self.frames + 1) if self._pattern else self.target
        return PartialFile(path, self._source_path, self._options.overwrite)

    def _encoded(self, frame: Frame) -> bytes:
        context = av.CodecContext.create(self._plan.encoder, "w")
        assert isinstance(context, av.VideoCodecContext)
        self._plan.configure(context)
        context.thread_count = 1  # each further thread would delay a picture
        packets = context.encode(encoder_frame(frame, self._plan)) + context.encode(None)
        return b"".join(bytes(packet) for packet in packets)


def is_pattern(target: str) -> bool:
    """Whether the target has a place for a number.

    >>> is_pattern("out/%05d.png"), is_pattern("100%.png")
    (True, False)
    """
    return NUMBER.search(Path(target).name) is not None


def numbered_path(pattern: str, number: int) -> Path:
    """The path with the number in its place.

    >>> numbered_path("frame_%03d.png", 7).name
    'frame_007.png'
    """
    path = Path(pattern)
    return path.with_name(NUMBER.sub(lambda match: f"{number:{match[1]}d}", path.name, count=1))
