"""The CPU runner: what it leaves alone, how layers are put together, what it saves, how it encodes."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import cv2
import numpy as np
import pytest
from pictures import FLOAT, codes, noise, planes, run, run_color, run_luma, same_bits, step, style

from vidstyle.blocks import all_blocks
from vidstyle.cpu import CpuRenderer
from vidstyle.picture import SITINGS, Encoding, Picture
from vidstyle.planes import chroma_rows, color_rows
from vidstyle.style import Step, Style

WEIGHTS = np.array([0.2126, 0.7152, 0.0722], np.float32)
VIDEO = Encoding()
RGB8 = Encoding(full_range=True, step=(1, 1))
TARGETS = [
    VIDEO,
    Encoding("bt601"),
    Encoding("bt2020", depth=10),
    Encoding(full_range=True),
    Encoding(step=(2, 1)),
    Encoding(step=(1, 1)),
    Encoding(step=(4, 1)),
    Encoding(step=(4, 4), siting=(0.0, 0.0)),
    Encoding(siting=SITINGS["topleft"]),
    Encoding(siting=SITINGS["bottom"]),
    Encoding("bt601", True, 16, (1, 2)),
    FLOAT,
]
SOURCES = {
    "video": codes(VIDEO, 37, 41),
    "deep": codes(Encoding("bt2020", depth=10, step=(2, 1)), 37, 41),
    "rgb": Picture(RGB8, color=codes(RGB8, 37, 41 * 3).luma.reshape(37, 41, 3)),  # type: ignore[union-attr]
    "float": Picture(FLOAT, color=noise(37, 41, 3)),
    "gray": Picture(VIDEO, luma=codes(VIDEO, 37, 41).luma),
}
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
def test_plain_returns_the_very_picture(source: Picture) -> None:
    assert run(style(), source, rgb=source.color is not None) is source


@pytest.mark.parametrize("steps", LUMA_STYLES.values(), ids=LUMA_STYLES)
@pytest.mark.parametrize("name", ["video", "deep"])
def test_luma_styles_hand_the_chroma_planes_on(steps: list[Step], name: str) -> None:
    source = SOURCES[name]
    result = run(style(*steps), source)
    assert result.chroma is not None and source.chroma is not None
    assert all(new is old for new, old in zip(result.chroma, source.chroma, strict=True))
    assert result.luma is not source.luma
    assert np.any(result.luma != source.luma)


def test_chroma_is_not_even_read(monkeypatch: pytest.MonkeyPatch) -> None:
    def read(*_: object) -> None:
        raise AssertionError("chroma was converted")

    for name in ("chroma_rows", "color_rows", "rgb_from_yuv", "yuv_from_rgb"):
        monkeypatch.setattr(f"vidstyle.cpu.band.{name}", read)
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


def rgb_of(picture: Picture) -> np.ndarray:
    return color_rows(picture, 0, picture.shape[0]).astype(np.float64)


@every_source
@every_target
def test_the_result_is_encoded_as_the_target_says(source: Picture, target: Encoding) -> None:
    """A style without effect: the same colours in another encoding."""
    result = run(style(step("blend", opacity=0.0)), source, target=target)
    assert result.encoding == target
    assert result.luma is not None and result.chroma is not None
    assert (result.luma.dtype, result.luma.shape) == (target.dtype, source.shape)
    for plane in result.chroma:
        assert (plane.dtype, plane.shape) == (target.dtype, target.chroma_shape(*source.shape))
    if target.step == (1, 1):
        rounding = 0 if target.depth == 0 else 1 / target.luma_levels[1]
        np.testing.assert_allclose(rgb_of(result), rgb_of(source), atol=1.6 * rounding + 1e-5)
    else:
        expected = in_planes(rgb_of(source), target)
        for plane, exact in zip((result.luma, *result.chroma), expected, strict=True):
            np.testing.assert_allclose(plane, exact, atol=0.51 + 2e-7 * 2**target.depth)


def in_planes(rgb: np.ndarray, target: Encoding) -> list[np.ndarray]:
    """Codes before rounding, in float64; chroma averaged over a box of one step around each sample."""
    red, blue = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "bt2020": (0.2627, 0.0593)}[
        target.matrix
    ]
    luma = rgb @ [red, 1 - red - blue, blue]
    chroma = (rgb[..., 2] - luma) / (2 - 2 * blue), (rgb[..., 0] - luma) / (2 - 2 * red)
    (black, white), (neutral, span) = target.luma_levels, target.chroma_levels
    return [black + (white - black) * luma, *(neutral + span * boxed(plane, target) for plane in chroma)]


def boxed(plane: np.ndarray, target: Encoding) -> np.ndarray:
    """Each half of a pixel counted by itself, which any box whose ends lie on halves of pixels allows."""
    for axis, step_, siting in zip((1, 0), target.step, target.siting, strict=True):
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
    assert result.encoding == Encoding(depth=depth, full_range=True, step=(1, 1))
    top = 1 if depth == 0 else 2**depth - 1
    tolerance = 1e-5 if depth == 0 else 0.51 / top + 1e-5
    np.testing.assert_allclose(result.color / top, rgb_of(source), atol=tolerance)


@pytest.mark.parametrize(
    ("depth", "target_depth", "factor"),
    [(8, 8, 1), (8, 16, 257.0), (16, 8, 1 / 257), (8, 0, 1 / 255), (0, 8, 255)],
)
@pytest.mark.parametrize("rgb", [False, True])
def test_alpha_is_handed_on(depth: int, target_depth: int, factor: float, rgb: bool) -> None:
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


# Layers

COLORS = noise(24, 30, 3)
GRAY = COLORS @ WEIGHTS


def layered(**fields: Any) -> np.ndarray:
    chosen = Style("test", **fields)
    results = [run_color(chosen, COLORS)]
    as_planes = run(Style("test"), Picture(FLOAT, color=COLORS), target=FLOAT)
    planar = run(chosen, as_planes, target=FLOAT, rgb=True).color
    np.testing.assert_allclose(planar, results[0], atol=1e-5)
    return results[0]


BASE = (step("saturation", factor=0.5),)
BACKGROUND = (step("hue", angle=0, red=-25.5, green=51),)
LINES = (step("brightness", factor=1.0), step("to_gray"), step("sobel", invert=True))
AFTER_BASE = GRAY[..., None] + 0.5 * (COLORS - GRAY[..., None])
AFTER_BACKGROUND = np.clip(AFTER_BASE + [-0.1, 0.2, 0], 0, 1)
INK, PAPER = np.array([0x20, 0x40, 0x80]) / 255, np.array([0xFF, 0xE0, 0xC0]) / 255
COLORED = {"ink": "#204080", "paper": "#ffe0c0"}


def lines_of(color: np.ndarray) -> np.ndarray:
    return run_luma(style(step("sobel", invert=True)), color @ WEIGHTS)[..., None]


@pytest.mark.parametrize(
    ("fields", "ink", "paper"), [(COLORED, INK, PAPER), ({}, 0, 1)], ids=["colored", "default"]
)
def test_layers_are_put_together_as_inks_on_paper(fields: dict[str, str], ink: Any, paper: Any) -> None:
    cover = lines_of(AFTER_BASE)
    both = layered(base=BASE, background=BACKGROUND, lines=LINES, **fields)
    np.testing.assert_allclose(both, cover * AFTER_BACKGROUND * paper + (1 - cover) * ink, atol=1e-5)
    alone = layered(background=BASE, **fields)
    np.testing.assert_allclose(alone, AFTER_BASE * paper, atol=1e-5)
    drawn = layered(lines=LINES, **fields)
    cover = lines_of(COLORS)
    np.testing.assert_allclose(drawn, np.ones(3) * (cover * paper + (1 - cover) * ink), atol=1e-5)


def test_a_style_of_paper_alone_tints_the_picture() -> None:
    np.testing.assert_allclose(layered(paper="#ffe0c0"), COLORS * PAPER, atol=1e-6)


@pytest.mark.parametrize("ink", ["#000000", "#ffffff", "#808080", "#204080"])
def test_ink_is_drawn_alike_in_whatever_form_the_background_is(ink: str) -> None:
    """Luma and chroma apart, RGB, and gray."""
    source = codes(VIDEO, 20, 22)
    for background in ([step("brightness", factor=1.0)], [step("saturation", factor=1.0)], [step("to_gray")]):
        plain = rgb_of(run(style(*background), source, target=FLOAT))
        cover = run_luma(style(step("sobel", invert=True)), run(style(), source, target=FLOAT).luma)[
            ..., None
        ]
        expected = (
            cover * plain
            + (1 - cover) * np.array([int(ink[1:3], 16), int(ink[3:5], 16), int(ink[5:], 16)]) / 255
        )
        out = run(
            style(*background, lines=(step("sobel", invert=True),), ink=ink), source, target=FLOAT, rgb=True
        )
        np.testing.assert_allclose(out.color, np.clip(expected, 0, 1), atol=1e-5)


def test_black_ink_on_a_gray_page_stays_gray() -> None:
    out = run(style(lines=(step("sobel", invert=True),)), SOURCES["video"])
    assert out.chroma is not None
    assert all(np.all(plane == 128) for plane in out.chroma)


# Saved pictures


def test_a_step_starts_from_what_was_saved() -> None:
    dark, gray = np.float32(0.5) * GRAY, GRAY
    steps = [
        step("brightness", factor=0.5, save="dark"),
        step("saturation", factor=0.0),
        step("sobel", source="dark", gain=0.0, invert=True),
        step("blend", other="dark", opacity=1.0),
    ]
    np.testing.assert_allclose(run_color(style(*steps), COLORS)[..., 0], np.clip(dark, 0, 1), atol=1e-5)
    back = run_color(style(*steps, step(source="source"), step("to_gray")), COLORS)
    np.testing.assert_allclose(back, np.repeat(gray[..., None], 3, 2), atol=1e-5)


def test_layers_see_what_earlier_layers_saved() -> None:
    chosen = Style(
        "test",
        base=(step("brightness", factor=0.5, save="dark"),),
        background=(step("saturation", factor=0.0, save="gray"),),
        lines=(step(source="gray"), step("blend", other="dark", mode="difference", opacity=1.0)),
    )
    half = 0.5 * GRAY[..., None]
    dark = COLORS - half
    cover = np.abs(half - dark) @ WEIGHTS
    np.testing.assert_allclose(run_color(chosen, COLORS), cover[..., None] * np.repeat(half, 3, 2), atol=1e-5)


def test_a_saved_picture_is_brought_to_another_working_size() -> None:
    """A quarter of the size: blend gets the source in it, to_color the source's chroma."""
    y, x = np.mgrid[:32, :48]
    luma = (0.2 + 0.01 * x + 0.005 * y).astype(np.float32)
    blue = (0.001 * x - 0.002 * y).astype(np.float32)
    source = Picture(FLOAT, luma=luma, chroma=(blue, -blue))
    steps = [
        step("to_gray"),
        step("scale", factor=0.25, back="bilinear"),
        step("brightness", factor=0.0),
        step("blend", other="source", mode="add", opacity=1.0),
        step("to_color"),
    ]
    result = run(style(*steps), source)
    assert result.luma is not None and result.chroma is not None
    inside = (slice(4, -4), slice(4, -4))
    np.testing.assert_allclose(result.luma[inside], luma[inside], atol=1e-5)
    np.testing.assert_allclose(result.chroma[0][inside], blue[inside], atol=1e-5)
    np.testing.assert_allclose(result.chroma[1][inside], -blue[inside], atol=1e-5)


