"""Working sizes on the GPU: every resampling method in both directions, repeated, with blocks in between."""

from __future__ import annotations

from functools import partial
from itertools import product

import pytest
from covering import DAY, covering_rows, drawn, of_the_day
from gpu import FORMS, ODD, SHAPES, Sessions, faults, film_picture, gray_picture, packed_picture
from pictures import VIDEO, step, style

from vidstyle.core.picture import SITINGS, Encoding
from vidstyle.core.resample import METHODS
from vidstyle.style import Style

SHAPE = ODD
FACTORS = (0.05, 0.31, 0.5, 0.77, 1.3)
LONGEST = ("16x8192", "8192x16")


sessions = Sessions.fixture()


def scaled(factor: float, method: str, back: str) -> Style:
    return style(step("scale", factor=factor, method=method, back=back))


ROWS = covering_rows(
    {
        "method": list(METHODS),
        "back": list(METHODS),
        "factor": FACTORS,
        "make": (film_picture, packed_picture),
    }
)


@pytest.mark.parametrize("method", METHODS)
def test_every_method_agrees(method: str, sessions: Sessions) -> None:
    found = []
    for row in (row for row in ROWS if row["method"] == method):
        chosen = scaled(row["factor"], method, row["back"])
        found += faults(sessions, chosen, row["make"](*SHAPE), str(row), [drawn(FORMS, str(row))])
    assert not found, "\n".join(found)


@pytest.mark.thorough
@pytest.mark.parametrize("method", METHODS)
def test_every_pair_of_methods_agrees(method: str, sessions: Sessions) -> None:
    found = []
    for factor, back, make in product(FACTORS, METHODS, (film_picture, packed_picture)):
        label = f"{method} {factor}, back by {back}, {make.__name__}"
        found += faults(sessions, scaled(factor, method, back), make(*SHAPE), label)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("method", of_the_day(list(METHODS), 2))
def test_the_longest_pages_are_resampled(method: str, sessions: Sessions) -> None:
    """Reduced in length, and enlarged in width."""
    for factor, size in zip((0.37, 1.7), LONGEST, strict=True):
        chosen = scaled(factor, method, method)
        forms = [drawn(FORMS, f"{method} {size}")]
        assert faults(sessions, chosen, film_picture(*SHAPES[size]), f"{factor}, {size}", forms) == []


@pytest.mark.thorough
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("factor", [0.37, 1.7])
def test_all_the_longest_pages_are_resampled(method: str, factor: float, sessions: Sessions) -> None:
    for size in LONGEST:
        assert faults(sessions, scaled(factor, method, method), film_picture(*SHAPES[size]), size) == []


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


ENCODINGS = (
    VIDEO,
    Encoding(subsampling=(4, 1)),
    Encoding(subsampling=(1, 1)),
    Encoding(siting=SITINGS["bottom"]),
)
MAKERS = {
    **{f"{each.subsampling} at {each.siting}": partial(film_picture, encoding=each) for each in ENCODINGS},
    "gray": gray_picture,
    "packed": packed_picture,
}
"""Kinds of pictures."""
THIN = ((1, 1), (1, 50), (50, 1))


@pytest.mark.parametrize("name", EVERY)
def test_sizes_change_between_blocks(name: str, sessions: Sessions) -> None:
    """Every chain on common video and on one other kind, so that each kind is tested with some chains."""
    number = list(EVERY).index(name) + DAY
    usual, *others = MAKERS.items()
    found = []
    for kind, make in (usual, others[number % len(others)]):
        found += faults(sessions, EVERY[name], make(*SHAPE), kind, [drawn(FORMS, f"{name} {kind}")])
    thin, make = THIN[number % len(THIN)], (gray_picture, packed_picture)[number % 2]
    found += faults(sessions, EVERY[name], make(*thin), f"{make.__name__} {thin}", [drawn(FORMS, name)])
    assert not found, "\n".join(found)


@pytest.mark.thorough
@pytest.mark.parametrize("name", EVERY)
def test_sizes_change_between_blocks_in_pictures_of_every_kind(name: str, sessions: Sessions) -> None:
    found = []
    for kind, make in MAKERS.items():
        for shape in [SHAPE, *THIN] if kind in ("gray", "packed") else [SHAPE]:
            found += faults(sessions, EVERY[name], make(*shape), f"{kind} {shape}")
    assert not found, "\n".join(found)
