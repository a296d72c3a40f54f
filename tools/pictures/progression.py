"""Render the picture after each step of a style."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.style import LAYERS, Step, Style

_END_OF_BASE = "end of base"
"""The name under which the end of the base layer is saved; styles cannot use names with spaces."""


@dataclass(frozen=True)
class Stage:
    """The picture after one step, H x W x 3 uint8.

    Attributes:
        layer: the layer of the step; empty for the source and the result.
        name: the step's block, "source" or "result".
    """

    layer: str
    name: str
    picture: np.ndarray


def render_progression(picture: np.ndarray, style: Style) -> Iterator[Stage]:
    """Yield the source, the picture after each step that has a block, and the result.

    Args:
        picture: H x W x 3 uint8.
        style: its layers are rendered in order; the lines layer is shown without ink.
    """
    yield Stage("", "source", picture)
    previous: tuple[Step, ...] = ()
    for layer in LAYERS:
        steps = getattr(style, layer)
        for number, step in enumerate(steps, 1):
            if step.block:
                so_far = Style(
                    style.name, height=style.height, base=previous + steps[:number], folder=style.folder
                )
                yield Stage(layer, step.block, restyle_picture(picture, so_far))
        # Each layer continues from the end of the base, and can use pictures saved before.
        previous += (
            *steps,
            Step("", save=_END_OF_BASE) if layer == "base" else Step("", source=_END_OF_BASE),
        )
    yield Stage("", "result", restyle_picture(picture, style))
