"""What a layout costs: the formula of which every page is the optimum."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vidstyle.comic.crop import main_face, what_counts, with_room
from vidstyle.comic.moment import Box, Moment
from vidstyle.comic.slicing import Tree

NARROWEST, WIDEST = 0.45, 3.2
"""Width by height of panels that are no slivers."""

_OWN = 0.8
"""How much the best shape is that of the picture; the rest is that of what counts in it."""
_SPREAD = 0.5
"""A moment that is a deviation more important than another wants an area exp(this) times as large."""
_SLIVER = 4.0
"""Paid once for a sliver, and ten times for the square of how far it is one."""
_SPLASH = 1.6
"""Deviations from the mean from which the most important moment is a splash."""
_SPLASH_SHARE = 0.36
"""The part of a page that a splash wants."""


@dataclass(frozen=True)
class Taste:
    """What counts how much.

    The cost of a layout is the sum, over its panels of width w and height h,

        shape . ln(w/h / best shape)^2  +  salience . (part of the salience that is cut off)
        +  face . (part of the main face, with the room about it, that is cut off)
        +  size . ln(w h / wanted area)^2  +  slivers,

    over its rows, of `templates[tree]`: four side by side, and a stack read before its neighbour, cost
    more; over rows that follow one another on a page,

        monotony . likeness  +  cross . (gutters meet in a cross)  +  ragged . (they miss it by one unit),

    where the likeness of rows with as many columns is 1 if their first cuts are in one place and falls to
    0 (two columns), 1/2 (more) or stays (one) a third of the page's width on; and over page breaks, of
    `scene` where a scene goes on. The wanted area is a share of the paper by importance.

    Attributes:
        jitter: deviations of importance, and the natural logarithms of shapes, that are added for each
            panel; panel x 2, or None.
        whims: what is added to the price of each kind of row, by its number of panels and its place in
            `rows`; empty for none.
    """

    shape: float = 1.0
    salience: float = 2.5
    face: float = 4.0
    size: float = 0.8
    monotony: float = 0.9
    cross: float = 0.5
    ragged: float = 0.4
    scene: float = 0.25
    jitter: np.ndarray | None = None
    whims: dict[Tree, float] = field(default_factory=dict)

    def template(self, tree: Tree) -> float:
        """The price of a kind of row."""
        price = 0.12 * max(0, tree.columns - 2) + self.whims.get(tree, 0.0)
        return price + (0.15 if _stack_first(tree) else 0.0)


def _stack_first(tree: Tree) -> bool:
    """Whether a reader may pass from the head of a stack to its neighbour before its foot is read."""
    if not tree.beside or tree.first is None or tree.rest is None:
        return False
    return tree.first.count > 1 or _stack_first(tree.rest)


def taste(seed: int, count: int, trees: Sequence[Tree]) -> Taste:
    """The taste of a seed: 0 is that of the formula, others are near it, each in its own way."""
    if seed == 0:
        return Taste()
    random = np.random.default_rng(seed)
    jitter = (random.random((count, 2)) - 0.5) * (1.6, 0.5)
    whims = {tree: float(whim) for tree, whim in zip(trees, random.random(len(trees)) * 0.9, strict=True)}
    return replace(Taste(), jitter=jitter, whims=whims, monotony=1.2)


def wanted_areas(moments: Sequence[Moment], paper_area: float, pages: float, taste: Taste) -> np.ndarray:
    """The area that each moment wants, in square pixels, of pages of `paper_area` each.

    A moment that stands out among at least four is a splash, and wants a good part of a page.
    """
    importance = np.array([moment.importance for moment in moments])
    above = (importance - importance.mean()) / max(float(importance.std()), 0.08)
    added = 0.0 if taste.jitter is None else taste.jitter[:, 0]
    weights = np.exp(_SPREAD * np.clip(above + added, -2.0, 2.0))
    areas = weights / weights.sum() * paper_area * pages
    top = int(importance.argmax())
    if len(moments) >= 4 and above[top] >= _SPLASH:
        areas[top] = max(areas[top], _SPLASH_SHARE * paper_area)
    return areas


def panel_costs(
    moments: Sequence[Moment], areas: np.ndarray, widths: np.ndarray, heights: np.ndarray, taste: Taste
) -> np.ndarray:
    """The cost of the panel of each moment in each size.

    Returns:
        Moment x width x height; infinite where a width or a height is the first, which is none.
    """
    aspect, area = widths[:, None] / heights, widths[:, None] * heights
    shapes = np.zeros(len(moments)) if taste.jitter is None else taste.jitter[:, 1]
    costs = np.stack(
        [
            taste.shape * (np.log(aspect) - best_shape(moment) - shape) ** 2
            + taste.size * np.log(area / wanted) ** 2
            + _content_cost(moment, aspect, taste)
            for moment, wanted, shape in zip(moments, areas, shapes, strict=True)
        ]
    )
    over = np.maximum(np.log(aspect / WIDEST), np.log(NARROWEST / aspect))
    costs += np.where(over > 0, _SLIVER + 10 * over**2, 0.0)
    costs[:, 0], costs[:, :, 0] = np.inf, np.inf
    return costs


def best_shape(moment: Moment) -> float:
    """The natural logarithm of the aspect that suits a moment."""
    height, width = moment.shape
    kept = what_counts(moment)
    own = math.log(width / height)
    inner = math.log(max(kept.width, 1.0) / max(kept.height, 1.0))
    return _OWN * own + (1 - _OWN) * min(own + 1.5, max(own - 1.5, inner))


def _content_cost(moment: Moment, aspect: np.ndarray, taste: Taste) -> np.ndarray:
    """What a window of an aspect cannot hold."""
    height, width = moment.shape
    across = np.minimum(width, height * aspect)
    down = across / aspect

    def lost(box: Box) -> np.ndarray:
        shown = np.minimum(1, across / max(box.width, 1.0)) * np.minimum(1, down / max(box.height, 1.0))
        return 1 - shown

    cost = taste.salience * lost(moment.salience)
    face = main_face(moment)
    return cost if face is None else cost + taste.face * lost(with_room(moment, face))


def row_costs(columns: int, units: int, taste: Taste) -> np.ndarray:
    """What a row costs because of the one before it, by their kinds.

    A kind is 0 for one panel over the whole width, then all first cuts of rows of two columns, of three
    and so on: see `kind_of`.

    Args:
        columns: the most that a row has.
        units: across the page.

    Returns:
        Kind of the row before x kind.
    """
    kinds = np.arange(kind_of(columns, units - 1, units) + 1)
    number = np.where(kinds == 0, 1, 2 + (kinds - 1) // (units - 1))
    cut = np.where(kinds == 0, 0, 1 + (kinds - 1) % (units - 1))
    apart = np.abs(cut[:, None] - cut)
    near = 1 - np.minimum(1, apart * 3 / units)
    likeness = np.where(number == 2, near, np.where(number > 2, (1 + near) / 2, 1.0))
    cost = taste.monotony * np.where(number[:, None] == number, likeness, 0.0)
    both = (number[:, None] > 1) & (number > 1)
    return cost + both * (taste.cross * (apart == 0) + taste.ragged * (apart == 1))


def kind_of(columns: int, cut: int, units: int) -> int:
    """The number of the kind of a row, from its columns and its first cut."""
    return 0 if columns == 1 else (columns - 2) * (units - 1) + cut
