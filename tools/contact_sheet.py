"""Draws every block at its default and every style: `python tools/contact_sheet.py [docs]`."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import skimage.data

from vidstyle.blocks import all_blocks
from vidstyle.gallery.sheet import labelled, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import Step, Style, load_style, style_names

SHOWN_AFTER: dict[str, tuple[Step, ...]] = {
    "blend": (Step("gaussian", {"sigma": 6}),),
    "minimum_range": (Step("brightness", {"factor": 0.5}),),
    "to_color": (Step("to_gray"), Step("soft_threshold")),
}
"""What runs before the blocks that would show nothing on the photograph itself."""

CROP = np.s_[:320, 64:384]
"""What is shown of the photograph."""
SIDE = 224
"""Of one picture of a block, in pixels."""
STYLE_SIDE = 400
"""Of one picture of a style, in pixels."""
COLUMNS = 6


def main() -> None:
    """Draw the two sheets and say where they are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, nargs="?", default=Path("docs"))
    folder: Path = parser.parse_args().folder
    smallest = [cv2.IMWRITE_PNG_COMPRESSION, 9, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_ALL_FILTERS]
    for name, sheet in (
        ("blocks", sheet_of(labelled_blocks(), COLUMNS)),
        ("styles", sheet_of(labelled_styles(), len(style_names()))),
    ):
        output = folder / f"{name}.png"
        if not cv2.imwrite(str(output), sheet[..., ::-1], smallest):
            parser.error(f"{output} cannot be written")
        print(output)


def labelled_styles() -> Iterator[np.ndarray]:
    """The photograph in every style."""
    photograph = cv2.resize(
        skimage.data.astronaut()[CROP], (STYLE_SIDE, STYLE_SIDE), interpolation=cv2.INTER_CUBIC
    )
    for name in style_names():
        yield labelled(stylize(photograph, load_style(name)), name)


def labelled_blocks() -> Iterator[np.ndarray]:
    """The photograph and what each block makes of it, in the order of the names."""
    photograph = cv2.resize(skimage.data.astronaut()[CROP], (SIDE, SIDE), interpolation=cv2.INTER_AREA)
    yield labelled(photograph, "source")
    for name in all_blocks():
        steps = (*SHOWN_AFTER.get(name, ()), Step(name))
        picture = stylize(photograph, Style(name, background=steps))
        yield labelled(picture, ", ".join(step.block for step in steps))


if __name__ == "__main__":
    main()
