"""Pages that few or small pictures do not fill: panels are not enlarged beyond what suits them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import Paper
from vidstyle.regions.boxes import Rectangle

MIN_SOURCE_DPI = 60
"""Minimum number of pixels of the film per inch of paper: a film of 320 x 240 gets panels of 135 mm."""
_MAX_SINGLE_PANELS = 2
"""With at most this many panels, each has the width of the page and the shape of its picture."""
_ASPECT_RANGE = 0.7, 2.4
"""Range of the aspect of such a panel."""
_MIN_SIDE_RATIO = 0.25
"""Minimum width and height of the used part, relative to the page's."""
_FULL_PAGE_SHARE = 0.93
"""Share of the page from which it counts as full."""


def fit_paper(paper: Paper, key_frames: Sequence[KeyFrame], area_scales: Sequence[float]) -> Paper:
    """Return the part of a page that its pictures fill, as a paper with the same margins.

    Args:
        paper: of the only page; a strip is returned unchanged.
        key_frames: the pictures.
        area_scales: factor on the area of each panel, for its text.
    """
    if paper.is_strip:
        return paper
    whole = paper.inside
    widths = [min(whole.width, each.shape[1] * paper.dpi / MIN_SOURCE_DPI) for each in key_frames]
    few = len(key_frames) <= _MAX_SINGLE_PANELS
    width = min(whole.width, max(widths)) if few else whole.width
    areas = [
        _panel_area(each, limit, scale)
        for each, limit, scale in zip(key_frames, widths, area_scales, strict=True)
    ]
    gutters = paper.row_gutter * (len(key_frames) - 1) if few else 0
    height = sum(areas) / width + gutters
    if (not few and min(widths) >= whole.width) or height * width >= _FULL_PAGE_SHARE * whole.area:
        return paper
    width, height = (
        round(max(_MIN_SIDE_RATIO * most, min(most, side)))
        for side, most in ((width, whole.width), (height, whole.height))
    )
    return replace(paper, width=width + 2 * paper.margin, height=height + 2 * paper.margin)


def _panel_area(key_frame: KeyFrame, width: float, scale: float) -> float:
    """Return the largest area of a panel in square pixels, if it may have this width."""
    height, wide = key_frame.shape
    return width * width / min(_ASPECT_RANGE[1], max(_ASPECT_RANGE[0], wide / height)) * scale


def place_panels(
    layout: PageLayout, fitted: Paper, paper: Paper, trims_width: bool = False, trims_height: bool = False
) -> PageLayout:
    """Return the layout of a part of a page in the middle of the page.

    `trims_width`, `trims_height`: whether the page has only the width or height of its panels.
    """
    if fitted == paper:
        return layout
    width = fitted.width if trims_width else paper.width
    height = fitted.height if trims_height else paper.height
    across, down = (width - fitted.width) // 2, (height - fitted.height) // 2
    panels = tuple(_moved(each, across, down) for each in layout.panels)
    return replace(layout, panels=panels, sizes=((width, height),) * len(layout.sizes))


def _moved(panel: Panel, across: int, down: int) -> Panel:
    def move(place: Rectangle) -> Rectangle:
        return place.moved(across, down)

    insets = tuple(map(move, panel.insets))
    return replace(panel, rectangle=move(panel.rectangle), picture=move(panel.picture), insets=insets)
