"""Masks on a GPU agree with the CPU."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from covering import drawn
from films import RATE, still_film
from gpu import FORMS, Sessions, disagreements, film_picture, gray_picture, packed_picture
from pictures import run

from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.gpu.compile.glsl import Form
from vidstyle.style import load_style
from vidstyle.style.behind import style_behind

MASKS = {"screen": {"color": "#00b140"}}
STYLE = load_style(
    {
        "format": 1,
        "masks": MASKS,
        "only": "people",
        "keep": "screen",
        "background": [
            {"block": "scale", "factor": 0.5},
            {"block": "posterize", "levels": 6},
            {"block": "blend", "mask": "people", "opacity": 0.7},
        ],
        "lines": [{"from": "screen"}, {"block": "gaussian", "sigma": 3}, {"block": "equalize"}],
        "behind": {"background": [{"block": "gaussian", "sigma": 4}]},
    }
)

whole = Sessions.fixture()
tiled = Sessions.fixture(max_side=64)


def with_masks(source: Picture) -> Picture:
    """With a soft disk as people, the rest as background, and a ramp that has every code as the screen."""
    height, width = source.shape
    rows, columns = np.mgrid[:height, :width]
    distance = np.hypot(rows - height / 2, columns - width / 2) / max(height, width)
    people = np.clip((0.35 - distance) * 2000, 0, 255).astype(np.uint8)
    screen = (255 * columns // max(1, width - 1)).astype(np.uint8)
    return replace(source, masks={"people": people, "background": 255 - people, "screen": screen})


PICTURES = {
    "video": film_picture(75, 101),
    "deep": film_picture(75, 101, Encoding("bt2020", depth=10, subsampling=(2, 1))),
    "gray": gray_picture(75, 101),
    "packed": packed_picture(75, 101),
    "pixel": film_picture(1, 1),
}


@pytest.mark.parametrize("kind", PICTURES)
def test_masks_agree(whole: Sessions, kind: str) -> None:
    source, form = with_masks(PICTURES[kind]), drawn(FORMS, kind)
    options = {"target": source.encoding, "rgb": source.color is not None}
    assert disagreements(run(STYLE, source, **options), whole.run(form, STYLE, source, **options)) == []


@pytest.mark.parametrize("form", FORMS)
def test_tiles_have_their_parts_of_masks(tiled: Sessions, form: Form) -> None:
    source = with_masks(film_picture(150, 210))
    assert disagreements(run(STYLE, source), tiled.run(form, STYLE, source)) == []


@pytest.mark.parametrize("form", FORMS)
def test_masks_of_stabilized_films_agree(whole: Sessions, form: Form) -> None:
    style = replace(load_style("ink"), steady=0.5, keep="people", behind=style_behind("blur"))
    with CpuRenderer(style) as renderer:
        for number, each in enumerate(still_film(4, shape=(90, 120))):
            source = with_masks(each)
            one = renderer.run(source, number / RATE)
            assert disagreements(one, whole.run(form, style, source, time=number / RATE)) == []
