"""Facts that hold for every block, at its default and at both ends of every range."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from block_settings import settings
from covering import in_one_test, of_the_day
from pictures import FLOAT, codes, noise, planes, run, same_bits, step, style

from vidstyle.block import (
    Asset,
    Block,
    Drift,
    FrameTime,
    Limits,
    LumaWeights,
    Margin,
    PageRegion,
    Percentiles,
    ResultRows,
    SavedRef,
)
from vidstyle.blocks import all_blocks
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.picture import RANGES, Encoding, Picture
from vidstyle.style import Style

BLOCKS = list(all_blocks().values())
SIZES = [(1, 1), (1, 7), (2, 2), (37, 41)]

every_block = pytest.mark.parametrize("block", BLOCKS, ids=lambda block: block.name)
every_size = in_one_test("size", SIZES)


def style_of(block: Block, values: dict[str, Any]) -> Style:
    """A style with this block as the only step, after to_gray if it needs a saved picture."""
    return style(step("to_gray"), step(block.name, source="source", **values))


def sources(size: tuple[int, int]) -> dict[str, Picture]:
    """Four kinds of pictures."""
    return {
        "gray": Picture(FLOAT, luma=noise(*size)),
        "color": Picture(FLOAT, color=noise(*size, 3)),
        "planes": codes(FLOAT, *size),
        "video": codes(Encoding(), *size),
    }


def settings_in_turn(block: Block, kind: int, turn: int) -> list[dict[str, Any]]:
    """The defaults, and every fourth of the other settings, for a kind of picture and a turn."""
    return [each for number, each in enumerate(settings(block)) if not number or (number + kind) % 4 == turn]


every_turn = pytest.mark.parametrize("turn", of_the_day(range(4), 1))


@every_block
@every_size
@every_turn
def test_any_setting_on_any_picture_gives_finite_result(
    block: Block, size: tuple[int, int], turn: int
) -> None:
    for number, (kind, source) in enumerate(sources(size).items()):
        before = [plane.copy() for plane in planes(source)]
        for values in settings_in_turn(block, number, turn):
            result = run(style_of(block, values), source, target=FLOAT, rgb=True).color
            assert result is not None
            assert (result.shape, result.dtype) == ((*size, 3), np.float32), (kind, values)
            assert np.isfinite(result).all(), (kind, values)
        for plane, old in zip(planes(source), before, strict=True):
            np.testing.assert_array_equal(plane, old, err_msg=f"{kind} was written to")


def call(block: Block, values: dict[str, Any], array: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Call the block's function on a whole page."""
    complete = block.arguments_for(values)
    luma = array if array.ndim == 2 else array.mean(axis=2)
    given: dict[object, Any] = {
        PageRegion: PageRegion(0, *luma.shape),
        Margin: (0, 0),
        LumaWeights: Encoding().weights,
        FrameTime: 0,
        Drift: noise(3, 4, 2, low=-2, high=2),
        Limits: RANGES["luma" if array.ndim == 2 else "color"],
        ResultRows: np.empty(array.shape, np.float32),
        Percentiles: np.percentile(luma, block.percentiles_for(complete)),
    }
    complete |= {name: given[kind] for name, kind in block.injected.items()}
    for name, parameter in block.parameters.items():
        if isinstance(parameter.control, Asset) and complete[name]:
            complete[name] = parameter.control.read(parameter.control.shipped()[complete[name]])
        elif isinstance(parameter.control, SavedRef):
            wants = parameter.control.on
            complete[name] = other if wants == "same" else other.reshape(*luma.shape, -1)[..., 0]
    result = block.function(array, **complete)
    result = result.whole() if isinstance(result, Mixed) else result
    assert isinstance(result, np.ndarray)
    return result


@pytest.mark.parametrize(
    "block",
    [each for each in BLOCKS if each.kind not in ("resize", "recipe", "learned", "network")],
    ids=lambda block: block.name,
)
@every_size
def test_functions_map_float32_to_float32_and_keep_inputs(block: Block, size: tuple[int, int]) -> None:
    shapes = {"luma": [size], "color": [(*size, 3)], "channels": [size, (*size, 3)]}[block.on]
    for shape in shapes:
        # Values slightly outside 0..1 result from other colour spaces and from resampling.
        array, other = noise(*shape, low=-0.2, high=1.2), noise(*shape, seed=2)
        before = array.copy(), other.copy()
        for values in settings(block):
            result = call(block, values, array, other)
            assert (result.shape, result.dtype) == (shape, np.float32), values
            assert np.isfinite(result).all(), values
            np.testing.assert_array_equal(array, before[0], err_msg=str(values))
            np.testing.assert_array_equal(other, before[1], err_msg=str(values))


@every_block
@every_turn
def test_bands_and_threads_keep_every_bit(block: Block, turn: int, monkeypatch: pytest.MonkeyPatch) -> None:
    for number, source in enumerate(sources((97, 61)).values()):
        for values in settings_in_turn(block, number, turn):
            monkeypatch.setenv("VIDSTYLE_THREADS", "1")
            monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1 << 30)
            whole = run(style_of(block, values), source, threads=1)
            monkeypatch.setattr("vidstyle.core.bands.BAND_BYTES", 1)
            for threads in (1, 4):
                banded = run(style_of(block, values), source, threads=threads)
                assert same_bits(whole, banded), (values, threads)
