"""Simulate a user who explores with a wish in words: screens until it is met, and how much tiles differ.

The user sees nothing but pictures, and judges by other numbers than the program: simple limits for each
wish. Two tiles show different looks if their `appearance_distance` is at least that between two pictures in
one style; the page does not use it to choose tiles.

    python -m tools.explore.wishes photograph.jpg
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np

from tools.explore.simulated_user import render_looks
from vidstyle.explore.choosing.chooser import Chooser
from vidstyle.explore.choosing.tile_screen import CHOSEN_KIND, TileScreen
from vidstyle.explore.colors import oklab
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.matching.appearance import appearance_distance, appearance_of
from vidstyle.explore.workers import Workers
from vidstyle.gallery.preview import read_still
from vidstyle.media.resize import reduce_picture

MAX_SCREENS = 8
SAME_LOOK_DISTANCE = 1.0
"""Appearance distance below which two pictures show the same look: usual between pictures in one style."""
WISHES = {
    "light, no colour": {"light": (0.72, 1), "color": (0, 0.03)},
    "vivid poster": {"color": (0.09, 1), "flat": (0.55, 1), "grain": (0, 0.02)},
    "dark ink": {"light": (0, 0.35), "color": (0, 0.06), "flat": (0.3, 1)},
    "soft painting": {"color": (0.04, 0.12), "hard": (0, 0.11), "grain": (0, 0.01)},
    "grainy print": {"grain": (0.03, 1), "flat": (0, 0.6), "color": (0, 0.1)},
}
"""What each wish means: limits for `measure_look`."""
CLEAR_DIFFERENCES = {"light": 0.2, "color": 0.05, "flat": 0.25, "grain": 0.01, "hard": 0.05}
"""What counts as a clear difference, for the distance of a picture to a wish."""


def main() -> None:
    """Print a line for each wish, and the distances of repeated choices."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("picture")
    parser.add_argument("--side", type=int, default=480, help="longest side of the picture")
    parser.add_argument("--seeds", type=int, default=1, help="runs of each wish")
    arguments = parser.parse_args()
    picture = np.ascontiguousarray(reduce_picture(read_still(arguments.picture), arguments.side))
    with Workers() as workers:
        looks = partial(render_looks, workers, picture)
        for wish in WISHES:
            for seed in range(arguments.seeds):
                met, different, nearest = count_screens(Chooser(looks, shipped_styles(), seed=seed), wish)
                print(f"{wish:17} {met or '-'!s:3} looks {different} nearest {nearest}", flush=True)
        for near in (0.1, 0.4, 0.9):
            print(
                f"near {near}: {repeat_choice(Chooser(looks, shipped_styles(), seed=1, near=near))}",
                flush=True,
            )


def measure_look(picture: np.ndarray) -> dict[str, float]:
    """Return the lightness, colour, flat parts, grain and edges of a picture, H x W x 3 uint8."""
    lab = oklab(picture / 255.0)
    light = lab[..., 0].astype(np.float32)
    step = np.abs(np.diff(light, axis=1))
    fine = np.abs(light - cv2.GaussianBlur(light, (0, 0), 1))
    return {
        "light": float(light.mean()),
        "color": float(np.hypot(lab[..., 1], lab[..., 2]).mean()),
        "flat": float((step < 0.01).mean()),
        "grain": float(np.median(cv2.blur(fine, (9, 9)))),
        "hard": float(np.percentile(step, 95)),
    }


def wish_distance(picture: np.ndarray, wish: str) -> float:
    """Return the distance of a picture from a wish; 0 if it is met."""
    numbers = measure_look(picture)
    return sum(
        max(low - numbers[name], numbers[name] - high, 0) / CLEAR_DIFFERENCES[name]
        for name, (low, high) in WISHES[wish].items()
    )


def count_screens(chooser: Chooser, wish: str) -> tuple[int | None, list[int], list[float]]:
    """Return the screens until a tile meets the wish, and the looks and the least distance of each screen."""
    different, nearest, place = list[int](), list[float](), 0
    for number in range(MAX_SCREENS):
        screen = chooser.new_screen() if number == 0 else chooser.more_like(place)
        apart = [wish_distance(tile.look.picture, wish) for tile in screen.tiles]
        place = int(np.argmin(apart))
        different.append(count_looks(screen))
        nearest.append(round(min(apart), 2))
        if not min(apart):
            return number + 1, different, nearest
    return None, different, nearest


def count_looks(screen: TileScreen) -> int:
    """Count the tiles, taken in order, that differ from all that were taken."""
    taken: list[np.ndarray] = []
    for tile in screen.tiles:
        look = appearance_of(tile.look.picture)
        if all(appearance_distance(look, other) >= SAME_LOOK_DISTANCE for other in taken):
            taken.append(look)
    return len(taken)


def repeat_choice(chooser: Chooser, screens: int = 4) -> str:
    """Choose the middle tile repeatedly; describe the distances from it, and the looks, of each screen."""
    chooser.new_screen()
    said: list[str] = []
    place = 0
    for _ in range(screens):
        screen = chooser.more_like(place)
        place = len(screen.tiles) // 2
        apart = distances_to_chosen(screen)
        said.append(f"{np.mean(apart):.2f} ({count_looks(screen)} looks)" if apart else "-")
    return ", ".join(said)


def distances_to_chosen(screen: TileScreen) -> Sequence[float]:
    """Return the appearance distances of the tiles with other values from the chosen one."""
    middle = next(tile for tile in screen.tiles if tile.kind == CHOSEN_KIND)
    look = appearance_of(middle.look.picture)
    return [appearance_distance(look, appearance_of(tile.look.picture))
            for tile in screen.tiles if tile.kind == "values"]  # fmt: skip


if __name__ == "__main__":
    main()
