"""Pairs of ink and paper that go together, drawn in Oklch: lightness, chroma and hue as eyes see them."""

from __future__ import annotations

import colorsys
import math
from dataclasses import dataclass
from random import Random

import numpy as np

from vidstyle.block import rgb_from_text
from vidstyle.style import Style

MIN_CONTRAST = 3.0
"""The least contrast of ink to paper: what WCAG 2 (1.4.11) asks of graphics."""

MAX_GLARE = 0.11
"""The largest product of lightness and chroma, in Oklch, of a tint; that of poster's orange is 0.13."""

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
"""Degrees between the hues of ink and paper: same, analogous, complementary and its neighbours, triads."""


@dataclass(frozen=True)
class Palette:
    """Colours as "#rrggbb", and the hue of a tint that goes with them, in degrees of HSL."""

    ink: str
    paper: str
    tint: float


def palette(random: Random, like: Style | None = None) -> Palette:
    """Ink and paper of readable contrast.

    Args:
        random: what draws.
        like: a style whose ink and paper say which is the lighter one. Where both are light, the ink covers
            what is left of the paper between marks, as in `crayon`, and stands on the picture itself.
    """
    hue = random.uniform(0, 360)
    other = hue + random.choice(HARMONY_DEGREES) + random.gauss(0, 8)
    tint = hsl_hue(oklch(0.6, 0.12, hue))
    if like is not None and is_pale(like.ink):
        ink = oklch(random.uniform(0.93, 0.99), random.uniform(0, 0.04), other)
        if is_pale(like.paper):
            return Palette(ink, "#ffffff", tint)
        paper = oklch(random.uniform(0.42, 0.62), random.uniform(0.06, 0.16), hue)
        return Palette(*readable(ink, paper), tint)
    paper = oklch(random.uniform(0.93, 0.99), random.uniform(0.004, 0.05), other)
    vivid = random.random() < 0.3
    lightness = random.uniform(0.42, 0.6) if vivid else random.uniform(0.15, 0.4)
    chroma = random.uniform(0.1, 0.2) if vivid else random.uniform(0.0, 0.11)
    return Palette(*readable(oklch(lightness, chroma, hue), paper), tint)


def calm_saturation(hue: float) -> float:
    """The largest saturation of HSL at which a tint of this hue, in degrees, does not glare.

    Yellow, cyan and magenta are both bright and pure at a lightness of half, unlike red and blue.
    """
    for percent in range(95, 30, -5):
        rgb = colorsys.hls_to_rgb(hue % 360 / 360, 0.5, percent / 100)
        lightness, a, b = oklab(np.array(rgb))
        if lightness * math.hypot(a, b) <= MAX_GLARE:
            break
    return percent / 100


def is_pale(color: str) -> bool:
    """Whether a colour is that of paper or chalk."""
    return to_oklch(color)[0] > 0.8


def readable(ink: str, paper: str) -> tuple[str, str]:
    """Ink and paper, the darker of them darkened until the contrast is `MIN_CONTRAST`."""
    while contrast(ink, paper) < MIN_CONTRAST:
        if _luminance(ink) < _luminance(paper):
            ink = shifted(ink, -0.03)
        else:
            paper = shifted(paper, -0.03)
        if max(to_oklch(ink)[0], to_oklch(paper)[0]) < 0.6:  # both dark: no darkening helps
            ink, paper = "#000000", "#ffffff"
    return ink, paper


def shifted(color: str, lightness: float = 0.0, chroma: float = 0.0, hue: float = 0.0) -> str:
    """A colour with its lightness and chroma, 0..1 and 0..0.3 or so, and its hue in degrees changed."""
    now = to_oklch(color)
    return oklch(min(max(now[0] + lightness, 0.0), 1.0), min(max(now[1] + chroma, 0.0), 0.37), now[2] + hue)


def oklch(lightness: float, chroma: float, hue: float) -> str:
    """The colour "#rrggbb"; one that no screen can show loses chroma until it can."""
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
    """Lightness, chroma and hue of the colour "#rrggbb".

    >>> [round(value, 2) for value in to_oklch("#ff0000")]
    [0.63, 0.26, 29.23]
    """
    lightness, a, b = oklab(np.array(rgb_from_text(color)))
    return float(lightness), math.hypot(a, b), math.degrees(math.atan2(b, a)) % 360


def oklab(rgb: np.ndarray) -> np.ndarray:
    """Oklab of gamma-encoded RGB 0..1 along the last axis."""
    return np.cbrt(_linear(rgb) @ _RGB_TO_LMS_MATRIX.T) @ _LMS_TO_LAB_MATRIX.T


def contrast(one: str, other: str) -> float:
    """The contrast ratio of two colours, 1 to 21 (WCAG 2).

    >>> round(contrast("#000000", "#ffffff"))
    21
    """
    dark, bright = sorted((_luminance(one), _luminance(other)))
    return (bright + 0.05) / (dark + 0.05)


def hsl_hue(color: str) -> float:
    """The hue of a colour in HSL, in degrees."""
    red, green, blue = rgb_from_text(color)
    span = max(red, green, blue) - min(red, green, blue)
    if span == 0:
        return 0.0
    if max(red, green, blue) == red:
        return 60 * ((green - blue) / span % 6)
    if max(red, green, blue) == green:
        return 60 * ((blue - red) / span + 2)
    return 60 * ((red - green) / span + 4)


def _luminance(color: str) -> float:
    return float(_linear(np.array(rgb_from_text(color))) @ (0.2126, 0.7152, 0.0722))


def _linear(rgb: np.ndarray) -> np.ndarray:
    return np.asarray(np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4))
