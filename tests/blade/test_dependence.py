"""What `vidstyle train` says that a bank cannot reproduce, by tests of the filter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.blade.bank import Bank
from vidstyle.blade.bins import Bins
from vidstyle.blade.photographs import Photograph, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.search.dependence import Dependence, find_dependence

RANDOM = np.random.default_rng(5)
LIGHT = np.array([[-1, 0, 0], [0, 0, 0], [0, 0, 1]], np.float32)
SHARP = np.array([[0, -2, 0], [-2, 9, -2], [0, -2, 0]], np.float32)
VIGNETTE = np.linspace(0.3, 1, 192, dtype=np.float32)[:, None, None]

BANK = Bank(Bins(2, 1, 1), 1.5, np.zeros((1, 2, 7, 7), np.float32))
COLOR_BANK = replace(BANK, chroma=BANK.filters)

FILTERS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "random": (lambda z: z + RANDOM.normal(0, 0.1, z.shape).astype(np.float32), "is random (two runs differ"),
    "mirrored": (lambda z: z[:, ::-1], "is not local (a change more than 48 px away"),
    "stretched": (lambda z: (z - z.mean()) * 2 + 0.5, "is not local (a change more than 48 px away"),
    "vignette": (lambda z: z * VIGNETTE[: len(z)], "depends on the position in the picture"),
    "relief": (lambda z: 0.5 + cv2.filter2D(z, -1, LIGHT), "prefers a direction"),
    "wide": (lambda z: cv2.blur(z, (21, 21)), "px away (filters reach 3 px; try --size 15)"),
    "mosaic": (
        lambda z: cv2.resize(z[4::8, 4::8], z.shape[1::-1], interpolation=0),
        "depends on the position",
    ),
    "hatched": (lambda z: z * (np.indices(z.shape[:2]).sum(0) % 8 < 4)[..., None], "draws on flat areas"),
    "unstable": (
        lambda z: np.where((z * 255 + 0.5).astype(int) % 2, z + 0.1, z).astype(np.float32),
        "reacts to noise of one level",
    ),
    "channel": (lambda z: np.repeat(z[..., 2:], 3, axis=2), "depends on colour"),
    "vivid": (lambda z: z * np.float32([1.2, 1, 0.5]), "also changes colour (add --chroma)"),
}
"""Filters that a bank cannot reproduce, and the reason."""


@pytest.fixture(scope="module")
def coffee(tmp_path_factory: pytest.TempPathFactory) -> Photograph:
    path = tmp_path_factory.mktemp("coffee") / "coffee.png"
    assert cv2.imwrite(str(path), np.ascontiguousarray(photograph("coffee")[..., ::-1]))
    return Photograph(path)


def found(function: Callable[[np.ndarray], np.ndarray], *pictures: Photograph) -> Dependence:
    reference = ReferenceFilter("a test", lambda color, _: [np.asarray(function(color), np.float32)])
    return find_dependence(reference, pictures)


@pytest.mark.parametrize("name", FILTERS)
def test_reason_is_found(name: str, coffee: Photograph) -> None:
    function, reason = FILTERS[name]
    reasons = "; ".join(found(function, coffee).reasons(BANK, 0))
    assert reason in reasons
    assert ("not local" in reasons) == ("not local" in reason)


def test_strong_sharpening_is_not_taken_for_a_reaction_to_noise(coffee: Photograph) -> None:
    dependence = found(lambda z: cv2.filter2D(z, -1, SHARP), coffee)
    assert dependence.instability == 0


def test_local_filter_of_gray_has_no_reason(coffee: Photograph) -> None:
    dependence = found(lambda z: cv2.blur(luma_of(z), (5, 5)), coffee)
    assert not list(dependence.reasons(BANK, 0)) and dependence.reach == 2


def test_details_are_the_reason_for_what_the_tests_do_not_explain(coffee: Photograph) -> None:
    dependence = found(
        lambda z: cv2.medianBlur((luma_of(z) * 255).astype(np.uint8), 5) / np.float32(255), coffee
    )
    assert list(dependence.reasons(COLOR_BANK, 0.3)) == [
        "depends on details within 2 px that these bins do not distinguish (try --bins auto)"
    ]
    assert list(dependence.reasons(COLOR_BANK, 0.3, 12)) == [
        "depends on details within 2 px that no layout of bins distinguishes (12 tried)"
    ]


def test_small_effect_of_distant_pixels_is_not_the_only_reason(coffee: Photograph) -> None:
    def mixed(z: np.ndarray, share: float) -> np.ndarray:
        details = np.tanh(20 * (luma_of(z) - cv2.blur(luma_of(z), (3, 3)))) / 10
        return luma_of(z) + details + share * (cv2.blur(luma_of(z), (13, 13)) - luma_of(z))

    small, large = (
        list(found(lambda z, s=share: mixed(z, s), coffee).reasons(COLOR_BANK, 0.5)) for share in (0.1, 0.9)
    )
    assert "depends on pixels up to" in small[0] and "depends on details within" in small[1]
    assert "depends on pixels up to" in large[0] and len(large) == 1


def test_picture_without_details_has_no_weight(coffee: Photograph, tmp_path: Path) -> None:
    flat = Photograph(tmp_path / "flat.png")
    assert cv2.imwrite(str(flat.path), np.full((192, 192, 3), 90, np.uint8))
    alone, both = (found(FILTERS["wide"][0], *pictures) for pictures in ((coffee,), (flat, coffee)))
    assert both.by_distance[0] < 3 * alone.by_distance[0]


def test_colour_matrix_is_not_missing_from_a_bank_that_has_one(coffee: Photograph) -> None:
    dependence = found(FILTERS["channel"][0], coffee)
    mixing = replace(COLOR_BANK, matrix=np.eye(3, 4, dtype=np.float32))
    assert "which luma lacks" in next(dependence.reasons(COLOR_BANK, 0.3))
    assert "only a matrix" in next(dependence.reasons(mixing, 0.3))


def test_reduced_picture_widens_the_reach_of_filters(coffee: Photograph) -> None:
    dependence = found(lambda z: cv2.blur(z, (21, 21)), coffee)
    quarter, half = (replace(COLOR_BANK, scale=scale) for scale in (0.25, 0.5))
    assert not list(dependence.reasons(quarter, 0)) and list(dependence.reasons(half, 0))
    filters = np.zeros((1, 2, 15, 15), np.float32)
    wide = replace(BANK, filters=filters, chroma=filters)
    assert list(dependence.reasons(wide, 0)) == [
        "depends on pixels up to 9 px away (filters reach 7 px; try --scale 0.5)"
    ]


def test_small_picture_is_tested(tmp_path: Path) -> None:
    assert cv2.imwrite(str(tmp_path / "small.png"), np.full((3, 4, 3), 90, np.uint8))
    assert not found(lambda z: z * np.float32(0.5), Photograph(tmp_path / "small.png")).draws
