"""Style changes in a session: immediate for values, prepared in the background for another structure."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction

import moderngl
import numpy as np
import pytest
from live import before_opening, refuse
from waiting import LONG, eventually, new_threads, thread_names

from vidstyle.core.picture import Encoding, Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.cues.cue_list import Cue, CueList
from vidstyle.gpu import session
from vidstyle.gpu.device.devices import list_devices
from vidstyle.live import hot_swap
from vidstyle.live.hot_swap import HotSwapRenderer
from vidstyle.live.process import beside
from vidstyle.style import Style, load_style, override, set_values

FEW = load_style(
    {"format": 1, "name": "few", "background": [{"block": "luma_posterize", "levels": 3, "softness": 0}]}
)
ENCODING = Encoding("bt709", full_range=False, depth=8, subsampling=(2, 2))


class Film:
    """Runs the same picture through a renderer again and again."""

    def __init__(self, renderer: HotSwapRenderer) -> None:
        ramp = np.tile(np.linspace(0, 255, 96).astype(np.uint8), (64, 1))
        self._picture = Picture.from_array(np.dstack([ramp] * 3))
        self._renderer, self._count = renderer, 0

    def tones(self, style: Style | CueList) -> int:
        """How many there are in the next picture, with this style wanted."""
        self._count += 1
        picture, _ = self._renderer.run(self._picture, self._count / 25, ENCODING, style)
        assert picture.luma is not None
        return len(np.unique(picture.luma))


def test_the_left_share_of_a_divided_picture_is_the_original() -> None:
    gray = Picture(ENCODING, np.full((10, 16), 50, np.uint8))
    color = Picture(ENCODING, np.full((10, 16), 200, np.uint8), (np.full((5, 8), 90, np.uint8),) * 2)
    for before, after, chroma in ((gray, color, (128, 90)), (color, gray, (90, 128))):
        divided = beside(before, after, 0.25)
        assert divided.luma is not None and divided.chroma is not None
        assert divided.luma[0].tolist() == [before.luma[0, 0]] * 4 + [after.luma[0, 0]] * 12  # type: ignore[index]
        assert [plane[0].tolist() for plane in divided.chroma] == [[chroma[0]] * 2 + [chroma[1]] * 6] * 2


def test_a_reduced_picture_is_sharpened_before_it_is_enlarged() -> None:
    edge = np.full((36, 64), 80, np.uint8)
    edge[:, 32:] = 160
    sharp = hot_swap.sharpen_luma(Picture(ENCODING, edge)).luma
    assert sharp is not None and sharp[5, 31] < 80 < 160 < sharp[5, 32]
    assert (sharp[:, :24] == 80).all() and (sharp[:, 40:] == 160).all(), "flat areas stay"
    edge[edge == 80], edge[edge == 160] = 16, 235
    assert np.array_equal(hot_swap.sharpen_luma(Picture(ENCODING, edge)).luma, edge), "in the limited range"
    renderer = HotSwapRenderer(load_style("plain"), "cpu", pytest.fail)
    try:
        slopes = []
        for scale in (1, 0.5):
            renderer.scale = scale
            wave = np.tile(128 + 40 * np.sin(np.arange(256) / 6), (64, 1)).astype(np.uint8)
            shown, _ = renderer.run(Picture(ENCODING, wave), 0, ENCODING, load_style("plain"))
            assert shown.shape == wave.shape and shown.luma is not None
            slopes.append(np.ptp(shown.luma[32].astype(int)))
        assert slopes[1] > slopes[0]
    finally:
        renderer.close(LONG)


@contextmanager
def running(device: str = "cpu", style: Style = FEW) -> Iterator[tuple[Film, list[str], HotSwapRenderer]]:
    told: list[str] = []
    made = HotSwapRenderer(style, device, told.append)
    try:
        yield Film(made), told, made
    finally:
        made.close(LONG)


def count_calls(monkeypatch: pytest.MonkeyPatch, owner: object, name: str) -> list[str]:
    """A list that grows by the name with each call."""
    original, calls = getattr(owner, name), []

    def call(*given: object, **named: object) -> object:
        calls.append(name)
        return original(*given, **named)

    monkeypatch.setattr(owner, name, call)
    return calls


def test_a_renderer_that_is_ready_after_the_end_is_closed(monkeypatch: pytest.MonkeyPatch):
    entered, go = threading.Event(), threading.Event()

    def wait() -> None:
        entered.set()
        go.wait(LONG)

    def close(self: CpuRenderer) -> None:
        closed.add(self.style.name)
        original(self)

    before_opening("poster", wait, monkeypatch)
    closed, original = set[str](), CpuRenderer.close
    monkeypatch.setattr(CpuRenderer, "close", close)
    with running() as (film, _, made):
        film.tones(FEW)
        film.tones(load_style("poster"))
        entered.wait(LONG)
        made.close(0.01)
        assert closed == {"few"}
        go.set()
    assert closed == {"few", "poster"}


@pytest.mark.parametrize("threads", [1, 2, 4, 16])
def test_values_take_over_with_the_next_picture(monkeypatch: pytest.MonkeyPatch, threads: int):
    monkeypatch.setenv("VIDSTYLE_THREADS", str(threads))
    opened = count_calls(monkeypatch, hot_swap, "open_renderer")
    with running() as (film, told, made):
        few = film.tones(FEW)
        before = thread_names()
        for levels in range(6, 30):
            changed = override(FEW, [f"luma_posterize.levels={levels}"])
            assert film.tones(changed) > few
            assert made.style is changed
        assert film.tones(FEW) == few and not told
        assert len(opened) == 1 and new_threads(before) == set()


@pytest.mark.parametrize(
    ("name", "path", "values"),
    [("ink", "flow_dog.p", range(10, 40, 3)), ("ink", "ink", ["#102030", "#304050"]),
     ("ink", "steady", [0.1, 0.9]), ("comic", "halftone.cell", [6.0, 9.0]),
     ("ink", "gaussian#1.sigma", [1.0, 2.0, 7.0])],
)  # fmt: skip
def test_a_slider_on_a_gpu_compiles_no_shader_and_opens_no_context(
    monkeypatch: pytest.MonkeyPatch, name: str, path: str, values: Iterable[object]
):
    contexts = count_calls(monkeypatch, session, "open_context")
    shaders = count_calls(monkeypatch, moderngl.Context, "compute_shader")
    programs = count_calls(monkeypatch, moderngl.Context, "program")
    style = load_style(name)
    with running(f"gpu:{list_devices()[0].index}", style) as (film, _, made):
        film.tones(style)
        film.tones(style)  # the stabilizer compares two pictures
        before = len(contexts), len(shaders) + len(programs)
        assert min(before) > 0
        for value in values:
            changed = set_values(style, {path: value})
            film.tones(changed)
            assert made.style is changed
        assert (len(contexts), len(shaders) + len(programs)) == before


@pytest.mark.parametrize(
    "other",
    ["poster", "plain", override(FEW, ["steady=0.5"]), Style("few", lines=FEW.background)],
    ids=["style", "plain", "steady", "layer"],
)
def test_what_has_to_be_loaded_is_made_ready_first(other: Style | str):
    other = load_style(other)
    with running() as (film, _, made):
        film.tones(FEW)
        assert made.preparing == ""
        film.tones(other)
        assert (made.style, made.preparing) == (FEW, other.name)
        eventually(lambda: film.tones(other) and made.style is other)
        assert made.preparing == ""


def test_another_style_on_a_gpu_is_made_ready_first(monkeypatch: pytest.MonkeyPatch):
    contexts = count_calls(monkeypatch, session, "open_context")
    other = Style("few", lines=FEW.background)
    with running(f"gpu:{list_devices()[0].index}") as (film, _, made):
        film.tones(FEW)
        film.tones(other)
        assert made.style is FEW
        eventually(lambda: film.tones(other) and made.style is other)
    assert len(contexts) == 2


def test_values_that_move_while_a_style_is_made_ready_come_with_it(monkeypatch: pytest.MonkeyPatch):
    begun, go = threading.Event(), threading.Event()
    opened = count_calls(monkeypatch, hot_swap, "open_renderer")

    def wait() -> None:
        begun.set()
        go.wait(LONG)

    before_opening("poster", wait, monkeypatch)
    poster = load_style("poster")
    moved = set_values(poster, {"steady": 0.7})
    with running() as (film, _, made):
        film.tones(FEW)
        film.tones(poster)
        assert begun.wait(LONG)
        film.tones(moved)
        assert made.style is FEW
        go.set()
        eventually(lambda: film.tones(moved) and made.style is moved)
    assert len(opened) == 2


def test_what_was_asked_for_earlier_never_comes_later(monkeypatch: pytest.MonkeyPatch):
    begun, go = threading.Event(), threading.Event()

    def wait() -> None:
        begun.set()
        go.wait(LONG)

    before_opening("poster", wait, monkeypatch)
    changed = override(FEW, ["luma_posterize.levels=9"])
    with running() as (film, _, made):
        film.tones(FEW)
        film.tones(load_style("poster"))
        assert begun.wait(LONG)
        film.tones(FEW)
        film.tones(changed)
        go.set()
        eventually(lambda: film.tones(changed) and made.style is changed)
        for _ in range(20):
            film.tones(changed)
            assert made.style is changed


def test_values_take_over_at_once_after_a_style_that_could_not_be_had(monkeypatch: pytest.MonkeyPatch):
    before_opening("poster", refuse, monkeypatch)
    changed = override(FEW, ["luma_posterize.levels=9"])
    with running() as (film, told, made):
        film.tones(FEW)
        film.tones(load_style("poster"))
        eventually(lambda: told)
        film.tones(changed)
        assert made.style is changed


def test_a_cue_list_starts_when_it_is_ready():
    """Its first cue is from its first picture on, however long its preparation takes."""
    many = override(FEW, ["luma_posterize.levels=24"])
    with running() as (film, told, made):
        few = film.tones(FEW)
        cues = CueList((Cue(Fraction(0), FEW), Cue(Fraction(2, 25), many)))
        eventually(lambda: film.tones(cues) and made.style is cues)
        assert [film.tones(cues) > few for _ in range(3)] == [False, True, True]
        eventually(lambda: film.tones(FEW) == few)
        assert not told
