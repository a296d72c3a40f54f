"""Finds out what kind of source a name stands for, and opens it."""

from __future__ import annotations

import os
from pathlib import Path

from vidstyle.media.film_source import USUAL_RATE, FilmSource
from vidstyle.media.open import open_media
from vidstyle.media.options import ReadOptions
from vidstyle.media.raw_video import RAW
from vidstyle.media.sequence import SequenceSource, is_animated_webp, is_pattern
from vidstyle.media.source import Source


def open_source(source: str | os.PathLike[str], options: ReadOptions) -> Source:
    """A film, a sequence of numbered pictures, an animation, or what comes on standard input for "-".

    Raises:
        InputError: it cannot be read.
        UsageError: a URL that was not allowed.
    """
    if is_pattern(source):
        rate = options.fps or options.rate or USUAL_RATE
        return SequenceSource.from_pattern(str(source), rate, options.max_pixels)
    if str(source) != "-" and is_animated_webp(Path(source)):
        return SequenceSource.from_webp(Path(source), options.max_pixels)
    container = open_media(
        source,
        allow_url=options.allow_url,
        max_pixels=options.max_pixels,
        hwaccel=options.hwaccel,
        format=options.format,
        options=options.raw.demuxer_options(options.rate or USUAL_RATE) if options.format == RAW else {},
    )
    try:
        name = "standard input" if str(source) == "-" else str(source)
        file = None if str(source) == "-" or not Path(source).is_file() else Path(source)
        return FilmSource(container, name, options.max_pixels, file)
    except BaseException:
        container.close()
        raise
