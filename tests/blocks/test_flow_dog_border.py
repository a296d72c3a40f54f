"""Reduced pictures at their border: a thin frame looks as if the picture continued beyond it."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from media import photograph
from pictures import run_luma, step, style

from vidstyle.blade.references import flow_dog_parts
from vidstyle.blade.training import psnr

FRAME_PX = 2


def framed(shape: tuple[int, int]) -> np.ndarray:
    """Luma of a photograph in a thin black frame."""
    luma = cv2.resize(photograph("coffee")[..., 1], shape[::-1], interpolation=cv2.INTER_AREA) / np.float32(
        255
    )
    inside = luma[FRAME_PX:-FRAME_PX, FRAME_PX:-FRAME_PX]
    return np.pad(inside, FRAME_PX, constant_values=np.float32(0.02))


@pytest.mark.parametrize("sigma", [2.0, 4.0])
def test_thin_frame_continues_beyond_the_border(sigma: float) -> None:
    """Equal to the middle of an extended picture, whose sides are multiples of the reduced pixels."""
    look, luma = style(step("flow_dog", sigma=sigma, p=2.0)), framed((128, 160))
    extended = run_luma(look, np.pad(luma, 32, mode="edge"))
    np.testing.assert_allclose(run_luma(look, luma), extended[32:-32, 32:-32], atol=1e-5)


def test_thin_frame_is_close_to_the_reference() -> None:
    """The outer 12 pixels were off by up to 100 levels when the reduced frame was repeated instead."""
    luma = framed((240, 320))
    smooth, difference = flow_dog_parts(luma, 4.0)
    expected = np.clip(smooth + 2 * difference, 0, 1)
    result = run_luma(style(step("flow_dog", sigma=4.0, p=2.0)), luma)
    assert psnr(np.clip(result, 0, 1), expected) > 36
