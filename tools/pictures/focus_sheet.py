"""Draw the sheet of docs/focus.md: `python -m tools.pictures.focus_sheet`.

A photograph of scikit-image, padded so that the face is small, in each style without and with focus.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import skimage.data

from vidstyle.gallery.style_samples import encode_picture, label_picture, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import PLAIN, load_style, style_names

PICTURE_SIDE_PX = 900
SHOWN_SIDE_PX = 150
PHOTOGRAPH_SCALE = 0.8
"""Scale of the photograph: the face is then 112 pixels high."""
FACE_CENTER_PX = 225, 120
"""Position of the face in the photograph."""
SHEET_COLUMNS = 4


def main() -> None:
    """Draw the sheet and print its path."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/focus.jpg"))
    arguments = parser.parse_args()
    picture, (left, top) = pad_photograph()
    shown = slice(top, top + SHOWN_SIDE_PX), slice(left, left + SHOWN_SIDE_PX)
    samples = []
    for name in style_names():
        if name != PLAIN:
            style = load_style(name)
            pair = [stylize(picture, replace(style, focus=focus))[shown] for focus in (0.0, 1.0)]
            samples.append(label_picture(np.hstack(pair), name))
    arguments.output.write_bytes(encode_picture(sheet_of(samples, SHEET_COLUMNS), arguments.output.suffix))
    print(arguments.output)


def pad_photograph() -> tuple[np.ndarray, tuple[int, int]]:
    """Return the padded photograph, and left and top of the part that is shown."""
    photograph = cv2.resize(
        skimage.data.astronaut(), None, fx=PHOTOGRAPH_SCALE, fy=PHOTOGRAPH_SCALE, interpolation=cv2.INTER_AREA
    )
    border = PICTURE_SIDE_PX - photograph.shape[0]
    picture = cv2.copyMakeBorder(photograph, 0, border, border // 2, border - border // 2, cv2.BORDER_REFLECT)
    across, down = (round(PHOTOGRAPH_SCALE * place) for place in FACE_CENTER_PX)
    return picture, (border // 2 + across - SHOWN_SIDE_PX // 2, down - SHOWN_SIDE_PX // 2)


if __name__ == "__main__":
    main()
