"""Draw a filter and the bank trained on it: `python -m tools.pictures.learned_sheet BANK.npz MODULE:NAME`."""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import skimage.data

from vidstyle.blade.photographs import Photograph, luma_of
from vidstyle.blade.reference_filter import reference_by_function
from vidstyle.gallery.style_samples import encode_picture, label_picture, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import Step, Style

SHOWN_CROP = (slice(20, 260), slice(110, 350))
"""Part of scikit-image's cat with fine texture."""


def main() -> None:
    """Draw the source, the filter applied to its luma, and the bank, and print the path of the sheet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bank", type=Path)
    parser.add_argument("function")
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/learned.jpg"))
    arguments = parser.parse_args()
    source = skimage.data.chelsea()
    reference = reference_by_function(arguments.function)
    (picture,) = reference.apply(source / 255, Photograph(Path("chelsea"), 0))
    step = Step("learned", {"bank": arguments.bank.name})
    learned = stylize(source, Style("learned", background=(step,), folder=arguments.bank.parent))
    ycrcb = cv2.cvtColor(source, cv2.COLOR_RGB2YCrCb)
    ycrcb[..., 0] = (luma_of(picture) * 255 + 0.5).clip(0, 255)
    filtered = cv2.cvtColor(ycrcb, cv2.COLOR_YCrCb2RGB)
    pictures = {"source": source, arguments.function: filtered, "bank": learned}
    enlarged = {
        name: cv2.resize(picture[SHOWN_CROP], None, fx=1.5, fy=1.5, interpolation=cv2.INTER_CUBIC)
        for name, picture in pictures.items()
    }
    arguments.output.write_bytes(
        encode_picture(sheet_of([label_picture(each, name) for name, each in enlarged.items()], 3), ".jpg")
    )
    print(arguments.output)


if __name__ == "__main__":
    main()
