"""Banks with a colour matrix: found, trained, saved, and run on CPU and GPU."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from block_settings import style_of_a_bank_with_a_matrix
from gpu import Sessions, faults_of_kinds
from media import photograph

import vidstyle
from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import load_bank, save_bank
from vidstyle.blade.search.color_matrix import find_color_matrix
from vidstyle.cli import main
from vidstyle.style import load_style

sessions = Sessions.fixture()

SEPIA = np.array([[0.393, 0.769, 0.189], [0.349, 0.686, 0.168], [0.272, 0.534, 0.131]], np.float32)
NAMES = ("astronaut", "chelsea", "coffee", "rocket")
MIXES = f"""
import cv2, numpy as np

def sepia(picture):
    return np.clip(picture @ np.array({SEPIA.tolist()}).T, 0, 255).round().astype(np.uint8)

def soft(picture):
    return cv2.GaussianBlur(picture, (0, 0), 1)
"""
"""A user's filters: sepia, whose highlights are clipped, and a blur, which mixes no channels."""


def color(name: str) -> np.ndarray:
    return np.ascontiguousarray(photograph(name)[::3, ::3]).astype(np.float32) / 255


@pytest.fixture
def bank(tmp_path: Path) -> Bank:
    style_of_a_bank_with_a_matrix(tmp_path)
    return load_bank(tmp_path / "matrix.npz")


def test_matrix_is_found_although_results_are_clipped() -> None:
    pictures = [color(name) for name in NAMES]
    found = find_color_matrix([(each, np.clip(each @ SEPIA.T, 0, 1)) for each in pictures])
    assert found is not None
    np.testing.assert_allclose(found, np.column_stack([SEPIA, np.zeros(3)]), atol=0.01)


@pytest.mark.parametrize("target", ["gray", "negative", "blurred", "none"])
def test_filters_that_mix_no_channels_get_no_matrix(target: str) -> None:
    change = {
        "gray": lambda each: each @ np.array([0.2126, 0.7152, 0.0722], np.float32),
        "negative": lambda each: 1 - each,
        "blurred": lambda each: cv2.GaussianBlur(each, (0, 0), 2),
        "none": lambda each: each,
    }[target]
    assert find_color_matrix([(color(name), change(color(name))) for name in NAMES]) is None


@pytest.mark.parametrize("pictures", [[], [(np.zeros((3, 3, 3), np.float32),) * 2]])
def test_too_few_pixels_give_no_matrix(pictures: list[tuple[np.ndarray, np.ndarray]]) -> None:
    assert find_color_matrix(pictures, chroma=True) is None


@pytest.mark.parametrize(("function", "chroma"), [("sepia", False), ("sepia", True), ("soft", True)])
def test_mixing_filter_is_learned_with_a_matrix(
    function: str,
    chroma: bool,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "mixes.py").write_text(MIXES)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "pictures").mkdir()
    for name in NAMES:
        picture = np.ascontiguousarray(photograph(name)[::3, ::3, ::-1])
        assert cv2.imwrite(str(tmp_path / "pictures" / f"{name}.png"), picture)
    source = ["--images", str(tmp_path / "pictures"), "--function", f"mixes:{function}", "--hold-out", "1"]
    options = ["--size", "3", "--bins", "4x2x1", *(["--chroma"] if chroma else [])]
    assert main(["train", str(tmp_path / "mix.npz"), *source, *options]) == 0
    bank, said = load_bank(tmp_path / "mix.npz"), capfd.readouterr().err
    assert (bank.matrix is not None) == (function == "sepia") == ("a colour matrix" in said)
    if bank.matrix is not None:
        assert bank.about["fidelity"]["explained"] > 0.995
        assert not chroma or bank.about["fidelity"]["chroma psnr"] > 45
        assert (bank.next, bank.constants) == (None, None)  # nothing else is left to learn


def test_saved_bank_keeps_its_matrix(bank: Bank, tmp_path: Path) -> None:
    save_bank(bank, tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == (tmp_path / "matrix.npz").read_bytes()
    with np.load(tmp_path / "matrix.npz") as arrays:
        assert arrays["format"] == 4  # earlier readers would leave it out


DAMAGES = {
    "shape": lambda bank: {"matrix": np.eye(3, dtype=np.float32)},
    "type": lambda bank: {"matrix": bank.matrix.astype(np.float64)},
    "NaN": lambda bank: {"matrix": np.full_like(bank.matrix, np.nan)},
    "second stage": lambda bank: {"next": replace(bank, chroma=None), "chroma": None},
}


@pytest.mark.parametrize("name", DAMAGES)
def test_invalid_matrix_is_refused(name: str, bank: Bank) -> None:
    with pytest.raises(ValueError, match="has"):
        replace(bank, **DAMAGES[name](bank))


@pytest.mark.parametrize("amount", [0.0, 0.5, 1.0])
def test_matrix_is_weighted_by_the_amount(amount: float, bank: Bank, tmp_path: Path) -> None:
    """With identity filters, only the matrix has an effect."""
    filters = np.zeros_like(bank.filters)
    filters[:, :, 2, 2] = 1
    save_bank(replace(bank, filters=filters, chroma=filters, scale=1.0), tmp_path / "matrix.npz")
    text = f'format = 1\n[[background]]\nblock = "learned"\nbank = "matrix.npz"\namount = {amount}\n'
    (tmp_path / "matrix.toml").write_text(text)
    source = photograph("coffee")[::4, ::4].astype(np.float32) / 255
    assert bank.matrix is not None
    whole = (
        np.column_stack([source.reshape(-1, 3), np.ones(source[..., 0].size)])
        @ (amount * bank.matrix + (1 - amount) * np.eye(3, 4)).T
    )
    result = vidstyle.stylize(source, load_style(tmp_path / "matrix.toml"), "cpu")
    np.testing.assert_allclose(result.reshape(-1, 3), whole.clip(0, 1), atol=2e-3)


def test_gray_pictures_are_coloured(bank: Bank, tmp_path: Path) -> None:
    gray = np.repeat(photograph("coffee")[::4, ::4, 1:2], 3, axis=2)
    result = vidstyle.stylize(np.ascontiguousarray(gray), load_style(tmp_path / "matrix.toml"), "cpu")
    assert np.ptp(result.astype(int), axis=2).mean() > 10


def test_bank_gives_same_result_on_cpu_and_gpu(sessions: Sessions, tmp_path: Path) -> None:
    assert faults_of_kinds(sessions, load_style(style_of_a_bank_with_a_matrix(tmp_path))) == []
