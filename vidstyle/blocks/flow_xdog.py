"""Flow-guided XDoG: clean connected lines."""

from __future__ import annotations

from typing import Annotated, Any

from vidstyle.block import Block, block
from vidstyle.blocks.flow_dog import flow_dog
from vidstyle.blocks.soft_threshold import soft_threshold

_LINE_PARAMETERS, _INK_PARAMETERS = flow_dog.parameters, soft_threshold.parameters


@block(
    "recipe",
    on="luma",
    label="Ink lines",
    category="lines",
    aliases=(
        "outlines, contour, pen, pencil, sketch, drawing, line art, cartoon, comic, manga, edge "
        "detection, XDoG, coloring book, woodcut, linocut, hand drawn, ballpoint, felt tip, "
        "marker, blueprint"
    ),
)
def flow_xdog(
    sigma: Annotated[float, _LINE_PARAMETERS["sigma"].control] = _LINE_PARAMETERS["sigma"].default,
    p: Annotated[float, _LINE_PARAMETERS["p"].control] = _LINE_PARAMETERS["p"].default,
    phi: Annotated[float, _INK_PARAMETERS["phi"].control] = 0.02,
    epsilon: Annotated[float, _INK_PARAMETERS["epsilon"].control] = 130,
) -> list[tuple[Block, dict[str, Any]]]:
    """Draw the picture in lines that follow its edges.

    Edges become dark lines on white, and dark areas become black.

    flow_dog, then soft_threshold. Paper, section 4.2 C, equation 1.
    """
    ink = {"phi": phi, "epsilon": epsilon, "edges": True}
    return [(flow_dog, {"sigma": sigma, "p": p}), (soft_threshold, ink)]
