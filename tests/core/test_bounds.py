"""Values stay within bounds, and a style within its limits: docs/rules.md, Style safety."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from covering import DAY
from gpu import Sessions, faults
from pictures import FLOAT, noise, step, style

from vidstyle import stylize
from vidstyle.core.kernels import compiled, index_at
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.errors import InputError, StyleError
from vidstyle.style import Style, load_style, style_names
from vidstyle.style.limits import MAX_WORK, excess
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle
from vidstyle.style.resolve import resolve

sessions = Sessions.fixture()

LONG = {
    "flow_dog": [step("flow_dog", p=60)] * 16,
    "detail": [step("detail", delta=60)] * 80,
    "soft light": [step("flow_dog"), *[step("blend", mode="soft_light", opacity=1)] * 60],
    "lanczos": [step("scale", factor=factor, method="lanczos") for factor in (0.7, 1.45) * 60],
}
"""Within all ranges, and each grew beyond all floats."""

ENDLESS = {
    "works at 655360 x 491520": [step("scale", factor=4.0)] * 5,
    "operations for each pixel": [step("etf", passes=12, rho=4.0, reselect=True)] * 200,
    "GiB at once": [
        step("scale", factor=4.0),
        *[step("gaussian", f"saved{number}", sigma=1 + number / 8) for number in range(60)],
        *[step("blend", other=f"saved{number}") for number in range(60)],
    ],
}


def lowered(chosen: Style, height: int, width: int) -> LoweredStyle:
    layout = PictureLayout(Encoding(), (height, width), "chroma")
    return lower(chosen, resolve(chosen, height, width), layout, Encoding(), False)


@pytest.mark.parametrize(
    ("kind", "count"),
    [
        *[pytest.param(kind, count) for kind, count in (("pictures", 1), ("chains", 8), ("banks", 40))],
        *[pytest.param(kind, 60, marks=pytest.mark.thorough) for kind in ("chains", "banks")],
    ],
)
def test_nothing_strange_ends_the_process(kind: str, count: int) -> None:
    sweep = Path(__file__).parents[1] / "support" / "bounds_sweep.py"
    words = [sys.executable, str(sweep), kind, str(100 * DAY), str(count)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"{words}: {done.stderr}"


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 2.01, -1.01])
@pytest.mark.parametrize("dtype", [np.float16, np.float32, np.float64])
def test_floats_that_are_no_picture_are_refused(number: float, dtype: type[np.floating]) -> None:
    for channels in (3, 4):
        picture = np.full((4, 5, channels), 0.5, dtype)
        picture[1:3, 2, -1] = number
        with pytest.raises(InputError, match=r"^the picture of floats: 2 of its .* NaN or outside -1..2; "):
            stylize(picture, "plain", "cpu")


@compiled
def find_indexes(places, last, out):  # type: ignore[no-untyped-def]
    for number in range(places.size):
        out[number] = index_at(places[number], last)


def test_an_index_is_one_whatever_the_place() -> None:
    places = np.array([-3.5, 0.9, 5.99, 6, 7.5, np.nan, np.inf, -np.inf, 1e30, -1e30], np.float32)
    indexes = np.empty(places.size, np.int64)
    find_indexes(places, 6, indexes)
    assert indexes[:5].tolist() == [0, 0, 5, 6, 6]
    assert set(indexes[5:]) <= set(range(7))


@pytest.mark.parametrize("name", LONG)
def test_long_styles_stay_within_bounds(name: str) -> None:
    result = stylize(noise(24, 32, 3), style(*LONG[name]), "cpu")
    assert np.isfinite(result).all() and result.min() >= 0 and result.max() <= 1


def test_bounds_are_the_same_on_a_gpu(sessions: Sessions) -> None:
    """In one pass, and in textures between passes."""
    picture = Picture(FLOAT, luma=noise(40, 56, low=-0.9, high=1.9))
    doubled = [step("blend", mode="hard_light", opacity=1.0)] * 3
    for steps in (doubled, [*doubled, step("sobel"), *doubled], [step("flow_dog", p=60.0), *doubled]):
        chosen = style(*steps, step("soft_threshold", phi=0.002, epsilon=250.0))
        assert not faults(sessions, chosen, picture, str(len(steps)))


@pytest.mark.parametrize("reason", ENDLESS)
def test_a_style_that_takes_too_much_is_refused(reason: str) -> None:
    chosen = style(*ENDLESS[reason])
    with pytest.raises(StyleError, match=f"^test: .*{reason}.* for pictures of 640 x 480; it") as raised:
        lowered(chosen, 480, 640)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("size", [(1, 1), (48, 64), (720, 1280), (8192, 8192)])
def test_shipped_styles_are_far_below_the_limits(
    size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vidstyle.style.limits.MAX_WORK", MAX_WORK // 4)
    monkeypatch.setattr("vidstyle.style.limits.MAX_GROWTH", 4)
    for name in style_names():
        assert not excess(lowered(load_style(name), *size).outputs, size), name
