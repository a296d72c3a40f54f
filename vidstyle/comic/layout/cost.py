"""The cost function that page layouts minimize."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vidstyle.comic.layout.crop import main_face, must_show, what_counts
from vidstyle.comic.layout.slicing import Tree
from vidstyle.comic.moment import Box, Moment

NARROWEST, WIDEST = 0.45, 3.2
"""Range of the aspect ratio (width / height) of panels; others are slivers."""

_WHOLE = 1.02
"""Safety factor on these limits, as sides are rounded to whole pixels later."""
_OWN = 0.8
"""Weight of the picture's own shape in the best shape; the rest is the shape of its main content."""
_OWN_NEAR = 0.25
"""The same for a face that is shown from near."""
_EVEN = 0.08
"""Minimum standard deviation of importance assumed."""
_SPREAD = 0.5
"""Logarithm of the factor on the wanted area per standard deviation of importance."""
_SLIVER = 4.0
"""Cost of a sliver; ten times the square of its excess is added."""
_PERTURBATION = 2.2
"""Maximum that a seed adds to the cost of a row; a third of it on average."""
_JITTER = np.array([1.0, 0.3])
"""Range of what a seed adds to deviations of importance and to logarithms of shapes."""
_UNSEEN, _CROPPED = 0.5, 3.0
"""Difference of the logarithms of the aspects of a panel and its picture up to which little of it is cut off,
and weight of the square of its excess."""
_WORSE, _ROUNDED = 3.0, 0.02
"""Cost of a panel in which large faces must be cut or left out, and the share of them that is none."""
_SPLASH = 1.6
"""Standard deviations above the mean from which the most important moment is a splash."""
_ALONE = 0.4
"""Standard deviations above the next moment that it needs as well."""
_SPLASH_SHARE = 0.36
"""Share of a page that a splash wants."""
_SPLASH_SIZE = 3.0
"""Factor on the weight of its size."""


@dataclass(frozen=True)
class LayoutWeights:
    """Weights of the terms of the cost.

    The cost of a layout is the sum, over its panels of width w and height h,

        shape . ln(w/h / best shape)^2  +  saliency . (part cut off the box around salient area and faces)
        +  face . (part of the large faces, with the room about them, that is cut off; more if any is)
        +  (much cut off the picture)
        +  size . ln(w h / wanted area)^2  +  slivers,

    over its rows, of `template(tree)`: many columns, and a stack before its neighbour, cost more;
    over successive rows on a page,

        monotony . similarity  +  full . similarity of rows of one panel
        +  cross . (gutters meet in a cross)  +  ragged . (they miss it by one unit),

    where the similarity of rows with as many columns is 1 if their first cuts are in one place and falls to
    1/2 a third of the page's width on, and that of rows of one panel is 1 if they are as high and falls to
    1/2; over page breaks, of `scene` where a scene goes on; and over pages,

        balance . (distance of the middle of what is dark from the page's middle, in sides of the page).

    The wanted area is a share of the paper by importance; for a splash `size` is larger.

    Attributes:
        jitter: added to each panel's deviation of importance and to the natural logarithm of its best shape;
            panel x 2, or None.
        perturbation: added to the cost of a template for each panel that it may begin with; 0 for templates
            that are not listed.
    """

    shape: float = 1.0
    saliency: float = 4.0
    face: float = 4.0
    size: float = 1.0
    monotony: float = 0.9
    full: float = 1.9
    cross: float = 0.5
    ragged: float = 0.4
    scene: float = 0.6
    balance: float = 6.0
    jitter: np.ndarray | None = None
    perturbation: dict[Tree, np.ndarray] = field(default_factory=dict)

    def template(self, tree: Tree, count: int) -> np.ndarray:
        """The cost of a template of rows for each of the first `count` panels that it may begin with."""
        cost = 0.12 * max(0, tree.columns - 2) + (0.15 if _stack_first(tree) else 0.0)
        return cost + (self.perturbation[tree][:count] if tree in self.perturbation else np.zeros(count))


def _stack_first(tree: Tree) -> bool:
    """Whether a stack stands before a neighbour, which may be read before the stack's end."""
    if not tree.beside or tree.first is None or tree.rest is None:
        return False
    return tree.first.count > 1 or _stack_first(tree.rest)


