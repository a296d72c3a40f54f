"""The writers' common interface, and the writer that fits a target."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import av

from vidstyle.core.picture import Encoding
from vidstyle.media.frame import Frame
from vidstyle.media.write.containers import kind_of

if TYPE_CHECKING:
    from vidstyle.media.read.reader import Reader, VideoInfo


@dataclass(frozen=True)
class WriteOptions:
    """How to write.

    Attributes:
        codec: a video encoder or codec by FFmpeg's name, or None for what fits the kind of file.
        crf: the quality, on the encoder's own scale; lower is better.
        preset: the encoder's speed preset.
        pix_fmt: the pixel format, or None for one that plays everywhere.
        audio: "copy" (transcoded only where the container requires it), "none", or an encoder's name.
        new_sound: whether audio is pushed as samples, as that of live sources.
        overwrite: whether the output may exist.
        format: the kind of file if its name does not say: "y4m", "nut", "raw", "mkv", or FFmpeg's name.
    """

    codec: str | None = None
    crf: float | None = None
    preset: str | None = None
    pix_fmt: str | None = None
    audio: str = "copy"
    overwrite: bool = False
    format: str | None = None
    new_sound: bool = False


class Writer(ABC):
    """Writes one output. Ends with `finish` or `abandon`; as a context manager, with whichever is right.

    Attributes:
        encoding: what pictures are to be delivered in.
        wants_rgb: whether it wants RGB pictures rather than luma and chroma.
        target: the file wanted.
        partial: the file that is being written meanwhile, if it is another.
        frames: how many frames have been taken.
    """

    encoding: Encoding
    wants_rgb: bool = False
    target: Path
    partial: Path | None = None
    frames: int = 0

    @abstractmethod
    def write(self, item: Frame | av.Packet) -> None:
        """Take the next frame, or a packet of another stream of the source, in the source's order.

        Raises:
            OutputError: it cannot be written; what was written so far is kept, and named.
        """

    @abstractmethod
    def finish(self) -> None:
        """Flush the encoders, close the file and rename it to its target.

        Raises:
            OutputError: it cannot be written.
        """

    @abstractmethod
    def abandon(self) -> Path | None:
        """Close the file soon, so that what was written plays.

        Returns:
            Where it is, or None if there was nothing worth keeping; then nothing is left. Never raises for a
            full disk or a lost pipe; may be called twice.
        """

    def __enter__(self) -> Writer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self.finish()
        else:
            self.abandon()


def open_writer(
    target: str | Path, info: VideoInfo, options: WriteOptions, source: Reader | None = None
) -> Writer:
    """A writer for the target, with everything checked that can be checked before a frame is decoded.

    Args:
        target: a path whose ending says what to write; `%05d.png` for one file for each picture; "-" for
            standard output, which wants `options.format`.
        info: of the pictures that will come.
        options: how to write.
        source: where they come from; its other streams, chapters and tags are carried over.

    Raises:
        UsageError: the target exists, is the input, or cannot hold what is asked for.
        OutputError: its folder is missing or cannot be written to.
    """
    # They import the class that they extend from here.
    from vidstyle.media.write.film import FilmWriter
    from vidstyle.media.write.gif import GifWriter
    from vidstyle.media.write.images import PictureWriter, is_pattern

    pattern = is_pattern(str(target))
    kind = kind_of(str(target), options.format, info.still or pattern)
    source_path = source.name if source else None
    if kind.way == "picture":
        return PictureWriter(target, kind, info, options, source_path)
    writer = GifWriter if kind.way == "gif" else FilmWriter
    return writer(target, kind, info, options, source, source_path)
