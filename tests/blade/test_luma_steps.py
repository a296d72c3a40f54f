"""Steps of luma before a bank: computed, found in training, saved, and run on CPU and GPU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from block_settings import style_of_a_bank_with_luma_steps
from gpu import Sessions, faults_of_kinds
from media import photograph
from pictures import noise

import vidstyle
from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import load_bank, save_bank
from vidstyle.blade.before.local_mode import local_mode
from vidstyle.blade.before.luma_steps import luma_steps, prepare
from vidstyle.blade.photographs import luma_of
from vidstyle.blade.search.luma_step import find_luma_step
from vidstyle.cli import main
from vidstyle.style import load_style, resolve

sessions = Sessions.fixture()

NAMES = ("astronaut", "chelsea", "coffee", "rocket")
STRAIGHT = np.array([[2, 0.0], [97, 1.0]], np.float32)
FILTERS = """
import cv2, numpy as np

calls = 0

def stretch(picture):
    global calls
    calls += 1
    luma = picture @ np.array([0.2126, 0.7152, 0.0722])
    low, high = np.percentile(luma, (2, 97))
    return np.clip((picture - low) * (255 / (high - low)), 0, 255).round().astype(np.uint8)

def oil(picture):
    return cv2.xphoto.oilPainting(picture, 3, 4)

def soft(picture):
    return cv2.GaussianBlur(picture, (0, 0), 2)
"""
"""A user's filters: contrast by percentiles, oil paint, and one that needs no step before its bank."""


def luma(name: str) -> np.ndarray:
    return luma_of(np.ascontiguousarray(photograph(name)[::3, ::3]).astype(np.float32) / 255)


def mode_of(values: np.ndarray, radius: int, exponent: int) -> np.ndarray:
    return np.asarray(
        local_mode(values, radius=radius, exponent=exponent, margin=(0, 0), out=np.empty_like(values))
    )


def slow_mode(values: np.ndarray, radius: int, exponent: int) -> np.ndarray:
    """The local mode by its definition."""
    side = 2 * radius + 1
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, radius, "edge"), (side, side))
    windows = windows.reshape(*values.shape, -1, 1).astype(np.float64)
    shares = np.maximum(1 - np.abs(31 * windows - np.arange(32)), 0)
    counts, tones = shares.sum(axis=2), (shares * windows).sum(axis=2)
    weights = counts ** (exponent - 1)
    return np.asarray((weights * tones).sum(axis=2) / (weights * counts).sum(axis=2))


@pytest.mark.parametrize(("radius", "exponent"), [(1, 1), (2, 4), (8, 8)])
def test_local_mode_is_weighted_by_a_power_of_the_histogram(radius: int, exponent: int) -> None:
    values = np.clip(cv2.GaussianBlur(noise(23, 31), (0, 0), 2) * 4 - 1.5, 0, 1)
    np.testing.assert_allclose(
        mode_of(values, radius, exponent), slow_mode(values, radius, exponent), atol=5e-3
    )


@pytest.mark.parametrize("tone", [0.0, 0.4321, 1.0])
def test_local_mode_keeps_flat_areas(tone: float) -> None:
    flat = np.full((1, 5), tone, np.float32)
    np.testing.assert_allclose(mode_of(flat, 8, 8), flat, atol=1e-4)


@pytest.mark.parametrize("curve", [STRAIGHT, np.array([[5, 0], [30, 0.4], [70, 0.5], [95, 1]], np.float32)])
def test_curve_maps_percentiles_to_levels(curve: np.ndarray) -> None:
    given = np.linspace(0.2, 0.7, 300 * 300, dtype=np.float32).reshape(300, 300)
    wanted = np.interp(np.linspace(0, 100, given.size), *curve.T).reshape(given.shape)
    inside = (given > 0.235) & (given < 0.67)
    found = prepare(given, luma_steps(curve, None))
    np.testing.assert_allclose(found[inside], wanted[inside], atol=2e-3)


def test_curve_of_a_flat_picture_is_finite() -> None:
    assert np.isfinite(prepare(np.full((4, 4), 0.5, np.float32), luma_steps(STRAIGHT, None))).all()


def test_step_is_found() -> None:
    pictures = [luma(name) for name in NAMES]
    step, rest = find_luma_step([(each, mode_of(each, 3, 6)) for each in pictures])
    assert step["mode"].tolist() == [3, 6] and rest < 1e-6
    step, rest = find_luma_step([(each, prepare(each, luma_steps(STRAIGHT, None))) for each in pictures])
    np.testing.assert_allclose(step["curve"], STRAIGHT, atol=0.3)
    assert rest < 0.01


