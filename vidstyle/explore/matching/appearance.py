"""Appearance descriptors independent of content: colours, tones, lines, texture and directions."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from vidstyle.explore.colors import oklab
from vidstyle.explore.measure import gradient_of, luma_of_codes

COMPARED_SIDE_PX = 480
"""Shorter side at which appearances are compared; marks keep their relative size."""
MODEL_FILE = Path(__file__).with_name("appearance.json")
"""Axes that separate styles but vary little within one; fitted by `tools/explore/appearance.py`."""

LUMA_QUANTILES = (0.02, 0.1, 0.25, 0.5, 0.75, 0.9, 0.98)
LINE_RADII_PX = (1, 2, 4, 8)
"""Radii of the structuring elements that extract lines, at `COMPARED_SIDE_PX`."""
DIRECTION_BINS = 12
TEXTURE_BLOCK_PX = 24
"""Side of the squares whose texture is compared."""


def appearance_of(picture: np.ndarray) -> np.ndarray:
    """Return a descriptor that depends on the style of a picture and little on its subject.

    Args:
        picture: H x W x 3 uint8, of any size.
    """
    factor = COMPARED_SIDE_PX / min(picture.shape[:2])
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    size = max(1, round(picture.shape[1] * factor)), max(1, round(picture.shape[0] * factor))
    picture = cv2.resize(picture, size, interpolation=method)
    luma = luma_of_codes(picture)
    return np.concatenate([_colors(picture), _tones(luma), _lines(luma), _texture(luma), _directions(luma)])


def appearance_point(appearance: np.ndarray) -> np.ndarray:
    """Return a point for an appearance; the distance of two points is their `appearance_distance`."""
    axes, usual = _model()
    return np.asarray(axes @ appearance / usual)


def appearance_distance(one: np.ndarray, other: np.ndarray) -> float:
    """Return the distance of two appearances; 1 is usual between different pictures in one style."""
    return float(np.linalg.norm(appearance_point(one) - appearance_point(other)))


def _colors(picture: np.ndarray) -> np.ndarray:
    """Return mean colour and variation of each fifth of the tones, dark to bright, and colour purity."""
    lab = oklab(picture[::3, ::3] / 255.0).reshape(-1, 3)  # not averaged: dots keep their inks
    order = np.argsort(lab[:, 0], kind="stable")
    numbers = []
    for part in np.array_split(lab[order], 5):
        numbers += [*part[:, 1:].mean(0), *part[:, 1:].std(0)]
    chroma = np.hypot(lab[:, 1], lab[:, 2])
    hues = np.exp(1j * np.arctan2(lab[:, 2], lab[:, 1]))
    one_hue = np.abs((hues * chroma).sum()) / max(chroma.sum(), 1e-6)
    darkest, brightest = lab[order[: len(order) // 50 + 1]], lab[order[-(len(order) // 50 + 1) :]]
    return np.array([*numbers, *darkest.mean(0), *brightest.mean(0), chroma.mean(), chroma.std(), one_hue])


def _tones(luma: np.ndarray) -> np.ndarray:
    """Return percentiles of luma, and its concentration in few tones."""
    counts = np.sort(np.histogram(luma, 64, (0, 1))[0])[::-1] / luma.size
    shares = counts[counts > 0]
    entropy = -(shares * np.log(shares)).sum()
    return np.array(
        [*np.quantile(luma, LUMA_QUANTILES), counts[0], counts[:4].sum(), counts[:12].sum(), entropy]
    )


def _lines(luma: np.ndarray) -> np.ndarray:
    """Return the strength of dark and bright lines of several widths, and the steepness of edges."""
    numbers = []
    for radius in LINE_RADII_PX:
        element = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1, 2 * radius + 1))
        for kind in (cv2.MORPH_BLACKHAT, cv2.MORPH_TOPHAT):
            hat = cv2.morphologyEx(luma, kind, element)
            numbers += [float(np.sqrt(hat.mean())), float((hat > 0.25).mean())]
    gradient = gradient_of(luma)
    return np.array([*numbers, *np.percentile(gradient, (50, 80, 95, 99)), (gradient < 0.004).mean()])


def _texture(luma: np.ndarray) -> np.ndarray:
    """Return the strength of each octave of detail, as percentiles over squares."""
    numbers, blurred = [], luma
    for sigma in (0.7, 1.4, 2.8, 5.6, 11.2):
        next_blurred = cv2.GaussianBlur(luma, (0, 0), sigma)
        band = cv2.blur((blurred - next_blurred) ** 2, (TEXTURE_BLOCK_PX, TEXTURE_BLOCK_PX))
        squares = np.sqrt(
            np.maximum(
                band[TEXTURE_BLOCK_PX // 2 :: TEXTURE_BLOCK_PX, TEXTURE_BLOCK_PX // 2 :: TEXTURE_BLOCK_PX], 0
            )
        )
        numbers += [*np.log(0.003 + np.percentile(squares, (20, 50, 90)))]
        blurred = next_blurred
    return np.array(numbers)


def _directions(luma: np.ndarray) -> np.ndarray:
    """Return the distribution of fine edge directions, and their local coherence."""
    fine = luma - cv2.GaussianBlur(luma, (0, 0), 3)
    across, down = (cv2.Sobel(fine, cv2.CV_32F, *order) for order in ((1, 0), (0, 1)))
    angle = np.mod(np.arctan2(down, across), np.pi)
    weight = cv2.magnitude(across, down)
    shares = np.histogram(angle, DIRECTION_BINS, (0, np.pi), weights=weight)[0] / max(
        float(weight.sum()), 1e-6
    )
    squares = (TEXTURE_BLOCK_PX, TEXTURE_BLOCK_PX)
    turned = [cv2.blur(weight * part, squares) for part in (np.cos(2 * angle), np.sin(2 * angle))]
    coherence = np.hypot(*turned) / np.maximum(cv2.blur(weight, squares), 1e-4)
    return np.array([*shares, shares.max(), *np.percentile(coherence, (20, 50, 80))])


@cache
def _model() -> tuple[np.ndarray, float]:
    model = json.loads(MODEL_FILE.read_text(encoding="utf-8"))
    return np.array(model["axes"]), float(model["usual"])
