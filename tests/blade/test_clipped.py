"""Banks with clipped differences and two stages: computed, trained, saved, and run on CPU and GPU."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from block_settings import style_of_a_clipped_bank
from gpu import Sessions, faults_of_kinds
from media import photograph
from pictures import noise

from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import load_bank, save_bank
from vidstyle.blade.bins import Bins, Feature
from vidstyle.blade.choice import choose_filters
from vidstyle.blade.draw import draw_bank
from vidstyle.blade.inference import BankRun
from vidstyle.blade.regression import (
    TrainingConfig,
    accumulate,
    as_filters,
    clipped_of,
    constants_of,
    solve_weights,
    squared_errors,
)
from vidstyle.blade.search import best_bank
from vidstyle.blade.search.trial import Trial
from vidstyle.blade.symmetry import SYMMETRIES
from vidstyle.cli import main
from vidstyle.style import load_style

sessions = Sessions.fixture()

FIXTURES = Path(__file__).parent.parent / "fixtures" / "banks"


@pytest.fixture
def bank(tmp_path: Path) -> Bank:
    style_of_a_clipped_bank(tmp_path)
    return load_bank(tmp_path / "clipped.npz")


def slowly_filtered(bank: Bank, luma: np.ndarray) -> np.ndarray:
    """One stage, by its definition."""
    radius = bank.size // 2
    chosen = choose_filters(luma, bank.bins, bank.rho)
    padded = np.pad(luma, radius, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, (bank.size, bank.size))
    result = np.einsum("yxij,yxij->yx", windows, bank.filters[0][chosen])
    differences = windows - luma[..., None, None]
    assert bank.clipped is not None
    for number, clip in enumerate(bank.clips):
        limited = np.clip(differences, -clip / 255, clip / 255)
        result += np.einsum("yxij,yxij->yx", limited, bank.clipped[0, chosen, number])
    return np.clip(result, *BankRun(bank).limits)


def test_each_stage_adds_weighted_clipped_differences(bank: Bank) -> None:
    luma = noise(40, 50)
    first, second = bank.stages
    expected = slowly_filtered(second, slowly_filtered(first, luma))
    np.testing.assert_allclose(BankRun(bank).run(luma), expected, atol=2e-5)


def test_bands_equal_whole_picture(bank: Bank) -> None:
    luma, run = noise(90, 80), BankRun(bank, passes=2)
    whole, margin = run.run(luma), run.radius
    band = run.run(luma[10:80], (margin, margin), 10)
    inside = slice(margin, 70 - margin)
    np.testing.assert_array_equal(band[inside], whole[10:80][inside])


def test_difference_is_luma_minus_its_local_mean() -> None:
    luma = np.full((41, 41), 0.5, np.float32)
    luma[20, 20] += 8 / 255
    luma[5, 5] -= 40 / 255
    bins = Bins(2, 1, 1, features=(Feature("difference", 5, 2.0, (-15.0, 15.0)),))
    chosen = choose_filters(luma, bins, 1.5) % 5
    assert (chosen[20, 20], chosen[5, 5], chosen[35, 35]) == (3, 0, 2)


def test_saved_bank_keeps_clips_and_stages(bank: Bank, tmp_path: Path) -> None:
    assert bank.clips == (6.0, 20.0) and bank.next is not None and bank.next.clips == (4.0,)
    assert not {"clips", "features"} & set(bank.about)
    save_bank(bank, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "clipped.npz").read_bytes()


def test_earlier_readers_refuse_these_banks(tmp_path: Path) -> None:
    style_of_a_clipped_bank(tmp_path)
    with np.load(tmp_path / "clipped.npz") as arrays:
        assert arrays["format"] == 3


DAMAGES = {
    "clips that decrease": lambda bank: {"clips": (20.0, 6.0)},
    "no weights": lambda bank: {"clipped": None},
    "no clips": lambda bank: {"clips": ()},
    "NaN": lambda bank: {"clipped": np.full_like(bank.clipped, np.nan)},
    "asymmetric": lambda bank: {"clipped": np.triu(bank.clipped)},
    "three stages": lambda bank: {"next": bank},
    "other scale": lambda bank: {"next": replace(bank, next=None, scale=0.5)},
}


@pytest.mark.parametrize("name", DAMAGES)
def test_invalid_bank_is_refused(name: str, bank: Bank) -> None:
    with pytest.raises(ValueError, match="has"):
        replace(bank, **DAMAGES[name](bank))


def test_second_stage_in_second_stage_is_refused(bank: Bank, tmp_path: Path) -> None:
    save_bank(bank, tmp_path / "two.npz")
    with np.load(tmp_path / "two.npz") as found:
        arrays = {name: found[name] for name in found.files}
    arrays["next"] = np.frombuffer((tmp_path / "two.npz").read_bytes(), np.uint8)
    np.savez(tmp_path / "three.npz", **arrays)
    with pytest.raises(ValueError, match="second stage"):
        load_bank(tmp_path / "three.npz")


def test_bank_gives_same_result_on_cpu_and_gpu(sessions: Sessions, tmp_path: Path) -> None:
    look = load_style(style_of_a_clipped_bank(tmp_path))
    assert faults_of_kinds(sessions, look) == []


def learned(config: TrainingConfig, luma: np.ndarray, target: np.ndarray) -> tuple[Bank, float]:
    """A bank of one part, and its mean squared error according to its equations."""
    with ThreadPoolExecutor(2) as pool:
        sums = accumulate(config, luma, [target], pool)
    weights = solve_weights(config, sums)
    filters, clipped = as_filters(config, weights), clipped_of(config, weights)
    constants = constants_of(config, weights)
    bank = Bank(config.bins, config.rho, filters, constants=constants, clips=config.clips, clipped=clipped)
    return bank, float(squared_errors(sums, weights).sum() / sums.samples.sum())


@pytest.mark.parametrize("affine", [False, True])
def test_training_recovers_clipped_differences(affine: bool) -> None:
    """The target is a bank of this form, with a different weight in each bin."""
    bins = Bins(2, 1, 1, features=(Feature("difference", 3, 1.0, (-60.0, 60.0)),))
    config = TrainingConfig(bins, 1.5, 3, smoothness=0, prior_samples=0.01, clips=(5.0, 30.0), affine=affine)
    filters = np.zeros((1, bins.count, 3, 3), np.float32)
    filters[:, :, 1, 1] = 1
    clipped = np.zeros((1, bins.count, 2, 3, 3), np.float32)
    for number in range(3):
        clipped[0, number::3, :, (0, 1, 1, 2), (1, 0, 2, 1)] = (0.1 * number, -0.02 * number)
    expected = Bank(bins, 1.5, filters, clips=config.clips, clipped=clipped)
    luma = noise(90, 80)
    bank, error = learned(config, luma, BankRun(expected, is_wide=True).run(luma))
    assert error < 1e-7
    found = BankRun(bank, is_wide=True).run(noise(40, 50, seed=3))
    np.testing.assert_allclose(found, BankRun(expected, is_wide=True).run(noise(40, 50, seed=3)), atol=2e-3)


def test_equations_give_the_error_of_the_bank() -> None:
    luma = photograph("chelsea")[:150, :170, 1].astype(np.float32) / 255
    target = cv2.medianBlur((255 * luma).astype(np.uint8), 5).astype(np.float32) / 255
    bins = Bins(4, 3, 1, features=(Feature("difference", 3, 2.0),))
    bank, error = learned(TrainingConfig(bins, 1.5, 5, clips=(8.0, 32.0)), luma, target)
    margin = 8
    inside = np.square(BankRun(bank, is_wide=True).run(luma) - target)[margin:-margin, margin:-margin]
    assert error == pytest.approx(float(inside.mean()), rel=0.02)
    linear, more = learned(TrainingConfig(bins, 1.5, 5), luma, target)
    assert linear.clipped is None and error < 0.9 * more


def test_clipped_filters_have_the_eight_symmetries() -> None:
    luma = photograph("chelsea")[:150, :170, 1].astype(np.float32) / 255
    target = cv2.medianBlur((255 * luma).astype(np.uint8), 5).astype(np.float32) / 255
    bank, _ = learned(TrainingConfig(Bins(8, 2, 1), 1.5, 3, clips=(8.0,)), luma, target)
    assert bank.clipped is not None
    for symmetry in SYMMETRIES:
        for number in range(bank.bins.count):
            image = bank.clipped[0, symmetry.bin_of(bank.bins, number), 0]
            for down in (-1, 0, 1):
                for right in (-1, 0, 1):
                    moved = symmetry.moved(down, right)
                    expected = bank.clipped[0, number, 0, 1 + down, 1 + right]
                    assert image[1 + moved[0], 1 + moved[1]] == pytest.approx(expected, abs=1e-5)


FILTERS = """
import cv2, numpy as np