def test_step_must_help_with_half_of_the_pictures() -> None:
    pictures = [luma(name) for name in NAMES]
    (first, *others), steps = pictures, luma_steps(STRAIGHT, None)
    assert find_luma_step([(first, prepare(first, steps)), *zip(others, others, strict=True)])[0] == {}


@pytest.mark.parametrize(
    ("function", "step", "least"), [("stretch", "curve", 0.9), ("oil", "mode", 0.6), ("soft", "", 0.5)]
)
def test_step_is_trained_if_it_explains_more(
    function: str,
    step: str,
    least: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / f"{function}_filters.py").write_text(FILTERS)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "pictures").mkdir()
    for name in NAMES:
        picture = np.ascontiguousarray(photograph(name)[::3, ::3, ::-1])
        assert cv2.imwrite(str(tmp_path / "pictures" / f"{name}.png"), picture)
    source = ["--images", str(tmp_path / "pictures"), "--function", f"{function}_filters:{function}"]
    options = ["--hold-out", "1", "--size", "3", "--bins", "4x2x1"]
    assert main(["train", str(tmp_path / "it.npz"), *source, *options]) == 0
    bank, said = load_bank(tmp_path / "it.npz"), capfd.readouterr().err
    assert (bank.curve is not None, bank.mode is not None) == (step == "curve", step == "mode")
    assert ("before the filters" in said) == bool(step)
    assert bank.about["fidelity"]["explained"] > least


def test_filter_runs_once_on_each_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "counted_filters.py").write_text(FILTERS)
    monkeypatch.syspath_prepend(tmp_path)
    for name in NAMES[:3]:
        assert cv2.imwrite(str(tmp_path / f"{name}.png"), photograph(name)[::8, ::8])
    from vidstyle.blade.bins import Bins
    from vidstyle.blade.photographs import photographs_in
    from vidstyle.blade.reference_filter import reference_by_function
    from vidstyle.blade.regression import TrainingConfig
    from vidstyle.blade.search import best_bank

    monkeypatch.setattr(best_bank, "MAX_SEARCH_SIZE_PX", 3)
    configs = [TrainingConfig(bins, 1.5, size=5) for bins in (Bins(2, 1, 1), Bins(4, 2, 1))]
    reference = reference_by_function("counted_filters:stretch")
    best_bank.train_best(configs, reference, photographs_in(tmp_path, 100), stages=2)
    import counted_filters  # type: ignore[import-not-found]

    assert counted_filters.calls == 3


@pytest.fixture
def bank(tmp_path: Path) -> Bank:
    style_of_a_bank_with_luma_steps(tmp_path)
    return load_bank(tmp_path / "steps.npz")


def test_saved_bank_keeps_its_steps(bank: Bank, tmp_path: Path) -> None:
    save_bank(bank, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "steps.npz").read_bytes()
    with np.load(tmp_path / "steps.npz") as arrays:
        assert arrays["format"] == 5  # earlier readers would leave them out


DAMAGES = {
    "shape of the curve": lambda bank: {"curve": bank.curve[:3]},
    "order of percentages": lambda bank: {"curve": bank.curve[::-1]},
    "NaN": lambda bank: {"curve": np.full_like(bank.curve, np.nan)},
    "type of the mode": lambda bank: {"mode": bank.mode.astype(np.float32)},
    "radius": lambda bank: {"mode": np.array([9, 4], np.int32)},
    "second stage": lambda bank: {"next": bank},
}


@pytest.mark.parametrize("name", DAMAGES)
def test_invalid_steps_are_refused(name: str, bank: Bank) -> None:
    with pytest.raises(ValueError, match="has"):
        replace(bank, **DAMAGES[name](bank))


def test_amount_of_zero_changes_nothing(bank: Bank, tmp_path: Path) -> None:
    text = 'format = 1\n[[background]]\nblock = "learned"\nbank = "steps.npz"\namount = 0\n'
    (tmp_path / "none.toml").write_text(text)
    source = np.ascontiguousarray(photograph("coffee")[::4, ::4])
    result = vidstyle.stylize(source, load_style(tmp_path / "none.toml"), "cpu")
    assert np.abs(result.astype(int) - source).max() <= 1


def test_style_measures_what_its_bank_needs(bank: Bank, tmp_path: Path) -> None:
    style = load_style(tmp_path / "steps.toml")
    (step,) = resolve.resolve(style, 90, 160)["background"]
    assert step.settle == 0.4
    values = style.background[0].values | {"bank": "etf"}
    other = replace(style, background=(replace(style.background[0], values=values),))
    (without,) = resolve.resolve(other, 90, 160)["background"]
    assert without.settle is None


def test_bank_gives_same_result_on_cpu_and_gpu(sessions: Sessions, tmp_path: Path) -> None:
    assert faults_of_kinds(sessions, load_style(style_of_a_bank_with_luma_steps(tmp_path))) == []
