"""The weights of the cost that page layouts minimize, and their variations by seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vidstyle.comic.layout.slicing import Tree

_MAX_PERTURBATION_COST = 4.0
"""Maximum that a seed adds to the cost of a row; the mean is a third of it."""
_JITTER_RANGES = np.array([1.6, 0.4])
"""Range of random terms added to deviations of importance and to logarithms of shapes."""


@dataclass(frozen=True)
class LayoutWeights:
    """Weights of the terms of the cost.

    The cost of a layout is the sum, over its panels of width w and height h,

        shape . ln(w/h / best shape)^2  +  saliency . (part cut off the box around salient area and faces)
        +  face . (part of the large faces, with the room around them, that is cut off; more if any is)
        +  (much cut off the picture)  +  small . ln(face / printed height of the main face)^2, if smaller
        +  size . ln(w h / wanted area)^2  +  oversize . (the same, if larger and unimportant)  +  slivers,

    over its rows, of `template(tree)`: many columns, and a stack before its neighbour, cost more;
    over successive rows on a page,

        monotony . similarity  +  full . similarity of rows of one panel
        +  cross . (gutters meet in a cross)  +  ragged . (they miss it by one unit),

    where the similarity of rows with equal numbers of columns is 1 if their first cuts are in one place and
    falls to 1/2 over a third of the page's width, and the similarity of rows of one panel is 1 for equal
    heights and falls to 1/2; over page breaks, of `scene` if the scene continues; and over pages,

        balance . (distance of the centre of the dark areas from the page's centre, in sides of the page).

    The wanted area is a share of the paper by importance; for a splash `size` is larger.

    Attributes:
        face_px: wanted minimum height of a printed face, in pixels; 0 if any is accepted.
        jitter: added to each panel's deviation of importance and to the logarithm of its best shape;
            panel x 2, or None.
        perturbation: added to the cost of a template for each possible first panel; 0 for templates that are
            not listed.
    """

    shape: float = 1.0
    saliency: float = 4.0
    face: float = 4.0
    size: float = 1.0
    oversize: float = 3.0
    monotony: float = 0.9
    full: float = 1.9
    cross: float = 0.5
    ragged: float = 0.4
    scene: float = 0.6
    balance: float = 6.0
    small: float = 2.0
    face_px: float = 0.0
    jitter: np.ndarray | None = None
    perturbation: dict[Tree, np.ndarray] = field(default_factory=dict)

    def template(self, tree: Tree, count: int) -> np.ndarray:
        """Return the cost of a template of rows for each of the `count` panels that it may begin with."""
        cost = 0.12 * max(0, tree.columns - 2) + (0.15 if _has_early_stack(tree) else 0.0)
        return cost + (self.perturbation[tree][:count] if tree in self.perturbation else np.zeros(count))


def _has_early_stack(tree: Tree) -> bool:
    """Whether a stack comes before a neighbour, which may be read before the end of the stack."""
    if not tree.side_by_side or tree.first is None or tree.rest is None:
        return False
    return tree.first.count > 1 or _has_early_stack(tree.rest)


def perturb_weights(seed: int, attempt: int, count: int, trees: Sequence[Tree]) -> LayoutWeights:
    """Return the weights of a seed for `count` panels, unperturbed for seed 0.

    Args:
        seed: random seed.
        attempt: number of the attempt; later ones are perturbed less.
        count: number of panels.
        trees: all templates of rows.
    """
    if seed == 0:
        return LayoutWeights()
    random = np.random.default_rng((seed, attempt))
    jitter = (random.random((count, 2)) - 0.5) * _JITTER_RANGES / (1 + attempt)
    perturbation = {tree: _MAX_PERTURBATION_COST * random.random(count) ** 2 for tree in trees}
    return LayoutWeights(jitter=jitter, perturbation=perturbation)