def bilateral(picture):
    return cv2.cvtColor(cv2.bilateralFilter(picture[..., 0], 5, 25, 2), cv2.COLOR_GRAY2RGB)

def median_twice(picture):
    median = cv2.medianBlur(cv2.medianBlur(picture[..., 0], 3), 3)
    return cv2.cvtColor(np.round(0.93 * median).astype(np.uint8), cv2.COLOR_GRAY2RGB)
"""
"""A user's filters of gray pictures: smoothing that keeps edges, and one wider than a small filter. Its tones
would be wrong if the second stage learned from the picture, not from the result of the first."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("clipped")
    (made / "edges.py").write_text(FILTERS)
    (made / "pictures").mkdir()
    for name in ("astronaut", "chelsea", "coffee", "rocket"):
        picture = np.ascontiguousarray(photograph(name)[::2, ::2, 1])
        assert cv2.imwrite(str(made / "pictures" / f"{name}.png"), picture)
    return made


def trained(folder: Path, function: str, monkeypatch: pytest.MonkeyPatch, *options: str) -> Bank:
    monkeypatch.syspath_prepend(folder)
    arguments = ["--images", str(folder / "pictures"), "--function", f"edges:{function}", "--hold-out", "1"]
    assert main(["train", str(folder / "bank.npz"), *arguments, "-y", *options]) == 0
    return load_bank(folder / "bank.npz")


