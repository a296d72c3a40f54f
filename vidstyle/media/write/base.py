"""The interface and the common code of writers."""

from __future__ import annotations

import os
import sys
from abc import ABC, abstractmethod
from pathlib import Path

import av

from vidstyle.errors import OutputError, is_memory_short, is_out_of_memory, output_error
from vidstyle.media.audio import AudioChunk
from vidstyle.media.frame import Frame
from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.containers import ContainerKind
from vidstyle.media.write.run_record import Fingerprint
from vidstyle.media.write.video_plan import plan_video


class Writer(ABC):
    """Writes one output. End with `finish` or `abandon`; a `with` statement calls the right one.

    Attributes:
        encoding: the expected encoding of pictures.
        wants_rgb: whether it expects RGB pictures instead of luma and chroma.
        target: the output.
        name: the name of the output for messages.
        partial: the temporary file, if there is one.
        frames: number of accepted frames.
        kept: number of leading frames from an earlier run; their pictures are ignored.
    """

    partial: Path | None = None
    frames: int = 0
    kept: int = 0

    def __init__(
        self,
        target: str | Path,
        kind: ContainerKind,
        info: VideoInfo,
        options: WriteOptions,
        source: Reader | None,
        fingerprint: Fingerprint | None,
    ) -> None:
        """See `open_writer`."""
        self.target = Path(target)
        self.name = "standard output" if str(target) == "-" else str(target)
        self._kind, self._options, self._source, self._fingerprint = kind, options, source, fingerprint
        self._expected_frames = info.frames or 0
        self._source_path = source.name if source else None
        self._plan = plan_video(self.name, kind, info, options)
        self.encoding, self.wants_rgb = self._plan.encoding, self._plan.rgb
        self._open()

    @property
    def loss(self) -> str:
        """Description of the damage of the source's other streams, or empty."""
        return ""

    @abstractmethod
    def _open(self) -> None:
        """Create the file, and check everything possible before the first frame is decoded."""

    @abstractmethod
    def write(self, item: Frame | av.Packet) -> None:
        """Write the next frame, or a packet of another stream of the source, in the source's order.

        Raises:
            OutputError: writing failed; the message names the partial file, which is kept.
        """

    def push_audio(self, chunk: AudioChunk, seconds: float) -> None:  # noqa: B027  pictures have none
        """Write audio that starts `seconds` after the first frame; ignored unless `new_sound` is set.

        Raises:
            OutputError: see `write`.
        """

    @abstractmethod
    def finish(self) -> None:
        """Flush the encoders, close the file and rename it to its target.

        Raises:
            OutputError: writing failed.
        """

    @abstractmethod
    def abandon(self) -> Path | None:
        """Close the file quickly, so that it plays.

        Never raises for a full disk or a lost pipe; may be called twice.

        Returns:
            The path of the partial file, or None if no frame was written; then no file is left.
        """

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()
        else:
            self.abandon()


def write_error(name: object, error: Exception, kept: str) -> OutputError:
    """Return the error for failed writing; `kept` describes the files left on the disk."""
    if isinstance(error, OutputError):
        return OutputError(error.subject, error.reason, kept)
    if is_out_of_memory(error) or (isinstance(error, av.FFmpegError) and is_memory_short()):
        return OutputError(name, "cannot be written: not enough memory", kept)
    if isinstance(error, OSError):
        return output_error(name, error, kept)
    return OutputError(name, f"cannot be written: {error}", kept)


class StandardOutput:
    """Standard output without Python's buffer.

    After the reader has closed it, a buffer would fail again at exit, and a thread that waits in a buffered
    write could not be abandoned.
    """

    name = "standard output"

    def __init__(self) -> None:
        self._descriptor = sys.stdout.fileno()

    def write(self, content: bytes) -> int:
        """Write all of the content; wait for the reader."""
        rest = memoryview(content)
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]
        return len(content)
