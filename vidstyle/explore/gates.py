"""What no candidate may be: blank, muddy, blown, lost, flickering, or like another one.

The limits lie just outside what shipped styles make of ten photographs of people, animals,
streets, landscapes and a shop at night.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.explore.measure import Original, PictureMetrics
from vidstyle.explore.random_steps import is_valid, with_layers, without_idle_steps
from vidstyle.gallery.style_samples import restyled
from vidstyle.style import LAYERS, Style


@dataclass(frozen=True)
class Gate:
    """The limits of a measure, and what a picture outside them is."""

    measure: str
    low: float
    high: float
    reason: str


GATES = (
    Gate("paper", 0, 0.80, "blank"),
    Gate("ink", 0, 0.70, "black"),
    Gate("range", 0.40, 1, "muddy"),
    Gate("contrast", 0.045, 1, "muddy"),
    Gate("sharp", 0.105, 1, "blurred"),
    Gate("crisp", 0.075, 1, "blurred"),
    Gate("clutter", 0, 0.17, "cluttered"),
    Gate("noise", 0, 0.165, "cluttered"),
    Gate("tone", -0.30, 1, "a negative"),
    Gate("edges", 0.45, 1, "without the subject"),
    Gate("garish", 0, 0.47, "garish"),
    Gate("change", 0.028, 9, "like the source"),
    Gate("photo", -1, 0.9, "like the source"),
)
"""In the order in which they are tried; the first that fails is the reason."""

MAX_UNSTEADY = 2.5
"""The most that a style may amplify the grain of a film; `ink` has 2.15."""
MIN_DISTANCE = 0.5
"""Pictures whose signatures are nearer look alike."""
MIN_STEP_DIFFERENCE = 1.0
"""A step counts that changes the picture by so many levels of 255, on at least one sample in a hundred."""

UNSTEADY_FAULT, DUPLICATE_FAULT, NO_FAULT = "flickering", "like another", ""


def fault(measures: PictureMetrics) -> str:
    """Why a picture is thrown out, in a word or two; empty if it passes."""
    for gate in GATES:
        if not gate.low <= getattr(measures, gate.measure) <= gate.high:
            return gate.reason
    return NO_FAULT


def is_like_another(signature: np.ndarray, others: Sequence[np.ndarray]) -> bool:
    """Whether a picture looks like one of others, by their signatures."""
    return any(float(np.linalg.norm(signature - other)) < MIN_DISTANCE for other in others)


def pruned(style: Style, original: Original, picture: np.ndarray) -> Style:
    """The style without steps that change nothing, neither in the small picture nor in the large one.

    Args:
        picture: the original in the style.
    """
    for layer in LAYERS:
        for place in reversed(range(len(style.layers[layer]))):
            shorter = _without(style, layer, place)
            if shorter is None or not _is_same(original.render(shorter), picture):
                continue
            # Lengths of a pixel or two come to nothing in a small picture.
            if _is_same(restyled(original.large, shorter), restyled(original.large, style)):
                style = shorter
    return style


def _without(style: Style, layer: str, place: int) -> Style | None:
    """The style without a step; None where others need it."""
    steps = style.layers[layer]
    if place >= len(steps) or steps[place].save or steps[place].source or steps[place].block == "scale":
        return None
    shorter = without_idle_steps(with_layers(style, {layer: steps[:place] + steps[place + 1 :]}))
    return shorter if is_valid(shorter) else None


def _is_same(one: np.ndarray, other: np.ndarray) -> bool:
    difference = np.abs(one.astype(np.int16) - other)
    return float(np.percentile(difference, 99)) < MIN_STEP_DIFFERENCE