def perturbed_weights(seed: int, attempt: int, count: int, trees: Sequence[Tree]) -> LayoutWeights:
    """The weights of a seed for `count` panels, unperturbed for seed 0.

    Args:
        attempt: its number; later ones are perturbed less.
        trees: all templates of rows.
    """
    if seed == 0:
        return LayoutWeights()
    random = np.random.default_rng((seed, attempt))
    jitter = (random.random((count, 2)) - 0.5) * _JITTER / (1 + attempt)
    perturbation = {tree: _PERTURBATION * random.random(count) ** 2 for tree in trees}
    return LayoutWeights(jitter=jitter, perturbation=perturbation)


def wanted_areas(
    moments: Sequence[Moment], paper_area: float, pages: float, weights: LayoutWeights
) -> np.ndarray:
    """The wanted area of each moment in square pixels, on pages of `paper_area` each.

    A moment that stands out among at least four is a splash and wants a large share of a page.
    """
    above = deviations(moments)
    added = 0.0 if weights.jitter is None else weights.jitter[:, 0]
    shares = np.exp(_SPREAD * np.clip(above + added, -2.0, 2.0))
    areas = shares / shares.sum() * paper_area * pages
    top = splash(moments)
    if top is not None:
        areas[top] = max(areas[top], _SPLASH_SHARE * paper_area)
    return areas


def deviations(moments: Sequence[Moment]) -> np.ndarray:
    """Each moment's importance above the mean, in standard deviations."""
    importance = np.array([moment.importance for moment in moments])
    return (importance - importance.mean()) / max(float(importance.std()), _EVEN)


def splash(moments: Sequence[Moment]) -> int | None:
    """The index of the moment that stands out among at least four, or None."""
    above = deviations(moments)
    top = int(above.argmax())
    if len(moments) < 4 or above[top] < max(_SPLASH, np.delete(above, top).max() + _ALONE):
        return None
    return top


def panel_costs(
    moments: Sequence[Moment],
    areas: np.ndarray,
    widths: np.ndarray,
    heights: np.ndarray,
    weights: LayoutWeights,
) -> np.ndarray:
    """The cost of the panel of each moment in each size.

    Returns:
        Moment x width x height; infinite for the first width and the first height, which are 0.
    """
    aspect, area = widths[:, None] / heights, widths[:, None] * heights
    shapes = np.zeros(len(moments)) if weights.jitter is None else weights.jitter[:, 1]
    size = np.full(len(moments), weights.size)
    top = splash(moments)
    if top is not None:
        size[top] *= _SPLASH_SIZE
    costs = np.stack(
        [
            weights.shape * (np.log(aspect) - best_shape(moment) - shape) ** 2
            + counts * np.log(area / wanted) ** 2
            + _content_cost(moment, aspect, weights)
            for moment, wanted, counts, shape in zip(moments, areas, size, shapes, strict=True)
        ]
    )
    over = np.maximum(np.log(aspect * _WHOLE / WIDEST), np.log(NARROWEST * _WHOLE / aspect))
    costs += np.where(over > 0, _SLIVER + 10 * over**2, 0.0)
    costs[:, 0], costs[:, :, 0] = np.inf, np.inf
    return costs


def best_shape(moment: Moment) -> float:
    """The natural logarithm of the best aspect ratio for a moment."""
    height, width = moment.shape
    kept = what_counts(moment)
    own = math.log(width / height)
    inner = math.log(max(kept.width, 1.0) / max(kept.height, 1.0))
    share = _OWN_NEAR if moment.framing == "near" and moment.faces else _OWN
    return share * own + (1 - share) * min(own + 1.5, max(own - 1.5, inner))


def _content_cost(moment: Moment, aspect: np.ndarray, weights: LayoutWeights) -> np.ndarray:
    """The cost of what a window of an aspect cannot contain."""
    height, width = moment.shape
    across = np.minimum(width, height * aspect)
    down = across / aspect

    def lost(box: Box) -> np.ndarray:
        shown = np.minimum(1, across / max(box.width, 1.0)) * np.minimum(1, down / max(box.height, 1.0))
        return 1 - shown

    kept = must_show(moment)
    cropped = np.maximum(0, np.abs(np.log(aspect * height / width)) - _UNSEEN) ** 2
    cost = _CROPPED * cropped * (moment.framing != "near") + weights.saliency * lost(
        moment.saliency.union(kept)
    )
    if main_face(moment) is None:
        return cost
    return cost + weights.face * lost(kept) + _WORSE * (lost(kept) > _ROUNDED)
