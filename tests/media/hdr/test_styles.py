"""Levels of HDR after shipped styles: black, gray, diffuse white and a highlight of 1000 cd/m2."""

from __future__ import annotations

import numpy as np
import pytest

from vidstyle.backend import FrameRequest
from vidstyle.core.color.hdr_curves import nits_to_pq
from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.cpu.hdr_renderer import HdrRenderer
from vidstyle.renderer import open_renderer

PQ = Encoding("bt2020", False, 10, (2, 2), SITINGS["topleft"], "pq")
LEVELS_NITS = (0, 26, 203, 1000)
WHITE_CODE, HIGHLIGHT_CODE = 573, 723
PATCH_PX = 80


def patches() -> Picture:
    codes = np.round(64 + 876 * nits_to_pq(np.array(LEVELS_NITS))).astype(np.uint16)
    luma = np.repeat(np.repeat(codes[np.newaxis], PATCH_PX, axis=1), 180, axis=0)
    neutral = np.full(PQ.chroma_shape(*luma.shape), 512, np.uint16)
    return Picture(PQ, luma, (neutral, neutral))


def levels(style: str, device: str = "cpu") -> list[float]:
    """The luma codes in the middle of the patches."""
    with HdrRenderer(open_renderer(style, device, announce=False), is_plain=False) as renderer:
        luma = renderer.restyle(FrameRequest(patches())).luma
    assert luma is not None
    middles = (luma[30:-30, 20 + PATCH_PX * each : PATCH_PX * (each + 1) - 20] for each in range(4))
    return [float(np.median(middle)) for middle in middles]


@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_a_style_that_keeps_tones_keeps_highlights(device):
    """Oil lightens tones between black and white, and with them highlights come a little nearer."""
    black, gray, white, highlight = levels("oil", device)
    assert (black, white) == pytest.approx((64, WHITE_CODE), abs=2)
    assert 390 < gray < 430 and WHITE_CODE + 70 < highlight <= HIGHLIGHT_CODE


@pytest.mark.parametrize("style", ["comic", "sketch", "poster", "woodcut"])
def test_highlights_of_other_styles_end_at_paper_white(style):
    *_, white, highlight = levels(style)
    assert white == pytest.approx(highlight, abs=1) and highlight <= WHITE_CODE
