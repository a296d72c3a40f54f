"""A panel gets the light with which its style keeps light and dark objects apart."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.output.color_cast import reduce_color_cast
from vidstyle.comic.output.panel_light import LightChoice, choose_light, darken_lights
from vidstyle.comic.output.panel_renderer import PanelRenderer
from vidstyle.comic.output.shadow_light import lift_shadows
from vidstyle.comic.output.structure_loss import measure_structure_loss
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.style import load_style

WIDTH, HEIGHT = 640, 420


def place(*colors: tuple[int, int, int]) -> np.ndarray:
    """Return a wall with a disc on it and a dark stripe at the left, in these colours."""
    wall, disc, stripe = colors
    picture = np.full((HEIGHT, WIDTH, 3), wall, np.uint8)
    cv2.circle(picture, (400, 210), 120, disc, -1)
    picture[:, :100] = stripe
    return picture


LIGHT_ON_LIGHT = place((182, 150, 50), (210, 176, 62), (8, 6, 4))


def contrast_of(drawn: np.ndarray) -> float:
    """Return by how much the disc is lighter than the wall."""
    luma = cv2.cvtColor(drawn, cv2.COLOR_RGB2GRAY).astype(float)
    return float(luma[130:290, 330:470].mean() - luma[20:60, 150:280].mean())


def test_watercolor_keeps_a_light_object_on_a_light_wall_apart() -> None:
    with PanelRenderer((), 150, "cpu", announce=False) as renderer:
        window, place = Box(0, 0, WIDTH, HEIGHT), Rectangle(0, 0, WIDTH, HEIGHT)
        drawn = renderer.draw(load_style("watercolor"), LIGHT_ON_LIGHT, window, place)
    assert contrast_of(drawn) > 12


def test_a_style_that_keeps_all_forms_gets_lighter_shadows() -> None:
    assert choose_light(LIGHT_ON_LIGHT, np.asarray) is lift_shadows


def test_darker_lights_are_chosen_where_a_style_merges_lights() -> None:
    picture = place((185, 185, 185), (215, 215, 215), (8, 8, 8))
    light = choose_light(picture, lambda shown: np.minimum(shown, 180))
    assert light is not lift_shadows
    assert contrast_of(np.minimum(light(picture), 180)) > 15


def test_darkened_lights_keep_black_white_and_hue() -> None:
    ramp = np.tile(np.linspace(0, 255, WIDTH).astype(np.uint8)[:, np.newaxis], (HEIGHT, 1, 3))
    dark = darken_lights(ramp, 2.0).astype(int)
    assert dark[0, 0].max() <= 1 and dark[0, -1].min() >= 250
    assert 50 <= dark[0, WIDTH // 2, 0] <= 80
    assert np.ptp(dark, axis=2).max() == 0


def test_panels_of_one_view_and_style_have_the_same_light() -> None:
    choice, drawn = LightChoice(), list[np.ndarray]()
    frame, other = photograph("astronaut"), photograph("coffee")

    def draw(shown: np.ndarray) -> np.ndarray:
        drawn.append(shown)
        return shown

    first = choice.choose("paper", frame, frame, draw)
    assert choice.choose("paper", frame + 1, frame[:200], draw) is first
    assert len(drawn) == 1
    choice.choose("paper", other, other, draw)
    assert len(drawn) == 2
    choice.choose("ink", frame, frame, draw)
    assert len(drawn) == 3


@pytest.mark.parametrize(("drawn", "least", "most"), [("same", 0, 0), ("flat", 0.9, 1), ("dots", 0, 0.1)])
def test_structure_loss_of_a_flat_drawing_is_one_and_marks_cost_little(
    drawn: str, least: float, most: float
) -> None:
    flat = np.full_like(LIGHT_ON_LIGHT, 128)
    dots = LIGHT_ON_LIGHT.copy()
    dots[::4, ::4] = 0
    found = measure_structure_loss(
        LIGHT_ON_LIGHT, {"same": LIGHT_ON_LIGHT, "flat": flat, "dots": dots}[drawn]
    )
    assert least <= found <= most


def test_contrast_that_the_source_does_not_have_costs() -> None:
    haze = np.full((HEIGHT, WIDTH, 3), 190, np.uint8)
    blobs = haze.copy()
    cv2.circle(blobs, (300, 200), 90, (255, 255, 255), -1)
    assert measure_structure_loss(haze, blobs) > 0.1 > measure_structure_loss(haze, haze)


def test_a_picture_in_yellow_light_gets_whiter() -> None:
    before, after = (
        cv2.cvtColor(each, cv2.COLOR_RGB2LAB).astype(int)
        for each in (LIGHT_ON_LIGHT, reduce_color_cast(LIGHT_ON_LIGHT))
    )
    assert after[210, 400, 2] - 128 < 0.6 * (before[210, 400, 2] - 128)
    assert abs(after[210, 400, 0] - before[210, 400, 0]) < 8


@pytest.mark.parametrize(
    "colors",
    [
        ((40, 90, 200), (230, 120, 30), (20, 20, 60)),
        ((182, 150, 50), (220, 215, 205), (8, 6, 4)),
        ((120, 120, 120), (200, 200, 200), (8, 8, 8)),
    ],
)
def test_a_picture_with_other_or_neutral_colors_stays(colors: tuple[tuple[int, int, int], ...]) -> None:
    picture = place(*colors)
    assert reduce_color_cast(picture) is picture
