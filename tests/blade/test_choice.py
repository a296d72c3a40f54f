"""Banks with additional features and filters for chroma: trained, saved, and run on CPU and GPU."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from gpu import Sessions, faults_of_kinds
from media import photograph
from pictures import noise

from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import load_bank, save_bank
from vidstyle.blade.bins import Bins, Feature
from vidstyle.blade.choice import choose_filters
from vidstyle.blade.inference import BankRun
from vidstyle.blade.photographs import chroma_of, luma_of
from vidstyle.blade.training import psnr
from vidstyle.cli import main
from vidstyle.style import load_style

sessions = Sessions.fixture()

DARK_SOFT_PALE = """
import cv2, numpy as np

def dark_soft_pale(picture):
    luma, *chroma = cv2.split(cv2.cvtColor(picture, cv2.COLOR_RGB2YCrCb).astype(np.float32))
    dark = cv2.GaussianBlur(luma, (0, 0), 2) < 127.5
    luma = np.where(dark, cv2.GaussianBlur(luma, (0, 0), 1), luma)
    chroma = [(cv2.GaussianBlur(each, (0, 0), 1) - 128) * 0.5 + 128 for each in chroma]
    merged = cv2.merge([luma, *chroma]).round().clip(0, 255).astype(np.uint8)
    return cv2.cvtColor(merged, cv2.COLOR_YCrCb2RGB)
"""
"""A user's filter: blurs dark areas, and blurs chroma and halves it."""


BINS = Bins(8, 1, 3, features=(Feature("strength", 2, 4.0),))


def some_bank() -> Bank:
    filters = np.random.default_rng(1).normal(0, 0.1, (1, BINS.count, 5, 5)).astype(np.float32)
    return Bank(BINS, 1.5, filters, {"imitates": "nothing"}, filters / 2)


def saved_with(path: Path, **arrays: np.ndarray) -> None:
    """Save a bank with other arrays in the file."""
    save_bank(some_bank(), path)
    with np.load(path) as found:
        np.savez(path, **({name: found[name] for name in found.files} | arrays))


