"""Changing the style of a running renderer: a slider opens no context and compiles no shader."""

from __future__ import annotations

import ctypes
import re
import threading
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from covering import of_the_day
from films import RATE, still_film
from gpu import FORMS, device, disagreements, film_picture
from pictures import VIDEO, codes, step, style
from waiting import new_threads, thread_names

from vidstyle.backend import Backend, FrameRequest
from vidstyle.block import Slider
from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import StyleError
from vidstyle.gpu import session as gpu_session
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.plan import make_plan
from vidstyle.gpu.compile.shader_writer import write_shader
from vidstyle.gpu.device.programs import Program
from vidstyle.gpu.renderer import GpuRenderer
from vidstyle.renderer import open_renderer
from vidstyle.style import LAYERS, Style, load_style, style_names
from vidstyle.style.resolve import resolve

TWINS = {("engraving", "brightness"), ("engraving", "pattern")}
"""Styles with steps that are computed once while they are equal: the first move of a slider parts them.
Likewise the first move of a `scale` that led back to the page's own size asks for resampling."""


def look(sigma: float = 1.5, factor: float = 1.2, ink: str = "#000000", steady: float = 0.0) -> Style:
    """Every kind of value: a radius, a number that is measured with, a colour."""
    base = style(step("gaussian", sigma=sigma), step("equalize", low=3 * sigma, settle=1.0), steady=steady)
    lines = (step("sobel", invert=True), step("brightness", factor=factor))
    return replace(base, lines=lines, ink=ink)


MOVES = [look(), look(sigma=2.5), look(sigma=4), look(factor=0.7), look(ink="#203060"), look(ink="#402010")]


@pytest.fixture(params=["cpu", *FORMS])
def renderer(request: pytest.FixtureRequest) -> Iterator[Backend]:
    made: Backend
    if request.param == "cpu":
        made = CpuRenderer(look(), 2)
    else:
        made = GpuRenderer(look(), device(), CpuRenderer, request.param)
    yield made
    made.close()


def run(chosen: Style, *film: tuple[Picture, float]) -> Picture:
    """The last picture of a film, on the CPU."""
    with CpuRenderer(chosen, 2) as cpu:
        return [cpu.run(picture, time) for picture, time in film][-1]


def test_a_slider_opens_and_compiles_nothing(renderer: Backend, monkeypatch: pytest.MonkeyPatch) -> None:
    picture = film_picture(48, 64)
    renderer.change_style(look(ink="#203060"))  # a coloured ink is another structure than a gray one
    renderer.run(picture)
    renderer.change_style(look())
    renderer.run(picture)
    made: list[str] = []
    compile_one, open_one = Program.__init__, gpu_session.open_context
    monkeypatch.setattr(Program, "__init__", lambda *given: (made.append("program"), compile_one(*given))[1])
    monkeypatch.setattr(
        gpu_session, "open_context", lambda index: (made.append("context"), open_one(index))[1]
    )
    threads = thread_names()
    for chosen in MOVES:
        renderer.change_style(chosen)
        assert disagreements(run(chosen, (picture, 0.0)), renderer.run(picture)) == []
    assert made == [] and new_threads(threads) == set()


