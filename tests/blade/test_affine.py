"""Affine filters, each with its own sum and a constant: trained, saved, and run on CPU and GPU."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from block_settings import style_of_an_affine_bank
from gpu import SMALL, Sessions, faults, faults_of_kinds, film_picture
from media import photograph
from pictures import noise, run_luma, step, style

from vidstyle.blade.bank_file import load_bank, save_bank
from vidstyle.blade.bins import Bins
from vidstyle.blade.choice import choose_filters
from vidstyle.blade.draw import draw_bank
from vidstyle.blade.inference import BankRun
from vidstyle.blade.regression import (
    NormalEquations,
    TrainingConfig,
    accumulate,
    as_filters,
    solve_weights,
    squared_errors,
    with_sums,
)
from vidstyle.blade.search.layouts import AUTOMATIC_LAYOUTS
from vidstyle.blade.search.trial import FilterForm, best_form
from vidstyle.cli import main
from vidstyle.style import load_style

sessions = Sessions.fixture()

TONES = """
import cv2, numpy as np

def dim(picture):
    return np.round(picture * 0.7).astype(np.uint8)

def negative(picture):
    return 255 - picture

def square_root(picture):
    return np.round(255 * np.sqrt(picture / 255)).astype(np.uint8)

def lighter(picture):
    return np.minimum(picture, 235) + 20

def soft(picture):
    return cv2.GaussianBlur(picture, (0, 0), 1)
"""
"""A user's filters: tone curves, and a blur, which keeps flat areas."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("affine")
    (made / "tones.py").write_text(TONES)
    (made / "pictures").mkdir()
    for name in ("astronaut", "chelsea", "coffee", "rocket"):
        picture = np.ascontiguousarray(photograph(name)[::3, ::3, ::-1])
        assert cv2.imwrite(str(made / "pictures" / f"{name}.png"), picture)
    return made


def trained(folder: Path, function: str, monkeypatch: pytest.MonkeyPatch, *options: str) -> Path:
    monkeypatch.syspath_prepend(folder)
    bank, images = folder / f"{function}{len(options)}.npz", str(folder / "pictures")
    source = ["--images", images, "--function", f"tones:{function}", "--hold-out", "1", "--size", "3", "-y"]
    assert main(["train", str(bank), *source, *options]) == 0
    return bank


