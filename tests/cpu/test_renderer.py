"""The CPU renderer: untouched planes, and the encoding of results."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pictures import (
    RGB8,
    SOURCES,
    TARGETS,
    VIDEO,
    codes,
    noise,
    planes,
    rgb_of,
    run,
    step,
    style,
)

from vidstyle.blocks import all_blocks
from vidstyle.core.picture import Encoding, Picture
from vidstyle.style import Step

every_target = pytest.mark.parametrize("target", TARGETS, ids=str)
every_source = pytest.mark.parametrize("source", SOURCES.values(), ids=SOURCES)

LUMA_STYLES = {
    "pixel": [step("brightness")],
    "filter": [step("sobel"), step("to_color", chroma="source")],
    "gaussian between": [step("to_gray"), step("gaussian"), step("posterize"), step("to_color")],
    "measured": [step("equalize"), step("minimum_range")],
    "recipe": [step("luma_posterize", save="flat"), step("brightness", source="flat")],
    "gray blend": [step("to_gray"), step("blend", mode="multiply"), step("to_color")],
}


@every_source
def test_plain_returns_same_picture_object(source: Picture) -> None:
    assert run(style(), source, rgb=source.color is not None) is source


@pytest.mark.parametrize("steps", LUMA_STYLES.values(), ids=LUMA_STYLES)
@pytest.mark.parametrize("name", ["video", "deep"])
def test_luma_styles_pass_chroma_planes_through(steps: list[Step], name: str) -> None:
    source = SOURCES[name]
    result = run(style(*steps), source)
    assert result.chroma is not None and source.chroma is not None
    assert all(new is old for new, old in zip(result.chroma, source.chroma, strict=True))
    assert result.luma is not source.luma
    assert np.any(result.luma != source.luma)


def test_chroma_is_not_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(*_: object) -> None:
        raise AssertionError("chroma was converted")

    for name in ("upsample_chroma", "stored_chroma_rows", "color_rows", "yuv_from_rgb"):
        monkeypatch.setattr(f"vidstyle.cpu.execute.{name}", read)
    monkeypatch.setattr("vidstyle.cpu.pixel_operations.rgb_from_yuv", read)
    for steps in LUMA_STYLES.values():
        run(style(*steps), SOURCES["video"])
    with pytest.raises(AssertionError, match="chroma was converted"):
        run(style(step("saturation")), SOURCES["video"])


def test_a_gray_result_has_neutral_chroma() -> None:
    for encoding, neutral in ((VIDEO, 128), (Encoding(depth=10), 512), (Encoding(full_range=True), 128)):
        result = run(style(step("to_gray")), codes(encoding, 9, 8))
        assert result.chroma is not None
        assert all(np.all(plane == neutral) and plane.shape == (5, 4) for plane in result.chroma)


@every_source
def test_sources_are_never_written_to(source: Picture) -> None:
    before = [plane.copy() for plane in planes(source)]
    steps = [step(name, source="source") for name in all_blocks() if name != "to_color"]
    run(style(*steps, lines=(step("sobel", invert=True),), paper="#ffeedd"), source)
    for plane, old in zip(planes(source), before, strict=True):
        np.testing.assert_array_equal(plane, old)


@every_source
@every_target
def test_result_has_target_encoding(source: Picture, target: Encoding) -> None:
    """A style without effect: the same colours in another encoding."""
    result = run(style(step("blend", opacity=0.0)), source, target=target)
    assert result.encoding == target
    assert result.luma is not None and result.chroma is not None
    assert (result.luma.dtype, result.luma.shape) == (target.dtype, source.shape)
    for plane in result.chroma:
        assert (plane.dtype, plane.shape) == (target.dtype, target.chroma_shape(*source.shape))
    if target.subsampling == (1, 1):
        rounding = 0 if target.depth == 0 else 1 / target.luma_levels[1]
        np.testing.assert_allclose(rgb_of(result), rgb_of(source), atol=1.6 * rounding + 1e-5)
    else:
        expected = in_planes(rgb_of(source), target)
        for plane, exact in zip((result.luma, *result.chroma), expected, strict=True):
            np.testing.assert_allclose(plane, exact, atol=0.51 + 2e-7 * 2**target.depth)


def in_planes(rgb: np.ndarray, target: Encoding) -> list[np.ndarray]:
    """Codes before rounding, in float64; chroma is averaged over a box of one step around each sample."""
    red, blue = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "bt2020": (0.2627, 0.0593)}[
        target.matrix
    ]
    luma = rgb @ [red, 1 - red - blue, blue]
    chroma = (rgb[..., 2] - luma) / (2 - 2 * blue), (rgb[..., 0] - luma) / (2 - 2 * red)
    (black, white), (neutral, span) = target.luma_levels, target.chroma_levels
    return [black + (white - black) * luma, *(neutral + span * boxed(plane, target) for plane in chroma)]


def boxed(plane: np.ndarray, target: Encoding) -> np.ndarray:
    """Average half pixels, which is exact for any box whose ends are at half pixels."""
    for axis, step_, siting in zip((1, 0), target.subsampling, target.siting, strict=True):
        if step_ > 1:
            count = -(-plane.shape[axis] // step_)
            halves = np.arange(2 * step_) / 2 + 0.25 - step_ / 2
            places = np.arange(count)[:, None] * step_ + siting + halves
            index = np.clip(np.rint(places).astype(int), 0, plane.shape[axis] - 1)
            plane = np.moveaxis(np.moveaxis(plane, axis, 0)[index].mean(axis=1), 0, axis)
    return plane


@every_source
@pytest.mark.parametrize("depth", [8, 16, 0])
def test_rgb_is_full_range_and_packed(source: Picture, depth: int) -> None:
    result = run(style(step("blend", opacity=0.0)), source, target=Encoding(depth=depth), rgb=True)
    assert result.color is not None and result.luma is None
    assert result.encoding == Encoding(depth=depth, full_range=True, subsampling=(1, 1))
    top = 1 if depth == 0 else 2**depth - 1
    tolerance = 1e-5 if depth == 0 else 0.51 / top + 1e-5
    np.testing.assert_allclose(result.color / top, rgb_of(source), atol=tolerance)


@pytest.mark.parametrize(
    ("depth", "target_depth", "factor"),
    [(8, 8, 1), (8, 16, 257.0), (16, 8, 1 / 257), (8, 0, 1 / 255), (0, 8, 255)],
)
@pytest.mark.parametrize("rgb", [False, True])
def test_alpha_is_passed_through(depth: int, target_depth: int, factor: float, rgb: bool) -> None:
    top = 1 if depth == 0 else 2**depth - 1
    encoding = replace(RGB8, depth=depth)
    values = (noise(9, 8, 4) * top).astype(encoding.dtype)
    source = Picture(encoding, color=values[..., :3], alpha=values[..., 3])
    result = run(style(step("brightness")), source, target=replace(RGB8, depth=target_depth), rgb=rgb)
    assert result.alpha is not None
    assert result.alpha.dtype == result.encoding.dtype
    np.testing.assert_allclose(
        result.alpha, source.alpha * float(factor), atol=0.51 if target_depth else 1e-6
    )
    assert (result.alpha is source.alpha) == (depth == target_depth)
