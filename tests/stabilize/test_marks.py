"""Marks that move with the objects of a film."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from films import RATE, page, panned_film, picture
from media import photograph
from pictures import same_bits, step, style

from tools.steadiness.clips import DISC_SPEED_PX, make_moving_disc, restyle_clip
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.pipeline.scene_memory import memory_bytes, restore_memory
from vidstyle.style import Style
from vidstyle.style.resolve import has_moving_marks, measurement_key, resolve

STONES = style(step("gaussian", sigma=1), step("mosaic", size=9, variation=0.4, edges=0.3), steady=0.5)
DOTS = style(step("gaussian", sigma=1), step("strokes", length=8, width=8, variation=0.5), steady=0.5)
FIXED = style(step("gaussian", sigma=1), step("mosaic", size=9, variation=0.4), steady=0.5)


def of_disc(chosen: Style) -> tuple[float, float]:
    """Correlation of the marks on a moving disc with the next frame: where they are, and where it moves."""
    still = cv2.resize(photograph("coffee")[:338], (320, 180), interpolation=cv2.INTER_AREA)
    clip, _ = make_moving_disc(still, 6)
    shown = restyle_clip(chosen, clip, "cpu")[-2:]
    lumas = [cv2.cvtColor(each, cv2.COLOR_RGB2GRAY).astype(np.float32) for each in shown]
    first, second = (each - cv2.GaussianBlur(each, (0, 0), 4) for each in lumas)
    rows, columns = np.indices(still.shape[:2])
    places = np.hypot(rows - 90, columns - 160 - DISC_SPEED_PX * 2) < 30
    page_, object_ = (
        float(np.corrcoef(np.roll(first, shift, axis=1)[places], second[places])[0, 1])
        for shift in (0, DISC_SPEED_PX)
    )
    return page_, object_


@pytest.mark.parametrize("chosen", [STONES, DOTS], ids=["stones", "dots"])
def test_marks_move_with_an_object(chosen: Style) -> None:
    page_, object_ = of_disc(chosen)
    assert object_ > max(0.6, page_ + 0.2)


def test_marks_of_straight_tiles_and_without_steady_stay_on_the_page() -> None:
    for chosen in (FIXED, replace(DOTS, steady=0.0)):
        page_, object_ = of_disc(chosen)
        assert page_ > 0.6 > object_


def film(count: int) -> list[Picture]:
    return list(panned_film(count, deviation=1))


def frames(renderer: CpuRenderer, film_: list[Picture], first: int = 0) -> list[Picture]:
    started = [renderer.start(each, (first + number) / RATE) for number, each in enumerate(film_)]
    return [each.result() for each in started]


def test_marks_begin_anew_at_a_scene_cut() -> None:
    other = picture(page(180, 320, "rocket"))
    with CpuRenderer(DOTS, 1) as renderer:
        after = frames(renderer, [*film(4), other])[-1]
    with CpuRenderer(DOTS, 1) as renderer:
        assert same_bits(frames(renderer, [other])[0], after)


def test_any_threads_and_a_handed_on_memory_give_the_same_marks() -> None:
    shown = film(6)
    with CpuRenderer(STONES, 1) as renderer:
        right = frames(renderer, shown[:4])
        memory = memory_bytes(renderer)
        right += frames(renderer, shown[4:], 4)
    with CpuRenderer(STONES, 4) as renderer:
        assert all(map(same_bits, right, frames(renderer, shown)))
    with CpuRenderer(STONES, 2) as renderer:
        frames(renderer, shown[3:4], 3)
        restore_memory(renderer, memory)
        assert all(map(same_bits, right[4:], frames(renderer, shown[4:], 4)))


def test_marks_that_stay_on_the_page_ask_for_no_motion() -> None:
    moving, fixed = (resolve(each, 180, 320) for each in (STONES, FIXED))
    assert has_moving_marks(moving) and not has_moving_marks(fixed)
    assert measurement_key(moving) != measurement_key(fixed), "a stabilizer for one does not serve the other"
