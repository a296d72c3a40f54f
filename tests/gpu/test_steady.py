"""Temporal stabilization on the GPU agrees with that on the CPU."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day
from films import RATE, VIDEO, panned_film, still_film
from gpu import AGREEMENT, FORMS, Sessions, disagreements
from pictures import RGB8, noise, step, style

from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.gpu.compile.glsl import Form
from vidstyle.style import Step, Style

LINES = style(step("gaussian", sigma=1), step("sobel"), steady=0.5)
STROKES = style(step("pattern", levels=4), steady=0.5)
COLORS = style(step("posterize", levels=5), steady=0.7)
STEEP_AGREEMENT = 0.998
"""Share of the samples of STROKES and COLORS within one level. The CPU blends frames in 16-bit arithmetic: in
these films its sources differ from the GPU's by up to 0.4 levels, which steep steps of tones enlarge."""
DEEP = Encoding("bt2020", depth=10, subsampling=(2, 1))
FULL = Encoding("bt601", full_range=True, depth=16, subsampling=(1, 1))


sessions = Sessions.fixture()
tiled = Sessions.fixture(max_side=128)


def rgb_film() -> Iterator[Picture]:
    still = noise(90, 120, 3)
    for number in range(4):
        array = np.clip(still * 150 + 60 + noise(90, 120, 3, seed=number) * 9, 0, 255).astype(np.uint8)
        yield Picture(RGB8, color=array)


def gray_film() -> Iterator[Picture]:
    return (replace(each, chroma=None) for each in still_film(4))


FILMS = {
    "video": lambda: panned_film(5),
    "deep": lambda: panned_film(4, encoding=DEEP),
    "full": lambda: panned_film(4, encoding=FULL),
    "rgb": rgb_film,
    "gray": gray_film,
}


def frame_faults(
    sessions: Sessions, form: Form, chosen: Style, film: Iterable[Picture], rgb: bool
) -> list[str]:
    """Return differences between the films of the GPU and the CPU."""
    found, agreement = [], AGREEMENT if chosen is LINES else STEEP_AGREEMENT
    with CpuRenderer(chosen, 2) as renderer:
        for number, each in enumerate(film):
            time = number / RATE
            right = renderer.run(each, time, rgb=rgb)
            made = sessions.run(form, chosen, each, time=time, rgb=rgb)
            found += [f"{number}: {line}" for line in disagreements(right, made, agreement)]
    return found


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", FILMS)
@pytest.mark.parametrize("turn", of_the_day(range(3), 1))
def test_films_agree(sessions: Sessions, form: Form, kind: str, turn: int) -> None:
    chosen = (LINES, STROKES, COLORS)[(list(FILMS).index(kind) + turn) % 3]
    assert frame_faults(sessions, form, chosen, FILMS[kind](), rgb=kind == "rgb") == []


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("moving", [step("mosaic", size=9, edges=0.5), step("strokes", length=9, width=5)])
def test_moving_marks_agree(sessions: Sessions, form: Form, moving: Step) -> None:
    chosen = style(step("gaussian", sigma=1), moving, steady=0.5)
    assert frame_faults(sessions, form, chosen, panned_film(4, deviation=1), rgb=False) == []


@pytest.mark.parametrize("form", FORMS)
def test_page_larger_than_texture_is_stabilized(tiled: Sessions, form: Form) -> None:
    assert frame_faults(tiled, form, LINES, panned_film(4), rgb=False) == []


@pytest.mark.parametrize("form", FORMS)
def test_luma_and_chroma_flicker_less(sessions: Sessions, form: Form) -> None:
    def flicker(steady: float) -> list[float]:
        chosen = style(step("brightness", factor=1), steady=steady)
        film = [
            sessions.run(form, chosen, each, time=number / RATE) for number, each in enumerate(still_film(8))
        ]
        planes = [(each.luma, *(each.chroma or ())) for each in film[4:]]
        return [
            float(np.mean([np.abs(a.astype(float) - b).mean() for a, b in zip(run, run[1:], strict=False)]))
            for run in zip(*planes, strict=True)
        ]

    assert all(held < 0.5 * boiling for held, boiling in zip(flicker(0.5), flicker(0), strict=True))


def test_new_style_size_or_cut_restarts_stabilization(sessions: Sessions) -> None:
    first, second = (
        style(step("brightness", factor=1), steady=1),
        style(step("brightness"), step("brightness", factor=1), steady=1),
    )
    film = list(still_film(3))
    for number, each in enumerate(film):
        sessions.run("compute", first, each, time=number / RATE)
    small = next(still_film(1, shape=(90, 160)))
    with CpuRenderer(style(step("brightness")), 2) as renderer:
        plain = renderer.run(film[0])

    assert disagreements(plain, sessions.run("compute", second, film[0], time=4 / RATE)) == []
    assert disagreements(small, sessions.run("compute", first, small, time=5 / RATE)) == []
    assert VIDEO == small.encoding