def test_smoothing_that_keeps_edges_selects_clipped_differences(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    bank = trained(folder, "bilateral", monkeypatch, "--size", "5", "--stages", "1")
    assert bank.clips and bank.next is None and bank.about["fidelity"]["explained"] > 0.9
    assert "differences also clipped to" in capfd.readouterr().err
    linear = trained(folder, "bilateral", monkeypatch, "--size", "5", "--bins", "8x20x4")
    assert not linear.clips and linear.about["fidelity"]["explained"] < 0.8


def test_large_filters_are_learned_for_the_best_layout_of_small_ones(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = []

    class Recorded(Trial):
        def __init__(self, config: TrainingConfig, chroma: bool) -> None:
            tried.append((config.size, config.clips))
            super().__init__(config, chroma)

    monkeypatch.setattr(best_bank, "Trial", Recorded)
    monkeypatch.setattr(best_bank, "MAX_SEARCH_SIZE_PX", 3)
    bank = trained(folder, "bilateral", monkeypatch, "--size", "5", "--stages", "1")
    assert [each for each in tried if each[0] != 3] == [(5, bank.clips)]
    assert len(tried) > 2 and bank.size == 5


def test_second_stage_is_trained_if_it_gains(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    layout = ["--size", "3", "--bins", "2x4x1", "--feature", "difference=5@1", "--clip", "8", "--clip", "32"]
    one = trained(folder, "median_twice", monkeypatch, *layout, "--stages", "1")
    two = trained(folder, "median_twice", monkeypatch, *layout)
    assert one.next is None and two.next is not None and two.next.clips == (8.0, 32.0)
    assert "second stage" in capfd.readouterr().err
    rests = [1 - each.about["fidelity"]["explained"] for each in (one, two)]
    assert rests[1] < 0.9 * rests[0], rests
    assert draw_bank(two).shape[0] > draw_bank(one).shape[0]
    whole = trained(folder, "bilateral", monkeypatch, "--size", "3", "--bins", "2x1x1", "--scale", "0.5")
    assert whole.next is None or whole.next.scale == 0.5


def test_invalid_clips_are_reported(capfd: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    arguments = ["train", str(tmp_path / "x.npz"), "--reference", "tv_flow"]
    clips = [word for level in (1, 2, 3, 4) for word in ("--clip", str(level))]
    assert main([*arguments, *clips]) == 2
    said = capfd.readouterr().err
    assert "--clip is given 4 times" in said and said.count("\n") == 1


@pytest.mark.parametrize("name", ["rich", "affine"])
def test_banks_of_earlier_versions_are_unchanged(name: str, tmp_path: Path) -> None:
    """Files by versions without clips and stages are read, and written again with equal bytes."""
    path = FIXTURES / f"{name}.npz"
    save_bank(load_bank(path), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == path.read_bytes()