def test_to_color_gives_the_colours_that_the_picture_had() -> None:
    """Those before to_gray, not the source's; a new luma under them."""
    steps = [step("hue", angle=90), step("to_gray"), step("brightness", factor=0.5), step("to_color")]
    turned = run(style(steps[0]), Picture(FLOAT, color=COLORS), target=FLOAT)
    result = run(style(*steps), Picture(FLOAT, color=COLORS), target=FLOAT)
    np.testing.assert_allclose(result.chroma, turned.chroma, atol=1e-6)
    np.testing.assert_allclose(result.luma, 0.5 * turned.luma, atol=1e-6)


# Bands, sizes and lengths

LONG = style(
    step("gaussian", sigma=1.0, save="soft"),
    step("saturation"),
    step("posterize", levels=6),
    step("halftone", cell=4.0),
    step("blend", other="soft", mode="multiply", mask="soft"),
    lines=(step("to_gray"), step("gaussian", sigma=0.7), step("sobel", invert=True), step("soft_threshold")),
    ink="#302010",
)


@pytest.mark.parametrize(
    "target", [VIDEO, Encoding(siting=SITINGS["bottom"]), Encoding(step=(4, 4)), FLOAT], ids=str
)
@pytest.mark.parametrize("name", ["video", "rgb", "gray"])
def test_bands_change_no_bit_of_a_long_style(
    monkeypatch: pytest.MonkeyPatch, target: Encoding, name: str
) -> None:
    results = []
    for size, threads in ((1 << 30, 1), (1, 1), (1, 4), (9000, 3)):
        monkeypatch.setattr("vidstyle.cpu.work.CORES", threads)
        monkeypatch.setattr("vidstyle.cpu.work.BAND_BYTES", size)
        results.append(run(LONG, SOURCES[name], threads=threads, target=target))
    assert all(same_bits(results[0], result) for result in results[1:])


