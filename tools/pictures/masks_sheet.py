"""Draw the sheet of docs/masks.md: `python -m tools.pictures.masks_sheet`.

A photograph of scikit-image with styles in its regions. The model of docs/masks.md must be installed.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import cv2
import skimage.data

from vidstyle.gallery.style_samples import encode_picture, label_picture, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import PLAIN, Style, load_style, style_from_table
from vidstyle.style.behind import style_behind

SIDE_PX = 360
SHEET_COLUMNS = 4
PEOPLE_STYLE = {"format": 1, "background": [{"from": "people"}]}


def main() -> None:
    """Draw the sheet and print its path."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/masks.jpg"))
    output = parser.parse_args().output
    picture = cv2.resize(skimage.data.astronaut(), (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_AREA)
    samples = [label_picture(stylize(picture, style), name) for name, style in load_shown_styles().items()]
    output.write_bytes(encode_picture(sheet_of(samples, SHEET_COLUMNS), output.suffix))
    print(output)


def load_shown_styles() -> dict[str, Style]:
    """Return the styles of the sheet, by the command-line options that select them."""
    ink, plain = load_style("ink"), load_style(PLAIN)
    return {
        "source": plain,
        "the mask people": style_from_table(PEOPLE_STYLE, "people"),
        "-s comic --only people": replace(load_style("comic"), only="people"),
        "-s impressionist --only background": replace(load_style("impressionist"), only="background"),
        "-s manga --keep faces": replace(load_style("manga"), keep="faces"),
        "-s ink --background watercolor": replace(ink, behind=style_behind("watercolor")),
        "-s plain --background blur": replace(plain, behind=style_behind("blur")),
        "-s plain --background #00b140": replace(plain, behind=style_behind("#00b140")),
    }


if __name__ == "__main__":
    main()
