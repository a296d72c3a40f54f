"""Simulate a user who explores with a look in mind, and count the screens until a tile is close to it.

The simulated user sees only pictures, chooses the tile closest to the hidden look, and compares pictures by
other numbers than the program. A picture is in the neighbourhood of a look if it is as close as the closest
hundredth of random styles. Random choice takes eleven screens of nine tiles on average.

    python -m tools.explore.simulated_user --random 50 photograph.jpg
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from statistics import median

import cv2
import numpy as np

from vidstyle.explore.choosing.chooser import Chooser
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.generate import random_style
from vidstyle.explore.look import Look, look_of
from vidstyle.explore.workers import Workers
from vidstyle.gallery.preview import read_still
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Style

NEIGHBOUR_SHARE = 0.01
"""The share of random styles that are in the neighbourhood of a look."""
GRID_SIDE_COUNT = 12
"""Rows and columns in which the user compares colours and texture."""
BLUR_SIGMAS_PX = (1.0, 2.0, 4.0)
"""Standard deviations of blurs in pixels; texture is the difference of two successive ones."""
HIDDEN_LOOK_SEED, RANDOM_SEED = 5_000_000, 6_000_000
"""First seeds of hidden looks and of random styles; the program never draws these."""


def describe_picture(picture: np.ndarray) -> np.ndarray:
    """Return a vector that describes a picture, H x W x 3 uint8; similar pictures have close vectors."""
    lab = cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
    blurs = [cv2.GaussianBlur(lab[..., 0], (0, 0), sigma) for sigma in BLUR_SIGMAS_PX]
    bands = [np.abs(one - other) for one, other in zip([lab[..., 0], *blurs[:-1]], blurs, strict=True)]
    textures = [_cells(np.log1p(band)) for band in bands]
    values = [_cells(lab).ravel() / 10, *(2 * texture.ravel() for texture in textures)]
    return np.concatenate(values) / GRID_SIDE_COUNT


def _cells(picture: np.ndarray) -> np.ndarray:
    return cv2.resize(picture, (GRID_SIDE_COUNT, GRID_SIDE_COUNT), interpolation=cv2.INTER_AREA)


def count_screens(
    chooser: Chooser, hidden: np.ndarray, radius: float, most: int
) -> tuple[int | None, list[float]]:
    """Return the number of screens until a tile is in the neighbourhood, and the least distance of each.

    The number is None if no tile of the first `most` screens is close enough.
    """
    nearest: list[float] = []
    place = 0
    for number in range(most):
        screen = chooser.new_screen() if number == 0 else chooser.more_like(place)
        apart = [float(np.linalg.norm(describe_picture(tile.look.picture) - hidden)) for tile in screen.tiles]
        place = int(np.argmin(apart))
        nearest.append(min(apart))
        if min(apart) <= radius:
            return number + 1, nearest
    return None, nearest


def neighbourhood_radius(hidden: np.ndarray, others: Sequence[np.ndarray]) -> float:
    """Return the radius of the neighbourhood of a look."""
    return float(np.quantile([np.linalg.norm(each - hidden) for each in others], NEIGHBOUR_SHARE))


def render_looks(workers: Workers, picture: np.ndarray, styles: Sequence[Style]) -> list[Look | None]:
    """Render a picture in styles; None where a style fails."""
    return [each.result() for each in [workers.submit(0, look_of, picture, style) for style in styles]]


def main() -> None:
    """Print a line for each hidden look, and the number of looks that were found."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture")
    parser.add_argument("--random", type=int, default=50, help="hidden looks that are random styles")
    parser.add_argument(
        "--others", type=int, default=400, help="random styles for the radius of the neighbourhood"
    )
    parser.add_argument("--screens", type=int, default=8)
    parser.add_argument("--side", type=int, default=200, help="longest side of the picture")
    arguments = parser.parse_args()
    picture = np.ascontiguousarray(reduce_picture(read_still(arguments.picture), arguments.side))
    with Workers() as workers:
        looks = partial(render_looks, workers, picture)
        drawn = looks([random_style(RANDOM_SEED + number) for number in range(arguments.others)])
        others = [describe_picture(look.picture) for look in drawn if look and not look.fault]
        hidden = {style.name: style for style in shipped_styles()}
        hidden |= {
            f"random {number}": random_style(HIDDEN_LOOK_SEED + number)
            for number in range(3 * arguments.random)
        }
        found, left = [], len(shipped_styles()) + arguments.random
        for number, (name, look) in enumerate(zip(hidden, looks(list(hidden.values())), strict=True)):
            if look is None or (look.fault and name.startswith("random")) or not left:
                continue
            left -= 1
            target = describe_picture(look.picture)
            chooser = Chooser(looks, shipped_styles(), seed=number)
            radius = neighbourhood_radius(target, others)
            needed, nearest = count_screens(chooser, target, radius, arguments.screens)
            found.append(needed)
            print(
                f"{name:16} {needed or '-'!s:3} {radius:.2f} {' '.join(f'{each:.2f}' for each in nearest)}",
                flush=True,
            )
    reached = sorted(each for each in found if each)
    print(f"{len(reached)} of {len(found)} within {arguments.screens} screens, median {median(reached)}")


if __name__ == "__main__":
    main()
