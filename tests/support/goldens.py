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

MAX_MEAN_LEVELS, MAX_SAMPLE_LEVELS, MIN_SHARE = 0.1, 3, 0.999
"""Maximum mean difference in levels of 255, and maximum difference of this share of the samples.

Versions of OpenCV and Numba and processors differ in the last bits, which may select another learned filter
or push a sample over a steep threshold. A software GPU with 16 bits between its passes differs more, but
stays within 0.02 levels and 99.98 %; a slight change of one value in each style exceeded the limits."""

DRAWN_DIFFERENCE_FACTOR = 16
"""Gain of drawn differences."""

PICTURES = (photograph("astronaut")[60:276:2, 60:348:2], photograph("rocket")[150:258, 250:394])
"""A face with red, orange and black around it, and a light on a dark sky: 108 x 144 pixels each."""


@dataclass(frozen=True)
class Difference:
    """The difference of two pictures of the same shape.

    Attributes:
        mean: mean difference in levels of 255.
        within: share of the samples that differ by at most `MAX_SAMPLE_LEVELS`.
    """

    mean: float
    within: float

    @classmethod
    def of(cls, one: np.ndarray, other: np.ndarray) -> Difference:
        """Compare two pictures, uint8."""
        levels = distance(one, other)
        return cls(float(levels.mean()), float((levels <= MAX_SAMPLE_LEVELS).mean()))

    @property
    def small(self) -> bool:
        """Whether the difference is within the tolerance."""
        return self.mean <= MAX_MEAN_LEVELS and self.within >= MIN_SHARE

    def __str__(self) -> str:
        share = f"{self.within:.2%} of the samples at most {MAX_SAMPLE_LEVELS}"
        return f"{self.mean:.3f} levels off on average, {share}"


def distance(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the absolute difference of two pictures, uint8."""
    return cv2.absdiff(one, other)


def drawn(style: Style) -> np.ndarray:
    """Restyle both pictures on the CPU, and return them side by side, 108 x 288 x 3 uint8 RGB.

    Lengths are not scaled to the picture: most would be below a pixel.
    """
    return np.hstack([restyle_picture(picture, replace(style, height=None)) for picture in PICTURES])


def golden_path(name: str) -> Path:
    """Return the path of the golden picture of a style."""
    return FOLDER / f"{name}.png"


def golden(name: str) -> np.ndarray | None:
    """Return the golden picture of a style, RGB, or None."""
    path = golden_path(name)
    return cv2.imread(str(path))[..., ::-1].copy() if path.exists() else None


def write_png(path: Path, picture: np.ndarray) -> Path:
    """Write a picture, RGB."""
    path.write_bytes(encode_picture(picture, ".png"))
    return path


def check(name: str, got: np.ndarray, folder: Path) -> None:
    """Compare the result of a style with its golden picture.

    Args:
        got: both pictures in the style.
        folder: folder for pictures of the difference.

    Raises:
        AssertionError: the pictures differ, or there is no golden picture; it names the files.
    """
    kept = golden(name)
    assert kept is not None, f"{name}: has no golden; run tools/renew_goldens.py and look at it"
    found = Difference.of(got, kept)
    if not found.small:
        seen = np.minimum(distance(got, kept), 255 // DRAWN_DIFFERENCE_FACTOR) * DRAWN_DIFFERENCE_FACTOR
        pictures = {"got": got, "golden": kept, "difference": seen}
        paths = [write_png(folder / f"{name}-{what}.png", each) for what, each in pictures.items()]
        listed = "\n  ".join(map(str, paths))
        remedy = "if it is meant, run tools/renew_goldens.py"
        raise AssertionError(f"{name}: {found}; look at these, and {remedy}:\n  {listed}")


def shipped(name: str) -> np.ndarray:
    """Return the current result of a shipped style."""
    return drawn(load_style(name))
