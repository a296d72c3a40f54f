"""Make docs/explore-sheet.jpg: three photographs, each in the first random styles that pass, by rank.

Usage: python -m tools.explore.sheet
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from skimage import data

from vidstyle.explore.candidates import search
from vidstyle.explore.measure import Original
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture

TARGET = Path(__file__).parents[2] / "docs" / "explore-sheet.jpg"
PHOTOGRAPHS = ("astronaut", "chelsea", "coffee")
RANDOM_SEED, STYLE_COUNT, COLUMN_COUNT = 7, 16, 8
TILE_WIDTH, TILE_HEIGHT = 168, 126
RENDERED_SIDE_PX = 640
JPEG_QUALITY = 74


def main() -> None:
    """See the top of the file."""
    sheet = cv2.cvtColor(np.vstack([rows_of(name) for name in PHOTOGRAPHS]), cv2.COLOR_RGB2BGR)
    cv2.imwrite(str(TARGET), sheet, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY, cv2.IMWRITE_JPEG_OPTIMIZE, 1])
    print(f"{TARGET}: {TARGET.stat().st_size} bytes")


def rows_of(name: str) -> np.ndarray:
    """Return rows of one of scikit-image's photographs in random styles, H x W x 3 uint8."""
    picture = reduce_picture(cropped(getattr(data, name)()), RENDERED_SIDE_PX)
    chosen = search(Original(picture), RANDOM_SEED, STYLE_COUNT).chosen
    size = TILE_WIDTH, TILE_HEIGHT
    restyled = (restyle_picture(picture, each.style) for each in chosen)
    tiles = [cv2.resize(each, size, interpolation=cv2.INTER_AREA) for each in restyled]
    return np.vstack(
        [np.hstack(tiles[start : start + COLUMN_COUNT]) for start in range(0, STYLE_COUNT, COLUMN_COUNT)]
    )


def cropped(picture: np.ndarray) -> np.ndarray:
    """Return the upper part of a picture, with the aspect ratio of a tile."""
    height, width = picture.shape[:2]
    rows, columns = (
        min(height, width * TILE_HEIGHT // TILE_WIDTH),
        min(width, height * TILE_WIDTH // TILE_HEIGHT),
    )
    left = (width - columns) // 2
    return np.ascontiguousarray(picture[:rows, left : left + columns])


if __name__ == "__main__":
    main()
