"""Writes pictures: one file, or one file per frame by a pattern such as `%05d.png`."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import av

from vidstyle.errors import UsageError, log
from vidstyle.media.frame import Frame
from vidstyle.media.read.sequence import find_sequence_files, has_wildcard, is_pattern
from vidstyle.media.write.atomic import OutputFile
from vidstyle.media.write.base import Writer, write_error
from vidstyle.media.write.encoder import to_encoder_frame
from vidstyle.media.write.run_record import RunRecord, earlier_run_error, is_written

NUMBER_PATTERN = re.compile(r"%(0?\d*)d")
"""Placeholder of the number in a pattern."""


class PictureWriter(Writer):
    """Writes each frame to a separate file, atomically.

    Raises:
        UsageError: there is more than one frame, and the name is not a pattern.
    """

    _left = 0
    """Number of pictures from an earlier run."""

    def _open(self) -> None:
        self._pattern = is_numbered(str(self.target))
        if self._expected_frames > 1 and not self._pattern:
            raise self._too_many()
        path = self._source_path
        if self._pattern and path and self._is_among(Path(path)):
            raise UsageError(
                self.name, "is the input itself, and would be overwritten", "choose another name"
            )
        self._written: Path | None = None
        self._file: OutputFile | None = None
        self._record = RunRecord(self.target) if self._pattern else None
        try:
            if self._record is not None:
                self._continue(self._record)
            self._file = self._next_file()
        except BaseException:
            self._close(keep=self._left > 0)
            raise
        self.partial = self._file.path

    def _too_many(self) -> UsageError:
        pattern = f"{self.target.stem}_%05d{self.target.suffix}"
        return UsageError(self.target, "can hold only one picture", f"add --frames 1, or name it {pattern}")

    def _is_among(self, source: Path) -> bool:
        """Whether the output would overwrite pictures of the source."""
        if not has_wildcard(source.name):
            return source.absolute() == self.target.absolute()
        files = find_sequence_files(str(source.absolute())) if is_pattern(source) else []
        targets = (numbered_path(str(self.target.absolute()), number + 1) for number in range(len(files)))
        return not set(files).isdisjoint(targets)

    def _continue(self, record: RunRecord) -> None:
        """Find the pictures of an earlier run, and continue it, keep it or start again."""
        self._left = self._count_written(record)
        if self._left and self._fingerprint and self._fingerprint.resume:
            self._fingerprint.check(record, self.target)
            # The last one is written again: after a power failure its content may be missing.
            self.kept = self._left - 1
            log.info("%s is resumed: %d of %d pictures are kept", self.target, self.kept, self._left)
        elif self._left and not self._options.overwrite:
            raise earlier_run_error(self.target, f"the first {self._left} pictures", record)
        else:
            self._left = 0
            record.begin(self._fingerprint.parts if self._fingerprint else {})

    def _count_written(self, record: RunRecord) -> int:
        """Count the consecutive pictures from the first one that an earlier run has written."""
        written = record.written()
        for number in itertools.count():
            if not is_written(numbered_path(str(self.target), number + 1), written):
                return number
        raise AssertionError

    def write(self, item: Frame | av.Packet) -> None:
        """See Writer; packets of other streams are ignored."""
        if not isinstance(item, Frame):
            return
        if self.frames < self.kept:
            self.frames += 1
            return
        if self.frames and not self._pattern:
            raise self._too_many()
        if self._file is None:
            self._file = self._next_file()
            self.partial = self._file.path
        try:
            self._file.path.write_bytes(self._encoded(item))
            self._file.check()
            if self._pattern:
                self._finish_file(self._file)
        except (av.FFmpegError, OSError) as error:
            kept = f"{self.frames} pictures are written" if self.frames else "nothing is kept"
            raise write_error(self.target, error, kept) from error
        self.frames += 1

    def _finish_file(self, file: OutputFile) -> None:
        if self._record is not None:
            self._record.add_written(file.path, file.target.name)
        file.finish()
        self._written, self._file, self.partial = file.target, None, None

    def finish(self) -> None:
        """See Writer."""
        if self._file is not None and self.frames and not self._pattern:
            self._finish_file(self._file)
        self._close(keep=False)

    def abandon(self) -> Path | None:
        """See Writer; return the last complete picture."""
        self._close(keep=self._fingerprint is not None and self._left + self.frames > 0)
        return self._written

    def _close(self, keep: bool) -> None:
        if self._file is not None:
            self._file.remove()
            self._file = self.partial = None
        if self._record is not None:
            self._record.release() if keep else self._record.remove()

    def _next_file(self) -> OutputFile:
        """Open the file of the next frame; the first has the number 1."""
        number = max(self.frames, self.kept) + 1
        path = numbered_path(str(self.target), number) if self._pattern else self.target
        overwrite = self._options.overwrite or number <= self._left
        return OutputFile(path, self._source_path, overwrite, self._record)

    def _encoded(self, frame: Frame) -> bytes:
        context = av.CodecContext.create(self._plan.encoder, "w")
        assert isinstance(context, av.VideoCodecContext)
        self._plan.configure(context)
        context.thread_count = 1  # each additional thread would delay a picture
        packets = context.encode(to_encoder_frame(frame, self._plan)) + context.encode(None)
        return b"".join(bytes(packet) for packet in packets)


def is_numbered(target: str) -> bool:
    """Whether the target has a placeholder for a number.

    >>> is_numbered("out/%05d.png"), is_numbered("100%.png")
    (True, False)
    """
    return NUMBER_PATTERN.search(Path(target).name) is not None


def numbered_path(pattern: str, number: int) -> Path:
    """Return the path with the number inserted.

    >>> numbered_path("frame_%03d.png", 7).name
    'frame_007.png'
    """
    path = Path(pattern)
    return path.with_name(NUMBER_PATTERN.sub(lambda match: f"{number:{match[1]}d}", path.name, count=1))
