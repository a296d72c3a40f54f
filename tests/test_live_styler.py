"""What takes over at once, and what is made ready first while the old style goes on."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from live import LONG, before_opening, eventually, refuse

from vidstyle.core.picture import Encoding, Picture
from vidstyle.gpu.device.choose import list_devices
from vidstyle.live import hot_swap as styler
from vidstyle.live.hot_swap import HotSwapRenderer
from vidstyle.style import Style, load_style, override

FEW = load_style(
    {"format": 1, "name": "few", "background": [{"block": "luma_posterize", "levels": 3, "softness": 0}]}
)
ENCODING = Encoding("bt709", full_range=False, depth=8, step=(2, 2))


class Film:
    """Runs the same picture through a styler again and again."""

    def __init__(self, styler: HotSwapRenderer) -> None:
        ramp = np.tile(np.linspace(0, 255, 96).astype(np.uint8), (64, 1))
        self._picture = Picture.from_array(np.dstack([ramp] * 3))
        self._styler, self._count = styler, 0

    def tones(self, style: Style) -> int:
        """How many there are in the next picture, with this style wanted."""
        self._count += 1
        picture, _ = self._styler.run(self._picture, self._count / 25, ENCODING, style)
        assert picture.luma is not None
        return len(np.unique(picture.luma))


@contextmanager
def running(device: str = "cpu") -> Iterator[tuple[Film, list[str], HotSwapRenderer]]:
    told: list[str] = []
    made = HotSwapRenderer(FEW, device, told.append)
    try:
        yield Film(made), told, made
    finally:
        made.close(LONG)


def test_values_take_over_with_the_next_picture(monkeypatch: pytest.MonkeyPatch):
    original, opened = styler.open_renderer, []

    def open_and_keep(*given: object, **named: object) -> object:
        opened.append(original(*given, **named))
        return opened[-1]

    monkeypatch.setattr(styler, "open_renderer", open_and_keep)
    with running() as (film, told, made):
        few = film.tones(FEW)
        before = len(threading.enumerate())
        for levels in range(6, 30):
            changed = override(FEW, [f"luma_posterize.levels={levels}"])
            assert film.tones(changed) > few
            assert made.style is changed
        assert film.tones(FEW) == few and not told
        assert len(opened) > 20 and len(threading.enumerate()) <= before, (
            "what ran before has let its threads go"
        )


@pytest.mark.parametrize(
    "other",
    ["poster", "plain", override(FEW, ["steady=0.5"]), Style("few", lines=FEW.background)],
    ids=["style", "plain", "steady", "layer"],
)
def test_what_has_to_be_loaded_is_made_ready_first(other: Style | str):
    other = load_style(other)
    with running() as (film, _, made):
        film.tones(FEW)
        film.tones(other)
        assert made.style is FEW
        eventually(lambda: film.tones(other) and made.style is other)


def test_a_gpu_gets_no_values_without_making_ready():
    if not list_devices():
        pytest.skip("no OpenGL here")
    with running(f"gpu:{list_devices()[0].index}") as (film, _, made):
        film.tones(FEW)
        changed = override(FEW, ["luma_posterize.levels=9"])
        film.tones(changed)
        assert made.style is FEW
        eventually(lambda: film.tones(changed) and made.style is changed)


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
        eventually(lambda: made._awaited is None)
        film.tones(changed)
        assert made.style is changed
