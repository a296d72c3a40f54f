"""Panels are drawn finer than the page shows them, except in styles of points and squares."""

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.backend import Backend
from vidstyle.comic.output import panel_renderer
from vidstyle.comic.output.panel_renderer import PanelRenderer
from vidstyle.comic.output.paper_scale import MAX_REDUCTION_FACTOR, reduction_factor
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.renderer import restyle_array
from vidstyle.style import Style, load_style

WHOLE = Box(0.0, 0.0, 512.0, 512.0)


def draw(dpi: float, side: int) -> np.ndarray:
    with PanelRenderer([load_style("comic")], dpi, "cpu", announce=False) as renderer:
        return renderer.panel(photograph("astronaut")[:512, :512], WHOLE, Rectangle(0, 0, side, side))


def test_a_panel_on_a_screen_is_a_reduced_print() -> None:
    """So lines are finer than the pixels of a page with 150 dpi."""
    printed = cv2.resize(draw(300, 240), (120, 120), interpolation=cv2.INTER_AREA)
    assert (draw(150, 120) == printed).all()


@pytest.mark.parametrize("style", ["ascii", "dither", "pixel"])
def test_squares_letters_and_points_are_not_blended(style: str) -> None:
    assert reduction_factor(load_style(style), 150) == 1


@pytest.mark.parametrize("style", ["comic", "engraving", "ink", "oil"])
def test_panels_are_drawn_at_the_resolution_of_print(style: str) -> None:
    assert reduction_factor(load_style(style), 200) == 1.5
    assert reduction_factor(load_style(style), 600) == 1
    assert reduction_factor(load_style(style), 30) == MAX_REDUCTION_FACTOR


def test_drafts_draw_no_picture_twice_and_prepare_each_size_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are as small as the pictures by which their light is chosen."""
    style, drawn, prepared = load_style("comic"), list[bytes](), list[Style]()

    def restyle(backend: Backend, color: np.ndarray, seen_side: float) -> np.ndarray:
        drawn.append(color.tobytes())
        return restyle_array(backend, color, seen_side=seen_side)

    def prepare(backend: MaskRenderer, style: Style) -> None:
        prepared.append(style)
        change_style(backend, style)

    change_style = MaskRenderer.change_style
    monkeypatch.setattr(panel_renderer, "restyle_array", restyle)
    monkeypatch.setattr(MaskRenderer, "change_style", prepare)
    with PanelRenderer((), 100, "cpu", announce=False, is_draft=True) as renderer:
        for name in ("astronaut", "coffee"):
            renderer.draw(style, photograph(name)[:400, :400], Box(0, 0, 400, 400), Rectangle(0, 0, 200, 200))
        assert len(set(drawn)) == len(drawn) >= 2 and not prepared
        renderer.draw(style, photograph("cat")[:200, :300], Box(0, 0, 300, 200), Rectangle(0, 0, 300, 150))
        assert len(prepared) == 1
