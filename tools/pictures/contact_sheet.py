"""Draw every block at its defaults, and every style: `python -m tools.pictures.contact_sheet [docs]`.

It also updates the thumbnails of the shipped styles, which are part of the package.
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
"""Steps before blocks that have no visible effect on the photograph itself."""
SHOWN_VALUES = {name: {"flow": "flow"} for name in ("kuwahara", "strokes")}
"""Parameters of blocks that differ from the defaults."""

SHOWN_CROP = np.s_[:320, 64:384]
"""The part of the photograph that is shown."""
SAMPLE_SIDE_PX = 224
STYLE_SIDE_PX = 720
"""Size at which styles run, before their results are scaled down; styles are designed for this height."""
BLOCK_COLUMNS, STYLE_COLUMNS = 6, 5
VARIANTS = ("engraving:blue", "ink:orange", "pixel:game-boy", "woodcut:linocut")
"""Variants that fill the last row of the sheet of styles."""
THUMBNAIL_CROP = np.s_[:288]
"""The part of the photograph that thumbnails show."""
THUMBNAIL_QUALITY = 75
"""WebP quality; all thumbnails together take 100 KB."""


def main() -> None:
    """Draw the two sheets and the thumbnails, and print their paths."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs"))
    folder: Path = parser.parse_args().folder
    for name, pictures, columns in (
        ("blocks", label_blocks(), BLOCK_COLUMNS),
        ("styles", label_styles(), STYLE_COLUMNS),
    ):
        output = folder / f"{name}.jpg"
        output.write_bytes(encode_picture(sheet_of(pictures, columns), ".jpg"))
        print(output)
    write_thumbnails()


def write_thumbnails() -> None:
    """Write the photograph at twice the size of thumbnails, and the thumbnail of each shipped style."""
    photograph = skimage.data.astronaut()[THUMBNAIL_CROP]
    larger = cv2.resize(
        photograph, (2 * THUMBNAIL_WIDTH_PX, 2 * THUMBNAIL_HEIGHT_PX), interpolation=cv2.INTER_AREA
    )
    _write_thumbnail(PLAIN, larger)
    for file in sorted(asset_folder("styles").glob("*.toml")):
        _write_thumbnail(file.stem, restyle_thumbnail(load_style(file.stem)))


def _write_thumbnail(name: str, picture: np.ndarray) -> None:
    output = THUMBNAIL_FOLDER / f"{name}.webp"
    cv2.imwrite(str(output), picture[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, THUMBNAIL_QUALITY])
    print(output)


def label_styles() -> Iterator[np.ndarray]:
    """Yield the photograph, and its rendering in each style and in some variants."""
    names = [*sorted(style_names(), key=lambda name: (name != PLAIN, name)), *VARIANTS]
    photograph = cv2.resize(
        skimage.data.astronaut()[SHOWN_CROP], (STYLE_SIDE_PX, STYLE_SIDE_PX), interpolation=cv2.INTER_CUBIC
    )
    for name, sample in zip(names, samples_of(photograph, map(load_style, names)), strict=True):
        small = cv2.resize(sample.picture, (SAMPLE_SIDE_PX, SAMPLE_SIDE_PX), interpolation=cv2.INTER_AREA)
        yield label_picture(small, "source" if sample.style.is_plain else name)


def label_blocks() -> Iterator[np.ndarray]:
    """Yield the photograph, and the output of each block, in the order of their names."""
    photograph = cv2.resize(
        skimage.data.astronaut()[SHOWN_CROP], (SAMPLE_SIDE_PX, SAMPLE_SIDE_PX), interpolation=cv2.INTER_AREA
    )
    yield label_picture(photograph, "source")
    for name in all_blocks():
        steps = (*SHOWN_AFTER.get(name, ()), Step(name, SHOWN_VALUES.get(name, {})))
        picture = stylize(photograph, Style(name, background=steps))
        yield label_picture(picture, ", ".join(step.block for step in steps if step.block))


if __name__ == "__main__":
    main()
