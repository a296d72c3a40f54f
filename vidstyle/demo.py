"""Makes the demo: a film of our own and what styles make of it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np

from vidstyle.cpu import CpuRenderer
from vidstyle.demo_film import RATE, SAMPLE_RATE, SECONDS, film_picture, film_sound
from vidstyle.errors import OutputError
from vidstyle.media.film import write_film
from vidstyle.media.writer import WriteOptions
from vidstyle.picture import Encoding, Picture
from vidstyle.pipeline import render
from vidstyle.style import load_style

STYLES = ("comic", "sketch", "poster")


def make_demo(folder: Path) -> Iterator[Path]:
    """Write the film and its restyled versions into the folder, over older ones; yields each when done.

    Raises:
        OutputError: the folder cannot be made or written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(folder, f"cannot be made ({error.strerror})", "choose another --output") from error
    film = folder / "film.mp4"
    make_film(film)
    yield film
    for style in STYLES:
        target = folder / f"{style}.mp4"
        render(film, target, style, write=WriteOptions(overwrite=True))
        yield target


def make_film(path: Path, repeats: int = 1) -> None:
    """Write our own short film with its tune, several times over if asked."""
    renderer = CpuRenderer(load_style("plain"))

    def pictures() -> Iterator[Picture]:
        for number in range(repeats * SECONDS * RATE):
            drawn = Picture.from_array(film_picture(number / RATE % SECONDS))
            yield renderer.run(drawn, number / RATE, Encoding())

    sound = np.tile(film_sound(), repeats)
    write_film(path, pictures(), Fraction(RATE), sound, SAMPLE_RATE)
    renderer.close()
