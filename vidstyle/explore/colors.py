"""Random palettes of ink and paper in Oklch, a perceptual space of lightness, chroma and hue."""

from __future__ import annotations

import math
from random import Random

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.core.picture import BT709_WEIGHTS
from vidstyle.style import Style

MIN_CONTRAST = 3.0
"""Minimum contrast ratio of ink to paper, as required by WCAG 2 (1.4.11) for graphics."""

# Björn Ottosson, "A perceptual color space for image processing", 2020.
_RGB_TO_LMS_MATRIX = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929],
     [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
_LMS_TO_LAB_MATRIX = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468],
     [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip

HARMONY_DEGREES = (0.0, 0.0, 30.0, -30.0, 150.0, 180.0, 210.0, 120.0, -120.0)
"""Angles between the hues of ink and paper: same, analogous, (split) complementary, triadic."""

TONE_TURN_DEGREES = (0.0, 40.0, -40.0, 90.0, -90.0, 150.0)
"""Angles between the hues of the darkest and the brightest tone."""


def palette(random: Random, like: Style | None = None) -> tuple[str, str]:
    """Return ink and paper, as "#rrggbb", with readable contrast.

    Args:
        random: the random generator.
        like: a style whose ink and paper define which one is lighter. If both are light, as in `crayon`, the
            ink covers the paper between marks and is drawn on the picture itself.
    """
    hue = random.uniform(0, 360)
    other = hue + random.choice(HARMONY_DEGREES) + random.gauss(0, 8)
    if like is not None and is_pale(like.ink):
        ink = oklch(random.uniform(0.93, 0.99), random.uniform(0, 0.04), other)
        if is_pale(like.paper):
            return ink, "#ffffff"
        paper = oklch(random.uniform(0.42, 0.62), random.uniform(0.06, 0.16), hue)
        return ensure_contrast(ink, paper)
    paper = oklch(random.uniform(0.93, 0.99), random.uniform(0.004, 0.05), other)
    vivid = random.random() < 0.3
    lightness = random.uniform(0.42, 0.6) if vivid else random.uniform(0.15, 0.4)
    chroma = random.uniform(0.1, 0.2) if vivid else random.uniform(0.0, 0.11)
    return ensure_contrast(oklch(lightness, chroma, hue), paper)


def tone_colors(random: Random) -> list[str]:
    """Return five colours for tones from black to white, with rising lightness and one or two hues."""
    hue = random.uniform(0, 360)
    turn = random.choice(TONE_TURN_DEGREES) + random.gauss(0, 8)
    chroma = random.uniform(0.02, 0.09 if abs(turn) < 60 else 0.12)
    dark, bright = random.uniform(0.14, 0.28), random.uniform(0.95, 0.99)
    return [
        oklch(dark + (bright - dark) * share, chroma * strength, hue + turn * share)
        for share, strength in zip((0.0, 0.28, 0.54, 0.78, 1.0), (0.5, 0.9, 1.0, 0.7, 0.15), strict=True)
    ]


def is_pale(color: str) -> bool:
    """Whether a colour is light, such as paper or chalk."""
    return to_oklch(color)[0] > 0.8


def ensure_contrast(ink: str, paper: str) -> tuple[str, str]:
    """Darken the darker of ink and paper until the contrast is `MIN_CONTRAST`."""
    while contrast(ink, paper) < MIN_CONTRAST:
        if _luminance(ink) < _luminance(paper):
            ink = shift_color(ink, -0.03)
        else:
            paper = shift_color(paper, -0.03)
        if max(to_oklch(ink)[0], to_oklch(paper)[0]) < 0.6:  # both dark: darkening does not help
            ink, paper = "#000000", "#ffffff"
    return ink, paper


def shift_color(color: str, lightness: float = 0.0, chroma: float = 0.0, hue: float = 0.0) -> str:
    """Change the Oklch lightness (0..1), chroma (0 to about 0.3) and hue (degrees) of a colour."""
    now = to_oklch(color)
    return oklch(min(max(now[0] + lightness, 0.0), 1.0), min(max(now[1] + chroma, 0.0), 0.37), now[2] + hue)


def oklch(lightness: float, chroma: float, hue: float) -> str:
    """Return the colour as "#rrggbb"; reduce chroma until it fits sRGB."""
    turn = math.radians(hue)
    while True:
        lab = np.array([lightness, chroma * math.cos(turn), chroma * math.sin(turn)])
        linear = np.linalg.solve(_RGB_TO_LMS_MATRIX, np.linalg.solve(_LMS_TO_LAB_MATRIX, lab) ** 3)
        if chroma == 0 or (linear.min() > -1e-4 and linear.max() < 1 + 1e-4):
            break
        chroma = max(chroma - 0.005, 0.0)
    linear = np.clip(linear, 0, 1)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return "#" + "".join(f"{round(255 * float(value)):02x}" for value in coded)


def to_oklch(color: str) -> tuple[float, float, float]:
    """Return Oklch lightness, chroma and hue of "#rrggbb".

    >>> [round(value, 2) for value in to_oklch("#ff0000")]
    [0.63, 0.26, 29.23]
    """
    lightness, a, b = oklab(np.array(rgb_from_text(color)))
    return float(lightness), math.hypot(a, b), math.degrees(math.atan2(b, a)) % 360


def oklab(rgb: np.ndarray) -> np.ndarray:
    """Convert gamma-encoded RGB 0..1 along the last axis to Oklab."""
    return np.cbrt(_linear(rgb) @ _RGB_TO_LMS_MATRIX.T) @ _LMS_TO_LAB_MATRIX.T


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours, 1 to 21 (WCAG 2).

    >>> round(contrast("#000000", "#ffffff"))
    21
    """
    dark, bright = sorted((_luminance(one), _luminance(other)))
    return (bright + 0.05) / (dark + 0.05)


def _luminance(color: str) -> float:
    return float(_linear(np.array(rgb_from_text(color))) @ BT709_WEIGHTS)


def _linear(rgb: np.ndarray) -> np.ndarray:
    return np.asarray(np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4))
