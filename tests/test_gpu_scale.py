"""Other working sizes on the GPU: every method there and back, several in a row, and blocks between them."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from gpu import SHAPES, Sessions, faults, film_picture, gray_picture, packed_picture
from pictures import VIDEO, step, style

from vidstyle.core.picture import SITINGS, Encoding
from vidstyle.core.resample import METHODS
from vidstyle.style import Style

SHAPE = (181, 243)
FACTORS = (0.05, 0.31, 0.5, 0.77, 1.3)
LONGEST = ("16x8192", "8192x16")


@pytest.fixture(scope="module")
def sessions() -> Iterator[Sessions]:
    with Sessions() as opened:
        yield opened


@pytest.mark.parametrize("method", METHODS)
def test_every_method_leads_there_and_back(method: str, sessions: Sessions) -> None:
    found = []
    for factor in FACTORS:
        for back in METHODS:
            chosen = style(step("scale", factor=factor, method=method, back=back))
            for make in (film_picture, packed_picture):
                label = f"{method} {factor}, back by {back}, {make.__name__}"
                found += faults(sessions, chosen, make(*SHAPE), label)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("method", METHODS)
def test_the_longest_pages_are_resampled(method: str, sessions: Sessions) -> None:
    found = []
    for factor in (0.37, 1.7):
        chosen = style(step("scale", factor=factor, method=method, back=method))
        for size in LONGEST:
            found += faults(sessions, chosen, film_picture(*SHAPES[size]), f"{method} {factor}, {size}")
    assert not found, "\n".join(found)


CHAINS = {
    "down and up again": style(
        step("scale", factor=0.5), step("gaussian", sigma=1.5), step("scale", factor=2.0, method="bicubic")
    ),
    "down twice": style(
        step("scale", factor=0.7, method="bilinear", back="nearest"),
        step("saturation"),
        step("scale", factor=0.6, method="lanczos", back="bilinear"),
        step("gaussian", sigma=0.8),
    ),
    "up, then down": style(
        step("scale", factor=1.6, method="lanczos"),
        step("sobel"),
        step("scale", factor=0.4, back="area"),
        step("brightness"),
    ),
    "luma alone between": style(
        step("scale", factor=0.6),
        step("brightness"),
        step("scale", factor=0.7),
        step("brightness", factor=0.9),
    ),
    "a picture saved larger": style(
        step("gaussian", sigma=1, save="large"),
        step("scale", factor=0.45),
        step("blend", other="large", mode="screen", mask="large"),
        step("saturation"),
    ),
    "a picture saved smaller": style(
        step("scale", factor=0.3),
        step("gaussian", save="small"),
        step("blend", source="source", other="small", mode="overlay", opacity=0.7),
    ),
    "chroma saved larger": style(
        step("to_gray"), step("scale", factor=0.4), step("brightness"), step("to_color")
    ),
    "chroma saved smaller": style(
        step("scale", factor=0.4), step("to_gray"), step("gaussian"), step("to_color", source="source")
    ),
    "from another size": style(
        step("scale", factor=0.5, back="nearest", save="small"),
        step("scale", source="source", factor=0.25, back="area"),
        step("brightness", source="small"),
    ),
    "measured at another size": style(step("scale", factor=0.3), step("equalize"), step("minimum_range")),
    "halftone at another size": style(step("scale", factor=0.7), step("halftone", cell=9.5)),
    "pattern at another size": style(step("scale", factor=1.4), step("pattern", spacing=9.5)),
}
LAYERS = {
    "each layer at its own": Style(
        "layers",
        ink="#102040",
        base=(step("scale", factor=0.6, save="base"), step("gaussian", sigma=0.7)),
        background=(step("scale", factor=0.8), step("posterize")),
        lines=(step("scale", factor=1.5, back="bilinear"), step("sobel", invert=True)),
    ),
    "lines at another size than the base": Style(
        "lines",
        base=(step("to_gray"), step("scale", factor=0.5, back="lanczos")),
        lines=(step("sobel", invert=True), step("blend", other="source", mode="multiply")),
    ),
}
EVERY = CHAINS | LAYERS


@pytest.mark.parametrize("name", EVERY)
def test_sizes_change_between_blocks(name: str, sessions: Sessions) -> None:
    found = []
    for encoding in (VIDEO, Encoding(step=(4, 1)), Encoding(step=(1, 1)), Encoding(siting=SITINGS["bottom"])):
        label = f"{encoding.step} at {encoding.siting}"
        found += faults(sessions, EVERY[name], film_picture(*SHAPE, encoding), label)
    for make in (gray_picture, packed_picture):
        for shape in [SHAPE, (1, 1), (1, 50), (50, 1)]:
            found += faults(sessions, EVERY[name], make(*shape), f"{make.__name__} {shape}")
    assert not found, "\n".join(found)