def test_the_counters_count(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    compile_one = Program.__init__
    monkeypatch.setattr(Program, "__init__", lambda *given: (made.append("program"), compile_one(*given))[1])
    renderer = GpuRenderer(look(), device(), CpuRenderer)
    renderer.run(film_picture(48, 64))
    renderer.close()
    assert made


def test_pictures_in_flight_keep_their_style(renderer: Backend) -> None:
    picture, pending = film_picture(48, 64), []
    for chosen in MOVES:
        renderer.change_style(chosen)
        pending.append(renderer.begin(FrameRequest(picture, None)))
    for chosen, each in zip(MOVES, pending, strict=True):
        with CpuRenderer(chosen, 2) as cpu:
            assert disagreements(cpu.run(picture), each.result()) == []


def test_percentiles_go_on_where_only_values_differ(renderer: Backend) -> None:
    dark, light = (Picture(VIDEO, luma=codes(VIDEO, 40, 60).luma // 3 + shift) for shift in (20, 120))
    other = look(sigma=2)
    renderer.run(dark, 0.0)
    renderer.change_style(other)
    made = renderer.run(light, 0.4)
    with CpuRenderer(look(), 2) as cpu:
        cpu.run(dark, 0.0)
        cpu.change_style(other)
        assert disagreements(cpu.run(light, 0.4), made) == []
    assert disagreements(run(other, (light, 0.4)), made) != []


def test_the_first_percentiles_of_another_structure_stand_alone(renderer: Backend) -> None:
    dark, light = (Picture(VIDEO, luma=codes(VIDEO, 40, 60).luma // 3 + shift) for shift in (20, 120))
    other = style(step("equalize", settle=1.0))
    renderer.run(dark, 0.0)
    renderer.change_style(other)
    assert disagreements(run(other, (light, 0.4)), renderer.run(light, 0.4)) == []


def test_stabilization_goes_on(renderer: Backend) -> None:
    film = list(still_film(6))
    first, second = (style(step("brightness", factor=factor), steady=0.8) for factor in (1.0, 1.02))
    renderer.change_style(first)
    made = []
    for number, each in enumerate(film):
        if number == 4:
            renderer.change_style(second)
        made.append(renderer.run(each, number / RATE).luma)
    plain = [run(replace(second, steady=0.0), (each, 0.0)).luma for each in film]
    held, boiling = (
        [np.abs(a.astype(float) - b).mean() for a, b in pairwise(run)][-1] for run in (made, plain)
    )
    assert held < 0.6 * boiling


def test_after_a_lost_context_the_newest_style_goes_on_and_pictures_in_flight_keep_theirs() -> None:
    renderer, picture = GpuRenderer(look(), device(), CpuRenderer), film_picture(24, 36)
    enable = ctypes.CDLL("libGL.so.1").glEnable
    for number, chosen in enumerate(MOVES[1:3]):  # the first loss opens it again, the second ends on the CPU
        before = renderer.begin(FrameRequest(picture))
        expected = run(MOVES[number], (picture, 0.0))
        renderer.change_style(chosen)
        after = renderer.begin(FrameRequest(picture))
        assert renderer._session is not None
        renderer._session._thread.submit(enable, 0xFFFF).result()
        assert disagreements(expected, before.result()) == []
        assert disagreements(run(chosen, (picture, 0.0)), after.result()) == []
    assert renderer._session is None
    renderer.change_style(MOVES[3])
    assert disagreements(run(MOVES[3], (picture, 0.0)), renderer.run(picture)) == []
    renderer.close()


def test_a_style_that_cannot_be_used_raises_and_the_next_one_runs(renderer: Backend) -> None:
    picture = film_picture(24, 36)
    renderer.change_style(style(step("pattern", tiles="none")))
    with pytest.raises(StyleError):
        renderer.run(picture)
    renderer.change_style(look())
    assert disagreements(run(look(), (picture, 0.0)), renderer.run(picture)) == []


def texts(chosen: Style, form: Form) -> set[str]:
    layout = PictureLayout(VIDEO, (1080, 1920), "chroma")
    plan = make_plan(chosen, resolve(chosen, *layout.shape), layout, VIDEO, False, form)
    # But for the amount of shared memory, which doubles at a few radii.
    return {re.sub(r"_ROOM \d+", "", write_shader(plan, each).assembly.text) for each in plan.passes}


def moves(chosen: Style) -> Iterator[tuple[str, str, list[Style]]]:
    """Block and parameter of each slider of a style, and the style with it moved twice, a tenth each."""
    for layer in LAYERS:
        steps = getattr(chosen, layer)
        for number, each in enumerate(steps):
            parameters = all_blocks()[each.block].parameters if each.block else {}
            for name, parameter in parameters.items():
                control, value = parameter.control, each.values.get(name, parameter.default)
                if isinstance(control, Slider) and isinstance(value, float):
                    tenth = value / 10 or (control.high - control.low) / 40
                    found = []
                    for moved in (value + tenth, value + 2 * tenth):
                        other = replace(each, values=each.values | {name: min(moved, control.high)})
                        changed = (*steps[:number], other, *steps[number + 1 :])
                        found.append(replace(chosen, **{layer: changed}))
                    yield each.block, name, found


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", of_the_day(style_names(), 2))
def test_no_slider_of_a_shipped_style_asks_for_another_shader(name: str, form: Form) -> None:
    chosen = load_style(name)
    before = texts(chosen, form)
    for block, parameter, (first, second) in moves(chosen):
        known = before | texts(first, form)
        if (block, parameter) != ("scale", "factor") and (name, block) not in TWINS:
            assert known == before, (block, parameter)
        assert texts(second, form) <= known, (block, parameter)


def test_the_empty_style_changes_what_another_encoding_or_style_asks_for() -> None:
    shown = next(still_film(1))
    with closing(open_renderer(style())) as renderer:
        assert renderer.run(shown) is shown
        color = renderer.run(shown, rgb=True).color
        assert color is not None and color.shape == (*shown.shape, 3)
        renderer.change_style(style(step("brightness", factor=0.5)))
        assert renderer.run(shown).luma.mean() < 0.8 * shown.luma.mean()  # type: ignore[union-attr]
    with closing(open_renderer(style())) as renderer:
        renderer.change_style(style(step("brightness", factor=0.5)))
        assert renderer.run(shown).luma.mean() < 0.8 * shown.luma.mean()  # type: ignore[union-attr]


def test_pictures_in_flight_are_those_made_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stabilized, measured and with a cut; the first is held until all others are stabilized."""
    scenes = [film_picture(48, 64, name=name) for name in ["coffee"] * 4 + ["astronaut"] * 4]
    film = [replace(each, luma=np.roll(each.luma, number, axis=1)) for number, each in enumerate(scenes)]
    with CpuRenderer(look(steady=0.8), 2) as apart:
        alone = [apart.run(picture, number / 25) for number, picture in enumerate(film)]
    all_started, restyle = threading.Event(), CpuRenderer._restyle

    def held(self: CpuRenderer, frame: Any, *others: Any) -> Picture:
        assert frame.request.time != 0 or all_started.wait(60)
        return restyle(self, frame, *others)

    monkeypatch.setattr(CpuRenderer, "_restyle", held)
    with CpuRenderer(look(steady=0.8), 2) as together:
        started = [together.begin(FrameRequest(picture, number / 25)) for number, picture in enumerate(film)]
        all_started.set()
    for one, other in zip(alone, started, strict=True):
        np.testing.assert_array_equal(one.luma, other.result().luma)


def test_a_picture_that_fails_does_not_keep_those_after_it_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(self: CpuRenderer, frame: Any, *others: Any) -> Picture:
        if frame.request.time == 0:
            raise ValueError("broken")
        return restyle(self, frame, *others)

    restyle = CpuRenderer._restyle
    monkeypatch.setattr(CpuRenderer, "_restyle", failing)
    with CpuRenderer(look(steady=0.8), 2) as renderer:
        first, second = [renderer.begin(FrameRequest(film_picture(48, 64), time)) for time in (0.0, 0.04)]
        assert second.result(60).shape == (48, 64)
        with pytest.raises(ValueError, match="broken"):
            first.result(60)
