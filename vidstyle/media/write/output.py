"""What every writer is: it takes frames and packets in, and leaves a file that plays."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import av

from vidstyle.core.picture import Encoding

if TYPE_CHECKING:
    from vidstyle.media.frame import Frame


@dataclass(frozen=True)
class WriteOptions:
    """How to write.

    Attributes:
        codec: a video encoder or codec by FFmpeg's name, or None for what fits the kind of file.
        crf: the quality, on the encoder's own scale; lower is better.
        preset: the speed, by the encoder's own name.
        pix_fmt: the pixel format, or None for one that plays everywhere.
        audio: "copy" (encoded anew only where the kind of file asks for it), "none", or an encoder's name.
        new_sound: whether sound will come as samples, as that of live pictures does.
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
        """Write what is still held back, close the file and give it its name.

        Raises:
            OutputError: it cannot be written.
        """

    @abstractmethod
    def abandon(self) -> Path | None:
        """Close what is there, soon and so that it plays.

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
