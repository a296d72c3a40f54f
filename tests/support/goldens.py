"""Golden pictures: the result of every shipped style on two small pictures, and the tolerance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from media import photograph

from vidstyle.gallery.style_samples import encode_picture, restyle_picture
from vidstyle.style import PLAIN, Style, load_style, style_names

FOLDER = Path(__file__).parents[1] / "golden"
STYLES = sorted(set(style_names()) - {PLAIN})

MEAN, LEVELS, SHARE = 0.1, 3, 0.999
"""Levels of 255 that samples may be off on average, and how many this share of them may be off at most.

OpenCV, Numba and processors differ in their last bits, which may take one learned filter for another or tip a
sample over a steep threshold. A software GPU with 16 bits between its passes is a rougher difference, and
stays within 0.02 levels and 99.98 %; a slight change of one value in each style was beyond this."""

SHOWN = 16
"""How many times larger than it is a difference is drawn."""

PICTURES = (photograph("astronaut")[60:276:2, 60:348:2], photograph("rocket")[150:258, 250:394])
"""A face with red, orange and black around it, and a light on a dark sky: 108 x 144 pixels each."""


@dataclass(frozen=True)
class Difference:
    """How far two pictures of one shape are apart.

    Attributes:
        mean: in levels of 255.
        within: the share of the samples that are at most LEVELS apart.
    """

    mean: float
    within: float

    @classmethod
    def of(cls, one: np.ndarray, other: np.ndarray) -> Difference:
        """Of two pictures, uint8."""
        levels = distance(one, other)
        return cls(float(levels.mean()), float((levels <= LEVELS).mean()))

    @property
    def small(self) -> bool:
        """Whether the pictures pass for the same."""
        return self.mean <= MEAN and self.within >= SHARE

    def __str__(self) -> str:
        return f"{self.mean:.3f} levels off on average, {self.within:.2%} of the samples at most {LEVELS}"


def distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """How far apart the samples of two pictures are, uint8."""
    return cv2.absdiff(one, other)


def drawn(style: Style) -> np.ndarray:
    """Both pictures in a style, side by side, by the CPU: 108 x 288 x 3 uint8 RGB.

    Lengths are taken as they are written: fitted to so small a picture, most would be below a pixel.
    """
    return np.hstack([restyle_picture(picture, replace(style, height=None)) for picture in PICTURES])


def golden_path(name: str) -> Path:
    """Where the golden of a style is kept."""
    return FOLDER / f"{name}.png"


def golden(name: str) -> np.ndarray | None:
    """What the style drew when its golden was made, RGB; None if it has none."""
    path = golden_path(name)
    return cv2.imread(str(path))[..., ::-1].copy() if path.exists() else None


def write_png(path: Path, picture: np.ndarray) -> Path:
    """Write a picture, RGB."""
    path.write_bytes(encode_picture(picture, ".png"))
    return path


def check(name: str, got: np.ndarray, folder: Path) -> None:
    """Compare what a style draws with its golden.

    Args:
        got: both pictures in the style.
        folder: where pictures of the difference are put if there is one.

    Raises:
        AssertionError: they differ, or there is no golden; it names the pictures.
    """
    kept = golden(name)
    assert kept is not None, f"{name}: has no golden; run tools/renew_goldens.py and look at it"
    found = Difference.of(got, kept)
    if not found.small:
        seen = np.minimum(distance(got, kept), 255 // SHOWN) * SHOWN
        pictures = {"got": got, "golden": kept, "difference": seen}
        paths = [write_png(folder / f"{name}-{what}.png", each) for what, each in pictures.items()]
        listed = "\n  ".join(map(str, paths))
        remedy = "if it is meant, run tools/renew_goldens.py"
        raise AssertionError(f"{name}: {found}; look at these, and {remedy}:\n  {listed}")


def shipped(name: str) -> np.ndarray:
    """What the shipped style of this name draws now."""
    return drawn(load_style(name))