def test_lengths_grow_with_the_shorter_side() -> None:
    """`height` is what lengths are meant for; a turned picture gets the same lengths."""
    luma = noise(40, 90)
    twice = run_luma(style(step("gaussian", sigma=2.0), height=20.0), luma)
    np.testing.assert_array_equal(twice, run_luma(style(step("gaussian", sigma=4.0)), luma))
    turned = run_luma(style(step("gaussian", sigma=2.0), height=20.0), luma.T)
    np.testing.assert_allclose(turned, twice.T, atol=1e-6)
    threshold = run_luma(style(step("soft_threshold"), height=20.0), luma)
    np.testing.assert_array_equal(threshold, run_luma(style(step("soft_threshold")), luma))


def test_no_length_falls_below_its_least() -> None:
    color = noise(30, 40, 3)
    tiny = run_color(style(step("halftone", cell=6.0), height=3000.0), color)
    np.testing.assert_array_equal(tiny, run_color(style(step("halftone", cell=3.0)), color))


def test_one_renderer_takes_pictures_of_any_size_and_kind() -> None:
    with CpuRenderer(LONG) as renderer:
        for shape, encoding in product([(20, 30), (8, 9), (20, 30)], [VIDEO, Encoding(depth=10)]):
            picture = codes(encoding, *shape)
            assert same_bits(renderer.run(picture, 0.0), run(LONG, picture))


