"""Write the demo: a generated film, restyled versions and a comic page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.comic.lettering.fonts import check_pillow
from vidstyle.comic.make import ComicOptions, make_comic
from vidstyle.comic.select.key_frames import KeyFrameOptions
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.demo.drawing import FILM_RATE, FILM_SECONDS, film_picture, film_sound
from vidstyle.errors import OutputError, UsageError, log
from vidstyle.media.write.atomic import atomic_file
from vidstyle.media.write.memory import write_film
from vidstyle.media.write.writer import WriteOptions
from vidstyle.pipeline.render import render

DEMO_STYLES = ("comic", "sketch", "poster")
DEMO_SUBTITLES = (
    (0.0, 1.0, "<i>Early in the morning</i>"),
    (1.1, 2.0, "Wait for me!"),
    (2.4, 3.6, "Catch me if you can!"),
)
"""The subtitles of the film: start and end in seconds, and text."""
PANEL_COUNT = 4


def make_demo(folder: Path) -> Iterator[Path]:
    """Write the film, restyled versions and a comic page to a folder; overwrite existing files.

    Yield each path when it is complete. Without Pillow, skip the comic page with a warning.

    Raises:
        OutputError: the folder cannot be created or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            folder, f"cannot be created ({error.strerror})", "choose another --output"
        ) from error
    film = folder / "film.mp4"
    make_film(film)
    yield film
    for style in DEMO_STYLES:
        target = folder / f"{style}.mp4"
        render(film, target, style, write=WriteOptions(overwrite=True))
        yield target
    try:
        check_pillow()
    except UsageError as error:
        log.warning(str(error))
    else:
        yield make_page(film, folder / "comic.png")


def make_page(film: Path, target: Path) -> Path:
    """Write a comic page of the film, and its subtitles next to the film."""
    words = film.with_suffix(".srt")
    text = "\n".join(
        f"{number}\n00:00:{start:06.3f} --> 00:00:{end:06.3f}\n".replace(".", ",") + f"{line}\n"
        for number, (start, end, line) in enumerate(DEMO_SUBTITLES, 1)
    )
    with atomic_file(words, overwrite=True) as write:
        write(text.encode())
    page: dict[str, Any] = {"size": "square", "seed": 1, "title": "Good morning", "subtitles": str(words)}
    options = ComicOptions(key_frames=KeyFrameOptions(PANEL_COUNT), overwrite=True, **page)
    return make_comic(film, target, options).files[0]


def make_film(path: Path, repeats: int = 1, draw: Callable[[float], np.ndarray] = film_picture) -> None:
    """Write the generated film with its sound, repeated if asked.

    Args:
        draw: returns the picture at a time in seconds, H x W x 3 uint8 RGB.
    """
    times = (number / FILM_RATE % FILM_SECONDS for number in range(repeats * FILM_SECONDS * FILM_RATE))
    pictures = (convert(Picture.from_array(draw(time)), Encoding()) for time in times)
    sound = np.tile(film_sound(), repeats)
    write_film(path, pictures, Fraction(FILM_RATE), sound)
