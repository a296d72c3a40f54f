"""Tones that styles see of HDR: diffuse white is white, and no code is lost on the way there and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from media import photograph

from vidstyle.core.color.hdr_curves import diffuse_white
from vidstyle.core.convert import convert, to_rgb
from vidstyle.core.picture import SITINGS, Encoding, Picture, Transfer

TRANSFERS: tuple[Transfer, ...] = ("pq", "hlg")


def hdr(transfer: Transfer, depth: int = 10) -> Encoding:
    return Encoding("bt2020", False, depth, (2, 2), SITINGS["topleft"], transfer)


def tones(encoding: Encoding) -> Encoding:
    return replace(encoding, matrix="bt709", depth=0, full_range=True, transfer="sdr")


def gray(encoding: Encoding, codes: np.ndarray) -> Picture:
    luma = np.repeat(codes.astype(encoding.dtype)[np.newaxis], 4, axis=0)
    neutral = np.full(encoding.chroma_shape(*luma.shape), encoding.chroma_levels[0], encoding.dtype)
    return Picture(encoding, luma, (neutral, neutral))


@pytest.mark.parametrize("depth", [10, 12])
@pytest.mark.parametrize("transfer", TRANSFERS)
def test_every_code_comes_back_from_sdr_tones(transfer, depth):
    encoding = hdr(transfer, depth)
    black, white = encoding.luma_levels
    source = gray(encoding, np.arange(black, white + 1))
    seen = convert(source, tones(encoding))
    back = convert(seen, encoding)
    assert np.array_equal(back.luma, source.luma)
    assert all(np.array_equal(*planes) for planes in zip(back.chroma, source.chroma, strict=True))
    assert np.all(np.diff(seen.luma[0]) > 0) and seen.luma.min() == 0
    assert seen.luma.max() == pytest.approx(1.45 if transfer == "pq" else 1.27, abs=0.01)


@pytest.mark.parametrize(("transfer", "signal"), [("pq", 0.58069), ("hlg", 0.74988)])
def test_diffuse_white_is_white(transfer, signal):
    assert diffuse_white(transfer) == pytest.approx(signal, abs=1e-5)
    encoding = replace(hdr(transfer), full_range=True, depth=16)
    seen = convert(gray(encoding, np.full(8, round(65535 * signal))), tones(encoding))
    assert seen.luma == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_sdr_colors_stay_the_same_in_hdr(transfer):
    source = Picture.from_array(photograph("astronaut"))
    wide = Encoding("bt2020", True, 16, (1, 1), (0.0, 0.0), transfer)
    shown = to_rgb(convert(source, wide))
    assert np.abs(shown.astype(int) - source.color).max() <= 1


def test_colors_outside_bt709_survive():
    encoding = Encoding("bt2020", True, 10, (1, 1), (0.0, 0.0), "pq")
    steps = np.linspace(0, 0.75, 6)
    rgb = np.stack(np.meshgrid(steps, steps, steps), -1).reshape(12, 18, 3).astype(np.float32)
    source = convert(Picture(replace(encoding, depth=0), color=rgb), encoding)
    back = convert(convert(source, tones(encoding)), encoding)
    assert np.abs(back.luma.astype(int) - source.luma).max() <= 3


def test_pq_becomes_hlg_of_the_same_light():
    pq, hlg = hdr("pq"), hdr("hlg")
    codes = np.round(64 + 876 * np.array([0.0, 0.5806889, 0.7518271, 0.0]))
    assert np.abs(convert(gray(pq, codes), hlg).luma[0] - [64, 721, 940, 64]).max() <= 1