@pytest.fixture(scope="module")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a bank for this filter and a style that uses it."""
    folder = tmp_path_factory.mktemp("dark")
    (folder / "dark.py").write_text(DARK_SOFT_PALE)
    (folder / "pictures").mkdir()
    for name in ("astronaut", "coffee"):
        picture = np.ascontiguousarray(photograph(name)[::2, ::2, ::-1])
        assert cv2.imwrite(str(folder / "pictures" / f"{name}.png"), picture)
    arguments = ["--images", str(folder / "pictures"), "--function", "dark:dark_soft_pale", "--hold-out", "0"]
    shape = ["--bins", "4x1x1x3", "--size", "5", "--feature", "mean=6@2", "--feature", "coherence=2@3"]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        assert main(["train", str(folder / "dark.npz"), *arguments, *shape, "--chroma"]) == 0
    step = '[[background]]\nblock = "learned"\nbank = "dark.npz"\npasses = 2\n'
    (folder / "dark.toml").write_text(f"format = 1\n{step}")
    return folder


def test_bank_is_trained_by_local_mean_and_for_chroma(trained: Path) -> None:
    bank = load_bank(trained / "dark.npz")
    assert bank.bins.features == (
        Feature("mean", 6, 2.0, (0.0, 255.0)),
        Feature("coherence", 2, 3.0, (0.2, 0.8)),
    )
    assert bank.filters.shape == (1, 144, 5, 5) and bank.bins.curvatures == 3
    assert not {"features", "curvatures"} & set(bank.about)
    np.testing.assert_allclose(bank.of_chroma.sums, 0.5, atol=0.02)
    color = photograph("chelsea")[:200, :200].astype(np.float32) / 255
    luma, chroma = luma_of(color), tuple(chroma_of(color))
    soft = cv2.GaussianBlur(luma, (0, 0), 1)
    wanted = np.where(cv2.GaussianBlur(luma, (0, 0), 2) < 0.5, soft, luma)
    run = BankRun(bank)
    assert psnr(run.run(luma), wanted) > psnr(luma, wanted) + 15
    halved = np.stack([cv2.GaussianBlur(each, (0, 0), 1) / 2 for each in chroma])
    assert psnr(np.stack(run.run_chroma(luma, chroma)), halved) > 45


def test_bank_gives_same_result_on_cpu_and_gpu(trained: Path, sessions: Sessions) -> None:
    look = load_style(trained / "dark.toml")
    assert faults_of_kinds(sessions, look) == []


@pytest.mark.parametrize("name", ["dark.hook", "dark.html"])
def test_bank_runs_in_exported_styles(name: str, trained: Path, tmp_path: Path) -> None:
    size = ["--size", "160x90"] if name.endswith("hook") else []
    assert main(["export", str(trained / "dark.toml"), str(tmp_path / name), *size]) == 0
    assert "divided_choice" in (tmp_path / name).read_text()


def test_saved_bank_keeps_features_and_chroma(tmp_path: Path) -> None:
    bank = some_bank()
    save_bank(bank, tmp_path / "bank.npz")
    found = load_bank(tmp_path / "bank.npz")
    assert found.bins.features == (Feature("strength", 2, 4.0, (10.0, 40.0)),)
    assert found.chroma is not None and bank.chroma is not None and found.about == bank.about
    np.testing.assert_array_equal(found.chroma, bank.chroma)


@pytest.mark.parametrize(
    "features",
    [
        7,
        [["mean", 2, 1, 0, 255]] * 3,
        [["hue", 2, 1, 0, 255]],
        [["mean", 2.5, 1, 0, 255]],
        [["mean", 0, 1, 0, 255]],
        [["mean", 2, 9, 0, 255]],
        [["mean", 2, 1, 255, 255]],
        [["mean", 2, 1, 0]],
        [["mean", 5, 1, 0, 255]],
        [["mean", 2, 1, 0, 5e-324]],
    ],
)
def test_invalid_features_are_refused(features: object, tmp_path: Path) -> None:
    path = tmp_path / "bank.npz"
    saved_with(path, about=np.frombuffer(json.dumps({"features": features}).encode(), np.uint8))
    with pytest.raises(ValueError, match="feature|filters|window"):
        load_bank(path)


def test_saved_bank_keeps_curvatures(tmp_path: Path) -> None:
    bins = Bins(8, 1, 2, curvatures=5)
    save_bank(
        replace(some_bank(), bins=bins, filters=np.zeros((1, 80, 5, 5), np.float32), chroma=None),
        tmp_path / "a",
    )
    assert load_bank(tmp_path / "a").bins == bins


@pytest.mark.parametrize("curvatures", [0, -1, 2.0, "2", [2], 7])
def test_invalid_curvatures_are_refused(curvatures: object, tmp_path: Path) -> None:
    path = tmp_path / "bank.npz"
    saved_with(path, about=np.frombuffer(json.dumps({"curvatures": curvatures}).encode(), np.uint8))
    with pytest.raises(ValueError, match="has bins|filters for"):
        load_bank(path)


@pytest.mark.parametrize("step", [0, 3, 2.0, "2", [2], 2])
def test_invalid_pitch_is_refused(step: object, tmp_path: Path) -> None:
    """Only squares of 2 x 2 pixels can share a filter, without additional features."""
    path = tmp_path / "bank.npz"
    about = {"step": step, "features": [["strength", 2, 4.0, 10, 40]]}
    saved_with(path, about=np.frombuffer(json.dumps(about).encode(), np.uint8))
    with pytest.raises(ValueError, match="in squares"):
        load_bank(path)


@pytest.mark.parametrize("anything", [3e38, -3e38, np.inf, np.nan])
def test_margin_values_do_not_affect_result(anything: float) -> None:
    bins, luma = Bins(8, 1, 3, curvatures=3, features=(Feature("mean", 4, 1.0),)), noise(60, 40)
    expected = choose_filters(luma, bins, 1.0)[20:40]
    luma[:10] = luma[50:] = anything
    np.testing.assert_array_equal(choose_filters(luma, bins, 1.0, (20, 20))[20:40], expected)


def test_bank_needs_equal_numbers_of_luma_and_chroma_filters(tmp_path: Path) -> None:
    path = tmp_path / "bank.npz"
    saved_with(path, chroma=np.zeros((1, 3, 5, 5), np.float32))
    with pytest.raises(ValueError, match="for chroma of shape"):
        load_bank(path)


@pytest.mark.parametrize(
    ("option", "reason"),
    [
        (["--feature", "hue=2@1"], "hue=2@1 is not NAME=BINS@RHO"),
        (["--feature", "mean=2"], "mean=2 is not NAME=BINS@RHO"),
        (["--feature", "mean=2@9"], "names are mean, difference, strength"),
        (["--feature", "mean=2@1"] * 3, "is given 3 times"),
        (["--feature", "mean=99@1"], "use at most 1024"),
    ],
)
def test_invalid_feature_options_are_reported_before_reading_pictures(
    option: list[str], reason: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    arguments = ["train", str(tmp_path / "x.npz"), "--reference", "tv_flow", *option]
    assert main(arguments) == 2
    said = capfd.readouterr().err
    assert reason in said and said.count("\n") == 1
