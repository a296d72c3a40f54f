"""Draws every block at its default and every style: `python -m tools.pictures.contact_sheet [docs]`.

It also renews the thumbnails of the shipped styles, which belong to the program.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import skimage.data

from vidstyle.assets import asset_folder
from vidstyle.blocks import all_blocks
from vidstyle.gallery.style_samples import encode_picture, label_picture, samples_of, sheet_of
from vidstyle.gallery.thumbnail import (
    THUMBNAIL_FOLDER,
    THUMBNAIL_HEIGHT_PX,
    THUMBNAIL_WIDTH_PX,
    restyle_thumbnail,
)
from vidstyle.renderer import stylize
from vidstyle.style import PLAIN, SOURCE, Step, Style, load_style, style_names

SHOWN_AFTER: dict[str, tuple[Step, ...]] = {
    "blend": (Step("gaussian", {"sigma": 6}),),
    "minimum_range": (Step("brightness", {"factor": 0.5}),),
    "to_color": (Step("to_gray"), Step("soft_threshold")),
    "lic": (Step("structure_tensor"), Step("gaussian")),
    **dict.fromkeys(
        ("kuwahara", "strokes"),
        (Step("structure_tensor"), Step("gaussian", save="flow"), Step("", source=SOURCE)),
    ),
}
"""What runs before the blocks that would show nothing on the photograph itself."""
VALUES = {name: {"flow": "flow"} for name in ("kuwahara", "strokes")}
"""Their values, where not the defaults."""

CROP = np.s_[:320, 64:384]
"""What is shown of the photograph."""
SIDE = 224
"""Of one picture, in pixels."""
FULL = 720
"""At which styles run, to be reduced: lengths of theirs are meant for it."""
BLOCK_COLUMNS, STYLE_COLUMNS = 6, 5
VARIANTS = ("engraving:blue", "ink:orange", "pixel:game-boy", "woodcut:linocut")
"""Some that fill the last row of the styles."""
LANDSCAPE = np.s_[:288]
"""What thumbnails show of it."""
QUALITY = 75
"""Of thumbnails, as WebP: all of them together take 100 KB."""


def main() -> None:
    """Draw the two sheets and say where they are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs"))
    folder: Path = parser.parse_args().folder
    for name, pictures, columns in (
        ("blocks", labelled_blocks(), BLOCK_COLUMNS),
        ("styles", labelled_styles(), STYLE_COLUMNS),
    ):
        output = folder / f"{name}.jpg"
        output.write_bytes(encode_picture(sheet_of(pictures, columns), ".jpg"))
        print(output)
    write_thumbnails()


def write_thumbnails() -> None:
    """Write the photograph at twice the size of thumbnails, and the thumbnail of each shipped style."""
    photograph = skimage.data.astronaut()[LANDSCAPE]
    larger = cv2.resize(
        photograph, (2 * THUMBNAIL_WIDTH_PX, 2 * THUMBNAIL_HEIGHT_PX), interpolation=cv2.INTER_AREA
    )
    _write_thumbnail(PLAIN, larger)
    for file in sorted(asset_folder("styles").glob("*.toml")):
        _write_thumbnail(file.stem, restyle_thumbnail(load_style(file.stem)))


def _write_thumbnail(name: str, picture: np.ndarray) -> None:
    output = THUMBNAIL_FOLDER / f"{name}.webp"
    cv2.imwrite(str(output), picture[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, QUALITY])
    print(output)


def labelled_styles() -> Iterator[np.ndarray]:
    """The photograph, and what each style and some variants make of it."""
    names = [*sorted(style_names(), key=lambda name: (name != PLAIN, name)), *VARIANTS]
    photograph = cv2.resize(skimage.data.astronaut()[CROP], (FULL, FULL), interpolation=cv2.INTER_CUBIC)
    for name, sample in zip(names, samples_of(photograph, map(load_style, names)), strict=True):
        small = cv2.resize(sample.picture, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
        yield label_picture(small, "source" if sample.style.is_plain else name)


def labelled_blocks() -> Iterator[np.ndarray]:
    """The photograph and what each block makes of it, in the order of the names."""
    photograph = cv2.resize(skimage.data.astronaut()[CROP], (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    yield label_picture(photograph, "source")
    for name in all_blocks():
        steps = (*SHOWN_AFTER.get(name, ()), Step(name, VALUES.get(name, {})))
        picture = stylize(photograph, Style(name, background=steps))
        yield label_picture(picture, ", ".join(step.block for step in steps if step.block))


if __name__ == "__main__":
    main()
