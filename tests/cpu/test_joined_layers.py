"""The CPU renderer: composition of layers, and saved pictures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pictures import (
    FLOAT,
    SOURCES,
    VIDEO,
    codes,
    noise,
    rgb_of,
    run,
    run_color,
    run_luma,
    step,
    style,
)

from vidstyle.core.convert import convert
from vidstyle.core.picture import Picture
from vidstyle.style import Style

WEIGHTS = np.array([0.2126, 0.7152, 0.0722], np.float32)
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
def test_layers_are_combined_as_inks_on_paper(fields: dict[str, str], ink: Any, paper: Any) -> None:
    cover = lines_of(AFTER_BASE)
    both = layered(base=BASE, background=BACKGROUND, lines=LINES, **fields)
    np.testing.assert_allclose(both, cover * AFTER_BACKGROUND * paper + (1 - cover) * ink, atol=1e-5)
    alone = layered(background=BASE, **fields)
    np.testing.assert_allclose(alone, AFTER_BASE * paper, atol=1e-5)
    drawn = layered(lines=LINES, **fields)
    cover = lines_of(COLORS)
    np.testing.assert_allclose(drawn, np.ones(3) * (cover * paper + (1 - cover) * ink), atol=1e-5)


def test_style_with_only_paper_tints_picture() -> None:
    np.testing.assert_allclose(layered(paper="#ffe0c0"), COLORS * PAPER, atol=1e-6)


@pytest.mark.parametrize("ink", ["#000000", "#ffffff", "#808080", "#204080"])
def test_ink_is_drawn_identically_on_all_forms_of_background(ink: str) -> None:
    """Separate luma and chroma, RGB, and gray."""
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


@pytest.mark.parametrize("background", [(), (step("to_gray"),)], ids=["lines alone", "gray"])
def test_chroma_of_inks_on_paper_matches_colors(background: tuple[Any, ...]) -> None:
    """It is averaged to the target's grid from the coverage of the paper, not from chroma at every pixel."""
    chosen = style(*background, lines=(step("sobel", invert=True),), ink="#204080", paper="#ffe0c0")
    source = codes(VIDEO, 21, 23)
    planes, color = run(chosen, source), run(chosen, source, target=FLOAT, rgb=True)
    expected = convert(color, VIDEO)
    for plane, wanted in zip((planes.luma, *planes.chroma), (expected.luma, *expected.chroma), strict=True):
        assert np.abs(plane.astype(int) - wanted).max() <= 1
        assert (plane == wanted).mean() > 0.99


def test_black_ink_on_a_gray_page_stays_gray() -> None:
    out = run(style(lines=(step("sobel", invert=True),)), SOURCES["video"])
    assert out.chroma is not None
    assert all(np.all(plane == 128) for plane in out.chroma)


def test_step_starts_from_saved_picture() -> None:
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


def test_saved_picture_is_resampled_to_working_size() -> None:
    """At a quarter of the size, blend gets the source in this size, and to_color the source's chroma."""
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


def test_to_color_restores_original_colours() -> None:
    """The colours before to_gray, not the source's, over the new luma."""
    steps = [step("hue", angle=90), step("to_gray"), step("brightness", factor=0.5), step("to_color")]
    turned = run(style(steps[0]), Picture(FLOAT, color=COLORS), target=FLOAT)
    result = run(style(*steps), Picture(FLOAT, color=COLORS), target=FLOAT)
    np.testing.assert_allclose(result.chroma, turned.chroma, atol=1e-6)
    np.testing.assert_allclose(result.luma, 0.5 * turned.luma, atol=1e-6)
