"""Makes docs/explore-sheet.jpg: three photographs, each in the first random styles that pass, by rank.

Usage: python -m tools.explore.sheet
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from skimage import data

from vidstyle.explore.candidates import search
from vidstyle.explore.measure import Original, reduce_picture
from vidstyle.gallery.style_samples import restyle_picture

TARGET = Path(__file__).parents[2] / "docs" / "explore-sheet.jpg"
PHOTOGRAPHS = ("astronaut", "chelsea", "coffee")
SEED, COUNT, COLUMNS = 7, 16, 8
WIDTH, HEIGHT = 168, 126
DRAWN_SIDE = 640
QUALITY = 74


def main() -> None:
    """See the top of the file."""
    sheet = cv2.cvtColor(np.vstack([rows_of(name) for name in PHOTOGRAPHS]), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(TARGET), sheet, [cv2.IMWRITE_JPEG_QUALITY, QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1])
    print(f"{TARGET}: {TARGET.stat().st_size} bytes")


def rows_of(name: str) -> np.ndarray:
    """Rows of one of scikit-image's photographs in random styles, H x W x 3 uint8."""
    picture = reduce_picture(cropped(getattr(data, name)()), DRAWN_SIDE)
    chosen = search(Original(picture), SEED, COUNT).chosen
    tiles = [cv2.resize(restyle_picture(picture, each.style), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
             for each in chosen]  # fmt: skip
    return np.vstack([np.hstack(tiles[start : start + COLUMNS]) for start in range(0, COUNT, COLUMNS)])


def cropped(picture: np.ndarray) -> np.ndarray:
    """The upper part of a picture, with the aspect ratio of a tile."""
    height, width = picture.shape[:2]
    rows, columns = min(height, width * HEIGHT // WIDTH), min(width, height * WIDTH // HEIGHT)
    left = (width - columns) // 2
    return np.ascontiguousarray(picture[:rows, left : left + columns])


if __name__ == "__main__":
    main()
