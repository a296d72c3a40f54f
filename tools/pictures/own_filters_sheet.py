"""Draw filters of other programs and their banks: `python -m tools.pictures.own_filters_sheet`.

Banks are trained on photographs of scikit-image; the last photograph is held out and drawn. Needs the program
`ffmpeg`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
import skimage.data

from tools import foreign_filters
from tools.foreign_filters import make_reference, train_bank
from tools.pictures.filters_sheet import crop_center
from vidstyle.blade.bank_file import load_bank
from vidstyle.blade.photographs import Photograph
from vidstyle.gallery.style_samples import encode_picture, label_picture, sheet_of
from vidstyle.renderer import stylize
from vidstyle.style import Step, Style

PHOTOGRAPHS = (
    "astronaut",
    "brick",
    "camera",
    "coffee",
    "grass",
    "gravel",
    "hubble_deep_field",
    "rocket",
    "chelsea",
)
"""The last is held out."""
TRAINED_PX, DRAWN_PX = 320, 240
"""Sides of the center crops for training, and of the part that is drawn."""
DRAWN_CROP = np.s_[20 : 20 + DRAWN_PX, 40 : 40 + DRAWN_PX]
"""The part of the held-out photograph that is drawn."""
NAMES = (
    "scipy morphological_gradient",
    "ffmpeg cas=1",
    "cv2.edgePreservingFilter",
    "cv2.stylization",
    "Kuwahara 7",
)
"""Filters of `foreign_filters`."""
DIFFERENCE_FACTOR = 4
"""Gain of the drawn differences."""


def main() -> None:
    """Train the banks, draw the sheet and print its path."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/own-filters.jpg"))
    output = parser.parse_args().output
    sys.path.insert(
        0, str(Path(foreign_filters.__file__).parent)
    )  # the functions are named without a package
    sources = {name: source for kind in foreign_filters.FILTERS.values() for name, source in kind.items()}
    with TemporaryDirectory() as folder:
        images = Path(folder) / "photographs"
        images.mkdir()
        for number, name in enumerate(PHOTOGRAPHS):
            picture = crop_center(getattr(skimage.data, name)(), TRAINED_PX)
            cv2.imwrite(str(images / f"{number}-{name}.png"), picture[..., ::-1])
        cells = [cell for name in NAMES for cell in _draw_row(name, sources[name], images)]
    output.write_bytes(encode_picture(sheet_of(cells, 4), ".jpg"))
    print(output)


def _draw_row(name: str, source: str, images: Path) -> Iterator[np.ndarray]:
    """Yield the labelled pictures of a filter: source, filter, bank, difference."""
    photograph = Photograph(max(images.iterdir()))
    bank = images.parent / "own.npz"
    run = train_bank(
        Path(sys.executable).with_name("vidstyle"), bank, images, source, ["--chroma", "--hold-out", "1"]
    )
    if run.returncode:
        raise SystemExit(run.stderr)
    explained = load_bank(bank).about["fidelity"]["explained"]
    color = photograph.color()
    (filtered,) = make_reference(source).apply(color, photograph)
    levels = [np.clip(each * 255 + 0.5, 0, 255).astype(np.uint8) for each in (color, filtered)]
    look = Style("own", background=(Step("learned", {"bank": bank.name}),), folder=bank.parent)
    learned = stylize(levels[0], look)
    difference = np.abs(learned.astype(int) - levels[1])
    print(f"{name}: {explained:.1%}, mean difference {difference.mean():.2f} levels", flush=True)
    yield label_picture(levels[0][DRAWN_CROP], "source")
    yield label_picture(levels[1][DRAWN_CROP], name)
    yield label_picture(learned[DRAWN_CROP], f"bank: explains {explained:.0%}")
    yield label_picture(
        (DIFFERENCE_FACTOR * difference).clip(0, 255).astype(np.uint8)[DRAWN_CROP],
        f"difference x {DIFFERENCE_FACTOR}",
    )


if __name__ == "__main__":
    main()
