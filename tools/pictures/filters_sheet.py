"""Draw the sheet of the learned blocks: `python -m tools.pictures.filters_sheet`.

It shows photographs of scikit-image, or the last ten pictures of a folder.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import skimage.data

from vidstyle.blade.photographs import photographs_in
from vidstyle.gallery.style_samples import encode_picture, label_picture, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import Step, Style

SETTINGS: dict[str, tuple[str, dict[str, Any]]] = {
    "source": ("detail", {"delta": 0}),
    "etf 1: 1 pass": ("etf", {"passes": 1}),
    "etf 2: 6 passes": ("etf", {"passes": 6, "rho": 3}),
    "etf 3: broad, 1 pass": ("etf", {"brush": "broad", "passes": 1, "rho": 4}),
    "etf 4: broad, 3 passes": ("etf", {"brush": "broad", "passes": 3, "rho": 5, "reselect": True}),
    "etf 5: broad, 8 passes": ("etf", {"brush": "broad", "passes": 8, "rho": 8, "reselect": True}),
    "tvf curvature": ("tvf", {"passes": 6}),
    "tvf variation": ("tvf", {"flow": "variation", "passes": 4, "time": 12}),
    "detail -100": ("detail", {"delta": -100}),
    "detail -20": ("detail", {"delta": -20}),
    "detail +20": ("detail", {"delta": 20}),
    "detail +100": ("detail", {"delta": 100}),
}
"""Name of each column, with its block and values."""
MAX_SIDE_PX = 160
PHOTOGRAPHS = (
    "astronaut", "chelsea", "coffee", "rocket", "hubble_deep_field",
    "retina", "camera", "grass", "gravel", "brick",
)  # fmt: skip
"""Photographs in the public domain that scikit-image ships, with something to filter in the middle."""


def main() -> None:
    """Draw the sheet and print its path."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/filters.jpg"))
    arguments = parser.parse_args()
    pictures = [crop_center(getattr(skimage.data, name)()) for name in PHOTOGRAPHS]
    if arguments.folder:
        found = photographs_in(arguments.folder, 700)[-10:]
        pictures = [crop_center(cv2.convertScaleAbs(each.color(), alpha=255)) for each in found]
    sheet = [
        label_picture(apply_block(picture, *setting), name)
        for picture in pictures
        for name, setting in SETTINGS.items()
    ]
    arguments.output.write_bytes(encode_picture(sheet_of(sheet, len(SETTINGS)), arguments.output.suffix))
    print(arguments.output)


def apply_block(picture: np.ndarray, block: str, values: dict[str, Any]) -> np.ndarray:
    """Return the output of one block for a picture."""
    return stylize(picture, Style("sheet", background=(Step(block, values),)))


def crop_center(picture: np.ndarray, max_side: int = MAX_SIDE_PX) -> np.ndarray:
    """Return the center of a picture, at most `max_side` pixels wide and high, as RGB."""
    top, left = (max(side - max_side, 0) // 2 for side in picture.shape[:2])
    middle = np.ascontiguousarray(picture[top : top + max_side, left : left + max_side])
    return middle if middle.ndim == 3 else cv2.cvtColor(middle, cv2.COLOR_GRAY2RGB)


if __name__ == "__main__":
    main()
