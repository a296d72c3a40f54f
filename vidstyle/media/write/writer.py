"""The writer that fits a target."""

from __future__ import annotations

from pathlib import Path

from vidstyle.media.options import VideoInfo, WriteOptions
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.base import Writer
from vidstyle.media.write.containers import kind_of
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.media.write.gif import GifWriter
from vidstyle.media.write.images import PictureWriter, is_pattern

__all__ = ["WriteOptions", "Writer", "open_writer"]


def open_writer(
    target: str | Path, info: VideoInfo, options: WriteOptions, source: Reader | None = None
) -> Writer:
    """A writer for the target; checks what can be checked before the first frame is decoded.

    Args:
        target: a path whose ending says what to write; `%05d.png` for one file for each picture; "-" for
            standard output, which wants `options.format`.
        info: description of the video.
        options: how to write.
        source: where they come from; its other streams, chapters and tags are carried over.

    Raises:
        UsageError: the target exists, is the input, or cannot hold what is asked for.
        OutputError: its folder is missing or cannot be written to.
    """
    kind = kind_of(str(target), options.format, info.still or is_pattern(str(target)))
    writers: dict[str, type[Writer]] = {"picture": PictureWriter, "gif": GifWriter, "film": FilmWriter}
    return writers[kind.way](target, kind, info, options, source)
