"""Films on the GPU: smoothed measurements, changes of size and style, several pictures in flight."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest
from covering import of_the_day
from gpu import FORMS, Sessions, disagreements, scene
from pictures import FLOAT, RGB8, VIDEO, run, same_bits, step, style

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.gpu.compile.glsl import Form
from vidstyle.style import Style

SHAPE = (61, 97)
Frame = tuple[Picture, float | None]

MEASURED = Style(
    "measured",
    base=(step("equalize", low=3, high=97, settle=0.4),),
    background=(step("gaussian", sigma=1), step("minimum_range", dynamic_range=230, settle=0.1)),
    lines=(step("gaussian", source="source"), step("equalize", settle=2), step("sobel", invert=True)),
)
"""Three measures with different time constants; one measures the source."""


sessions = Sessions.fixture()


@cache
def frame(
    number: int, name: str = "coffee", shape: tuple[int, int] = SHAPE, encoding: Encoding = VIDEO
) -> Picture:
    """A scene that gets darker and flatter with every frame, but not enough for a cut."""
    color = scene(*shape, name) * np.float32(0.9 - 0.05 * number) + np.float32(0.01 * number)
    rgb = encoding == RGB8
    return run(style(), Picture(FLOAT, color=color), target=encoding, rgb=rgb)


def on_the_cpu(chosen: Style, film: Sequence[Frame]) -> list[Picture]:
    with CpuRenderer(chosen) as renderer:
        return [renderer.run(picture, time, VIDEO) for picture, time in film]


def on_the_gpu(sessions: Sessions, form: Form, chosen: Style, film: Sequence[Frame]) -> list[Picture]:
    return [sessions.run(form, chosen, picture, time=time, target=VIDEO) for picture, time in film]


FILMS: dict[str, list[Frame]] = {
    "steady": [(frame(number), number / 25) for number in range(8)],
    "with a cut": [
        (frame(number % 4, "coffee" if number < 4 else "astronaut"), number / 25) for number in range(8)
    ],
    "with pictures that stand alone": [
        (frame(number), None if number in (2, 5) else number / 25) for number in range(8)
    ],
    "with a jump back": [(frame(number), (number % 5) / 10) for number in range(8)],
    "of two sizes": [
        (frame(number, shape=SHAPE if number // 3 % 2 == 0 else (60, 57)), number / 10) for number in range(9)
    ],
    "of many kinds": [
        (frame(number, encoding=[VIDEO, Encoding(depth=10), RGB8, VIDEO][number // 2]), number / 10)
        for number in range(8)
    ],
}


CASES = [(name, form) for name in FILMS for form in FORMS]
some_films = pytest.mark.parametrize("case", of_the_day(CASES, len(FILMS)), ids="-".join)


@some_films
def test_palette_of_film_agrees_with_cpu(case: tuple[str, Form], sessions: Sessions) -> None:
    name, form = case
    film, chosen = FILMS[name], style(step("palette", colors="film-16"))
    right = on_the_cpu(chosen, film)
    sessions.run(form, style(), film[0][0])
    for number, made in enumerate(on_the_gpu(sessions, form, chosen, film)):
        assert disagreements(right[number], made) == [], number


@some_films
def test_measured_blocks_agree_with_cpu_over_time(case: tuple[str, Form], sessions: Sessions) -> None:
    name, form = case
    film = FILMS[name]
    right = on_the_cpu(MEASURED, film)
    # Another style in between, so that each film starts without state.
    sessions.run(form, style(), film[0][0])
    for number, made in enumerate(on_the_gpu(sessions, form, MEASURED, film)):
        assert disagreements(right[number], made) == [], number


def test_films_depend_on_state_of_measured_blocks() -> None:
    """Each differs from restyling single pictures, so that the test above can fail."""
    for name, film in FILMS.items():
        alone = on_the_cpu(MEASURED, [(picture, None) for picture, _ in film])
        with_memory = on_the_cpu(MEASURED, film)
        assert any(disagreements(*pair) for pair in zip(alone, with_memory, strict=True)), name


def test_new_style_restarts_measurements(sessions: Sessions) -> None:
    """In mid-film, with measured steps at the same positions as in the old style."""
    film = FILMS["steady"]
    other = Style("other", base=MEASURED.base, lines=(step("equalize", settle=5),))
    for form in FORMS:
        for chosen, part in [(MEASURED, film[:4]), (other, film[4:]), (MEASURED, film[2:6])]:
            for right, made in zip(
                on_the_cpu(chosen, part), on_the_gpu(sessions, form, chosen, part), strict=True
            ):
                assert disagreements(right, made) == [], (form, chosen.name)


TOGETHER: dict[str, list[Picture]] = {
    "of one size": [frame(number) for number in range(6)],
    "of two sizes": [frame(number, shape=SHAPE if number % 2 else (60, 57)) for number in range(6)],
    "of many kinds": [
        frame(number, encoding=[VIDEO, RGB8, Encoding(depth=10)][number % 3]) for number in range(6)
    ],
}


@pytest.mark.parametrize("max_side", [8192, 64], ids=["whole", "tiled"])
@pytest.mark.parametrize("name", TOGETHER)
def test_concurrent_pictures_return_in_order(name: str, max_side: int) -> None:
    """Each is the same as without the others; earlier results do not change when later ones arrive."""
    chosen = style(step("gaussian", sigma=2), step("saturation"), step("equalize"))
    pictures = TOGETHER[name]
    right = [run(chosen, picture) for picture in pictures]
    with Sessions(max_side=max_side) as sessions:
        for form in FORMS:
            started: list[Callable[[], Picture]] = []
            made: list[Picture] = []
            for picture in pictures:
                started.append(sessions.start(form, chosen, picture))
                if len(started) > 1:
                    made.append(started.pop(0)())
            made.append(started.pop()())
            for number, (one, other) in enumerate(zip(right, made, strict=True)):
                assert disagreements(one, other) == [], (form, number)


def test_plane_memory_can_be_reused_after_start(sessions: Sessions) -> None:
    first, second = frame(0), frame(5)
    for form in FORMS:
        expected = sessions.run(form, MEASURED, first)
        luma, (blue, red) = first.luma.copy(), (plane.copy() for plane in first.chroma)  # type: ignore[union-attr]
        drawn = (
            sessions[form]
            .start(MEASURED, FrameRequest(Picture(VIDEO, luma, (blue, red)), target=VIDEO))
            .result()
        )
        luma[:] = second.luma
        blue[:], red[:] = second.chroma  # type: ignore[misc]
        assert same_bits(sessions[form].fetch(drawn).result(), expected)
