"""Settings of blocks, and styles with a single block and its inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from pictures import step

from vidstyle.blade.bank import Bank
from vidstyle.blade.bank_file import save_bank
from vidstyle.blade.bins import Bins, Feature
from vidstyle.block import Block, Choice, Slider, Switch
from vidstyle.style import Style


def ends_of(block: Block) -> dict[str, list[Any]]:
    """Return both ends of the range of each parameter, or its options."""
    ends: dict[str, list[Any]] = {}
    for name, parameter in block.parameters.items():
        control = parameter.control
        if isinstance(control, Slider):
            ends[name] = [parameter.check(control.low), parameter.check(control.high)]
        elif isinstance(control, Choice):
            ends[name] = list(control.options)
        elif isinstance(control, Switch):
            ends[name] = [False, True]
    return ends


def settings(block: Block) -> list[dict[str, Any]]:
    """Return the defaults, each parameter at each end or option, and all parameters at the same end."""
    ends = ends_of(block)
    single = [{name: value} for name, values in ends.items() for value in values]
    corners = [{name: values[corner] for name, values in ends.items()} for corner in (0, -1)] if ends else []
    return [{}, *single, *corners]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of a style with a bank and three tiles: a wide, a tall and a square one."""
    folder = tmp_path_factory.mktemp("style")
    (folder / "tiles").mkdir()
    random = np.random.default_rng(1)
    for number, size in enumerate([(5, 31), (40, 7), (12, 12)]):
        tile = random.integers(60 * number, 60 * number + 130, size).astype(np.uint8)
        assert cv2.imwrite(str(folder / "tiles" / f"{number}.png"), tile)
    # All bins have the same filter: eight passes would amplify a different choice at the border of two bins.
    filters = random.normal(0, 0.01, (3, 1, 5, 5)).astype(np.float32).repeat(48, axis=1)
    filters += filters[:, :, ::-1, ::-1].copy()
    filters[:, :, 2, 2] += np.array([1, 0, 0])[:, None] - filters.sum(axis=(2, 3))
    about = {"sliders": [["soft", 0, 2], ["sharp", -1, 1]]}
    save_bank(Bank(Bins(8, 2, 3), 1.5, filters, about), folder / "bank")
    return folder


def style_of_a_richer_bank(folder: Path) -> Path:
    """Write a style whose bank also selects by curvature, mean and a second window, and filters chroma."""
    bins = Bins(8, 1, 2, curvatures=3, features=(Feature("mean", 3, 2.0), Feature("strength", 2, 3.0)))
    filters = np.random.default_rng(2).normal(0, 0.03, (1, bins.count, 5, 5)).astype(np.float32)
    filters[:, :, 2, 2] += 0.9 - filters.sum(axis=(2, 3))
    save_bank(Bank(bins, 1.5, filters, {"imitates": "nothing"}, filters / 2), folder / "rich.npz")
    text = 'format = 1\n[[background]]\nblock = "learned"\nbank = "rich.npz"\npasses = 2\n'
    (folder / "rich.toml").write_text(text)
    return folder / "rich.toml"


def style_of_an_affine_bank(folder: Path) -> Path:
    """Write a style whose bank has asymmetric affine filters."""
    random, bins = np.random.default_rng(3), Bins(8, 2, 2, features=(Feature("mean", 4, 0.3),))
    filters = random.normal(0, 0.04, (1, bins.count, 5, 5)).astype(np.float32)
    filters[:, :, 2, 2] += random.uniform(-1, 1, bins.count).astype(np.float32)
    constants = random.uniform(-0.2, 0.6, (1, bins.count, 3)).astype(np.float32)
    bank = Bank(bins, 1.5, filters, {"imitates": "nothing"}, filters / 2, constants)
    save_bank(bank, folder / "affine.npz")
    (folder / "affine.toml").write_text(
        'format = 1\n[[background]]\nblock = "learned"\nbank = "affine.npz"\n'
    )
    return folder / "affine.toml"