def test_alpha_beside_color_in_one_array() -> None:
    """RGBA floats: the colour is a view with gaps."""
    rgba = noise(20, 30, 4)
    expected = run_color(LONG, np.ascontiguousarray(rgba[..., :3]))
    out = run(LONG, Picture.from_array(rgba), rgb=True)
    np.testing.assert_array_equal(out.color, expected)
    np.testing.assert_array_equal(out.alpha, rgba[..., 3])


def test_padded_and_reversed_planes_are_read_right() -> None:
    """Rows with padding, as decoders give them, and flipped views."""
    source = codes(VIDEO, 18, 20)
    assert source.luma is not None and source.chroma is not None
    wide = [np.pad(plane, ((0, 0), (0, 7))) for plane in (source.luma, *source.chroma)]
    views = [plane[:, :-7] for plane in wide]
    padded = Picture(VIDEO, luma=views[0], chroma=(views[1], views[2]))
    assert same_bits(run(LONG, padded), run(LONG, source))
    flipped = Picture(VIDEO, luma=views[0][::-1], chroma=(views[1][::-1], views[2][::-1]))
    copied = Picture(VIDEO, luma=views[0][::-1].copy(), chroma=(views[1][::-1].copy(), views[2][::-1].copy()))
    assert same_bits(run(LONG, flipped), run(LONG, copied))


def test_working_size_resamples_as_opencv_does() -> None:
    luma = noise(40, 60)
    out = run_luma(style(step("scale", factor=0.5, method="lanczos", back="lanczos")), luma)
    small = cv2.resize(luma, (30, 20), interpolation=cv2.INTER_LANCZOS4)
    np.testing.assert_array_equal(out, cv2.resize(small, (60, 40), interpolation=cv2.INTER_LANCZOS4))


def test_chroma_rows_of_a_result_lie_where_its_siting_says() -> None:
    """A colour edge printed into 4:2:0 of each siting comes back in the same place."""
    x = np.linspace(-0.2, 0.2, 40, dtype=np.float32)[None].repeat(24, axis=0)
    source = Picture(FLOAT, luma=np.full_like(x, 0.5), chroma=(x, -x))
    for siting in SITINGS.values():
        target = Encoding(depth=0, full_range=True, siting=siting)
        back = chroma_rows(run(style(step("saturation", factor=1.0)), source, target=target), 0, 24)
        np.testing.assert_allclose(back[0][2:-2, 2:-2], x[2:-2, 2:-2], atol=1e-5)
