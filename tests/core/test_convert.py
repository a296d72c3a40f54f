"""Conversion of pictures: the same values as an empty style, and no needless copies."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from covering import in_one_test
from pictures import FLOAT, RGB8, SOURCES, TARGETS, VIDEO, codes, noise, run, same_bits, step, style

from vidstyle.core import convert as module
from vidstyle.core.convert import convert, to_rgb
from vidstyle.core.picture import Encoding, Picture

every_source = pytest.mark.parametrize("source", SOURCES.values(), ids=SOURCES)


@in_one_test("source, target, rgb", product(SOURCES.values(), TARGETS, (False, True)))
@pytest.mark.parametrize("threads", ["one", "many"])
def test_same_numbers_as_a_style_without_steps(
    source: Picture, target: Encoding, rgb: bool, threads: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if threads == "many":
        monkeypatch.setattr(module, "ONE_THREAD_PIXELS", 0)
    expected = run(style(), source, target=target, rgb=rgb)
    assert same_bits(convert(source, target, rgb), expected)


@every_source
def test_nothing_to_convert_gives_the_very_picture(source: Picture) -> None:
    assert convert(source, source.encoding, rgb=source.color is not None) is source


def test_chroma_on_the_same_grid_is_only_recoded() -> None:
    source = Picture(VIDEO, luma=noise(8, 8), chroma=codes(VIDEO, 8, 8).chroma)
    gray = Picture(FLOAT, luma=noise(8, 8))
    recoded = convert(source, replace(VIDEO, depth=10))
    assert source.chroma is not None and recoded.chroma is not None
    for plane, before in zip(recoded.chroma, source.chroma, strict=True):
        np.testing.assert_array_equal(plane, before.astype(np.uint16) * 4)
    assert all(np.all(plane == 128) for plane in convert(gray, VIDEO).chroma or ())


@pytest.mark.parametrize(("depth", "dtype", "white"), [(8, "u1", 255), (16, "u2", 65535), (0, "f4", 1)])
def test_arrays_of_each_kind(depth: int, dtype: str, white: float) -> None:
    array = to_rgb(Picture.from_array(np.array([[0, 255]], np.uint8)), depth)
    assert array.dtype == dtype and array.flags.c_contiguous
    np.testing.assert_allclose(array, [[[0] * 3, [white] * 3]], atol=1e-6)


@every_source
def test_arrays_and_back(source: Picture) -> None:
    """RGB of 8 bits goes to an array, to a picture and to an array again unchanged."""
    array = to_rgb(source)
    assert array.shape == (*source.shape, 3)
    np.testing.assert_array_equal(to_rgb(Picture.from_array(array)), array)


@pytest.mark.parametrize("depth", [8, 0])
def test_transparent_parts_are_blended_with_white(depth: int) -> None:
    array = np.array([[[0, 0, 0, 0], [0, 0, 0, 255], [0, 100, 255, 128]]], np.uint8)
    blended = to_rgb(Picture.from_array(array), depth)
    expected = np.array([[[255] * 3, [0] * 3, [127, 177, 255]]])
    np.testing.assert_allclose(blended, expected if depth else expected / 255, atol=0 if depth else 0.003)


def test_an_array_in_rgb_is_not_copied() -> None:
    array = np.zeros((3, 4, 3), np.uint8)
    assert to_rgb(Picture(RGB8, color=array)) is array


def test_chroma_of_a_large_picture_is_the_same_in_bands() -> None:
    source = codes(Encoding(subsampling=(1, 1)), 801, 301)
    assert module.ONE_THREAD_PIXELS < 801 * 301
    expected = run(style(step("blend", opacity=0.0)), source, target=VIDEO)
    assert same_bits(convert(source, VIDEO), expected)