def style_of_a_clipped_bank(folder: Path) -> Path:
    """Write a style whose bank has clipped differences and two stages, and selects by difference."""
    random, bins = np.random.default_rng(4), Bins(4, 2, 1, features=(Feature("difference", 5, 2.0),))
    filters = random.normal(0, 0.02, (1, bins.count, 5, 5)).astype(np.float32)
    filters[:, :, 2, 2] += 1 - filters.sum(axis=(2, 3))
    clipped = random.normal(0, 0.06, (1, bins.count, 2, 5, 5)).astype(np.float32)
    clipped += clipped[..., ::-1, ::-1].copy()
    filters += filters[..., ::-1, ::-1].copy()
    filters /= 2
    second = Bank(bins, 2.0, filters, {}, clips=(4.0,), clipped=clipped[:, :, :1].copy())
    bank = Bank(bins, 1.5, filters, {"imitates": "nothing"}, clips=(6.0, 20.0), clipped=clipped, next=second)
    save_bank(bank, folder / "clipped.npz")
    text = 'format = 1\n[[background]]\nblock = "learned"\nbank = "clipped.npz"\namount = 0.8\n'
    (folder / "clipped.toml").write_text(text)
    return folder / "clipped.toml"


def style_of_a_bank_with_a_matrix(folder: Path) -> Path:
    """Write a style whose bank has a colour matrix, runs at half the size, and filters chroma."""
    random, bins = np.random.default_rng(5), Bins(4, 2, 1)
    filters = random.normal(0, 0.02, (1, bins.count, 5, 5)).astype(np.float32)
    filters[:, :, 2, 2] += 1 - filters.sum(axis=(2, 3))
    filters = (filters + filters[..., ::-1, ::-1]) / 2
    matrix = np.array([[0.4, 0.7, 0.2, 0.1], [0.3, 0.7, -0.2, 0], [0.9, -0.2, 0.1, 0.05]], np.float32)
    bank = Bank(bins, 1.5, filters, {"imitates": "nothing"}, filters, scale=0.5, matrix=matrix)
    save_bank(bank, folder / "matrix.npz")
    text = 'format = 1\n[[background]]\nblock = "learned"\nbank = "matrix.npz"\namount = 0.9\n'
    (folder / "matrix.toml").write_text(text)
    return folder / "matrix.toml"


def style_of_a_bank_with_luma_steps(folder: Path) -> Path:
    """Write a style whose bank has a tone curve through percentiles and a local mode before its filters."""
    random, bins = np.random.default_rng(6), Bins(4, 2, 1)
    filters = random.normal(0, 0.02, (1, bins.count, 5, 5)).astype(np.float32)
    filters[:, :, 2, 2] += 1 - filters.sum(axis=(2, 3))
    filters = (filters + filters[..., ::-1, ::-1]) / 2
    curve = np.array([[3, 0.1], [40, 0.3], [60, 0.7], [95, 0.9]], np.float32)
    mode = np.array([2, 4], np.int32)
    save_bank(Bank(bins, 1.5, filters, {"imitates": "nothing"}, curve=curve, mode=mode), folder / "steps.npz")
    text = 'format = 1\n[[background]]\nblock = "learned"\nbank = "steps.npz"\namount = 0.9\n'
    (folder / "steps.toml").write_text(text)
    return folder / "steps.toml"


RICHER_BANKS = [
    style_of_a_richer_bank,
    style_of_an_affine_bank,
    style_of_a_clipped_bank,
    style_of_a_bank_with_a_matrix,
    style_of_a_bank_with_luma_steps,
]
"""Functions that write a style to a folder, with a kind of bank that is not shipped."""


def block_style(block: Block, values: dict[str, Any], folder: Path) -> Style:
    """Return a style with the block applied to the source; `soft` and `flat` are saved pictures."""
    saved = (step("gaussian", save="soft"), step("to_gray", source="source", save="flat"))
    return Style("test", base=saved, background=(step(block.name, source="source", **values),), folder=folder)