@pytest.mark.parametrize("function", ["dim", "negative"])
def test_linear_tone_is_learned_completely(
    function: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    fidelity = load_bank(trained(folder, function, monkeypatch, "--chroma")).about["fidelity"]
    assert fidelity["explained"] > 0.999 and fidelity["psnr"] > 50
    assert fidelity["chroma psnr"] > 45 > fidelity["untouched chroma psnr"]
    said = capfd.readouterr().err
    assert "affine filters" in said and "the rest" not in said


@pytest.mark.parametrize("function", ["dim", "lighter"])
def test_change_of_colour_is_reported_for_banks_of_luma_only(
    function: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    said = []
    for options in ((), ("--chroma",)):
        trained(folder, function, monkeypatch, "--bins", "2x1x1", *options)
        said.append("the filter also changes colour" in capfd.readouterr().err)
    assert said == [function == "dim", False]


def test_tone_curve_selects_the_layout_of_tones(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bank = load_bank(trained(folder, "square_root", monkeypatch))
    assert bank.constants is not None and bank.about["fidelity"]["explained"] > 0.95
    assert bank.bins.features[0].name == "mean"


def test_filter_that_keeps_flat_areas_stays_without_constants(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    bank = load_bank(trained(folder, "soft", monkeypatch))
    assert bank.constants is None and bank.bins == AUTOMATIC_LAYOUTS[0].bins
    assert "filters that keep flat areas" in capfd.readouterr().err
    flat = np.full((40, 50), 0.3, np.float32)
    np.testing.assert_allclose(BankRun(bank).run(flat), flat, atol=1e-6)


def test_filters_are_checked_on_pictures_that_they_have_not_learned() -> None:
    """Noise cannot be learned, but many filters learn it by heart."""
    config = TrainingConfig(Bins(8, 4, 4), 1.5, 5, affine=True)
    with ThreadPoolExecutor(2) as pool:
        one, two = (
            accumulate(config, noise(90, 80, seed=seed), [noise(90, 80, seed=seed + 5)], pool)
            for seed in (1, 2)
        )
    form = FilterForm(config, (one, two, NormalEquations.empty(config)))
    expected = sum(
        squared_errors(checked, solve_weights(config, learned)).sum()
        for learned, checked in ((one, two), (two, one))
    )
    assert form.errors == pytest.approx(expected)
    by_heart = squared_errors(form.total, solve_weights(config, form.total)).sum()
    assert by_heart < 0.995 * form.errors
    only = FilterForm(config, (one, NormalEquations.empty(config)))
    assert only.errors == pytest.approx(squared_errors(one, solve_weights(config, one)).sum())


def test_equations_with_known_sums_follow_from_affine_ones() -> None:
    luma = photograph("chelsea")[:120, :160, 1].astype(np.float32) / 255
    config = TrainingConfig(Bins(8, 2, 2), 1.5, 5)
    with ThreadPoolExecutor(2) as pool:
        direct, affine = (
            accumulate(each, luma, [cv2.GaussianBlur(luma, (0, 0), 1)], pool)
            for each in (config, replace(config, affine=True))
        )
    found, derived = with_sums(replace(config, affine=True), affine)
    assert found == config
    np.testing.assert_allclose(derived.energies, direct.energies, atol=1e-4)
    found_filters, wanted = (as_filters(config, solve_weights(config, each)) for each in (derived, direct))
    np.testing.assert_allclose(found_filters, wanted, atol=1e-3)


def test_constant_is_added_before_clipping(tmp_path: Path) -> None:
    style_of_an_affine_bank(tmp_path)
    bank, luma = load_bank(tmp_path / "affine.npz"), noise(40, 50)
    chosen = choose_filters(luma, bank.bins, bank.rho)
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(luma, 2, mode="edge"), (5, 5))
    assert bank.constants is not None
    expected = np.einsum("yxij,yxij->yx", windows, bank.filters[0][chosen]) + bank.constants[0, chosen, 0]
    found = BankRun(bank).run(luma)
    np.testing.assert_allclose(found, np.clip(expected, *BankRun(bank).limits), atol=1e-5)
    assert (found == BankRun(bank).limits[0]).any(), "some results are clipped"
    half = BankRun(bank, (0.5,), 0.5).run(luma)
    np.testing.assert_allclose(half, np.clip((expected + luma) / 2, *BankRun(bank).limits), atol=1e-5)


def test_affine_bank_gives_same_result_on_cpu_and_gpu(sessions: Sessions, tmp_path: Path) -> None:
    look = load_style(style_of_an_affine_bank(tmp_path))
    assert faults_of_kinds(sessions, look) == []


def test_bank_runs_at_its_scale(folder: Path, monkeypatch: pytest.MonkeyPatch, sessions: Sessions) -> None:
    bank = trained(folder, "soft", monkeypatch, "--scale", "0.5")
    assert load_bank(bank).scale == 0.5
    luma = photograph("chelsea")[:100, :120, 1].astype(np.float32) / 255
    look = replace(style(step("learned", bank=bank.name)), folder=folder)
    expected = BankRun(load_bank(bank), scale=0.5).whole(luma)
    np.testing.assert_allclose(run_luma(look, luma), expected, atol=1e-6)
    assert not (lines := faults(sessions, look, film_picture(*SMALL), "at half size")), "\n".join(lines)


def test_saved_bank_keeps_constants_and_scale(tmp_path: Path) -> None:
    style_of_an_affine_bank(tmp_path)
    bank = replace(load_bank(tmp_path / "affine.npz"), scale=0.25)
    save_bank(bank, tmp_path / "again.npz")
    found = load_bank(tmp_path / "again.npz")
    assert found.constants is not None and bank.constants is not None
    np.testing.assert_array_equal(found.constants, bank.constants)
    assert (found.scale, found.about) == (0.25, bank.about)


def test_constants_are_drawn(tmp_path: Path) -> None:
    style_of_an_affine_bank(tmp_path)
    bank = load_bank(tmp_path / "affine.npz")
    assert len(draw_bank(bank)) > len(draw_bank(replace(bank, constants=None)))


WRONG = {
    "format of banks without constants": {"format": np.int32(1)},
    "too few constants": {"constants": np.zeros((1, 2, 3), np.float32)},
    "constants of too few planes": {"constants": np.zeros((1, 128, 1), np.float32)},
    "constants of another type": {"constants": np.zeros((1, 128, 3))},
    "a constant that is NaN": {"constants": np.full((1, 128, 3), np.nan, np.float32)},
    "no scale": {"about": np.frombuffer(b'{"scale": 0}', np.uint8)},
    "a scale that is a list": {"about": np.frombuffer(b'{"scale": [1]}', np.uint8)},
    "a scale above 1": {"about": np.frombuffer(b'{"scale": 1.5}', np.uint8)},
}


@pytest.mark.parametrize("name", WRONG)
def test_invalid_affine_bank_is_refused(name: str, tmp_path: Path) -> None:
    style_of_an_affine_bank(tmp_path)
    with np.load(tmp_path / "affine.npz") as found:
        np.savez(tmp_path / "wrong.npz", **({each: found[each] for each in found.files} | WRONG[name]))
    with pytest.raises(ValueError, match="format|constants|NaN|scale"):
        load_bank(tmp_path / "wrong.npz")


def test_later_affine_layout_needs_no_more_gain_than_other_layouts() -> None:
    """Only the change from filters that keep flat areas to affine ones needs a larger gain."""

    def trial(kept: float, affine: float) -> SimpleNamespace:
        config = TrainingConfig(Bins(2, 1, 1), 1.5, 3)
        forms = [
            SimpleNamespace(config=replace(config, affine=is_affine), errors=errors)
            for is_affine, errors in ((False, kept), (True, affine))
        ]
        return SimpleNamespace(forms=lambda: [[each] for each in forms], change=1.0)

    def least(*trials: SimpleNamespace) -> float:
        return best_form(trials)[1]  # type: ignore[arg-type]

    assert least(trial(0.5, 0.49)) == 0.5 and least(trial(0.5, 0.47)) == 0.47
    assert least(trial(0.5, 0.47), trial(0.5, 0.46)) == 0.46
    assert least(trial(0.5, 0.47), trial(0.5, 0.467)) == 0.47
