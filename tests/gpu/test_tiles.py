"""A page that is too large for the device is processed in tiles, with the same result."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pytest
from covering import DAY, drawn, of_the_day
from gpu import FORMS, Sessions, film_picture, gray_picture, max_code_difference, packed_picture
from pictures import FLOAT, RGB8, VIDEO, step, style

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import SITINGS, Encoding, Picture
from vidstyle.core.resample import METHODS
from vidstyle.gpu.compile.glsl import Form
from vidstyle.style import Style, load_style, style_names

SHAPE, TILES = (181, 243), 3 * 4
MANY = (361, 641)
MAX_SIDE = 128


whole = Sessions.fixture()
tiled = Sessions.fixture(max_side=MAX_SIDE)


def seams(
    whole: Sessions,
    tiled: Sessions,
    chosen: Style,
    picture: Picture,
    forms: Sequence[Form] = FORMS,
    **options: object,
) -> list[str]:
    """Return where the results with and without tiles differ by more than one code."""
    started = {
        form: [each.start(form, chosen, picture, **options) for each in (whole, tiled)] for form in forms
    }
    off = {form: max_code_difference(*(page() for page in pages)) for form, pages in started.items()}
    return [f"{form}: {codes} codes off" for form, codes in off.items() if codes > 1]


STYLES = {name: load_style(name) for name in style_names()} | {
    "gaussian": style(step("gaussian", sigma=7), step("gaussian", sigma=0.6), step("saturation")),
    "sobel": style(step("sobel", invert=True)),
    "halftone": style(step("halftone", cell=7.3)),
    "coarse halftone": style(step("halftone", cell=31)),
    "pattern": style(step("gaussian", sigma=2), step("pattern")),
    "equalize": style(step("gaussian", sigma=1), step("equalize"), step("gaussian", sigma=1)),
    "minimum_range": style(step("minimum_range", dynamic_range=220), step("minimum_range")),
    "saved": style(
        step("gaussian", sigma=3, save="soft"),
        step("sobel", source="source", save="edges"),
        step("blend", source="source", other="soft", mode="difference", mask="edges"),
        step("gaussian"),
    ),
    **{
        f"scale by {method}": style(
            step("scale", factor=0.43, method=method, back=method), step("gaussian", sigma=1)
        )
        for method in METHODS
    },
    "scaled up": style(
        step("scale", factor=1.9), step("halftone", cell=9), step("to_gray"), step("to_color")
    ),
    "scaled in between": Style(
        "between",
        ink="#203060",
        base=(step("scale", factor=0.7, save="small"), step("gaussian")),
        background=(step("scale", factor=0.5), step("blend", other="small"), step("equalize")),
        lines=(step("to_gray"), step("scale", factor=1.7), step("sobel", invert=True)),
    ),
}


def test_pages_are_processed_in_tiles(whole: Sessions, tiled: Sessions) -> None:
    source = film_picture(*SHAPE)
    for form in FORMS:
        drawn = [
            each[form].start(STYLES["gaussian"], FrameRequest(source, target=VIDEO)).result()
            for each in (whole, tiled)
        ]
        assert len(drawn[0].readbacks) == 1
        assert len(drawn[1].readbacks) == TILES


SHIPPED = style_names()
OWN = [name for name in STYLES if name not in SHIPPED]


@pytest.mark.parametrize("name", [*of_the_day(SHIPPED, 2), *of_the_day(OWN, 8)])
def test_no_seam_is_seen(name: str, whole: Sessions, tiled: Sessions) -> None:
    assert seams(whole, tiled, STYLES[name], film_picture(*SHAPE), [drawn(FORMS, name)]) == []


@pytest.mark.thorough
@pytest.mark.parametrize("name", STYLES)
def test_no_seam_is_seen_among_many_tiles(name: str, whole: Sessions, tiled: Sessions) -> None:
    assert seams(whole, tiled, STYLES[name], film_picture(*MANY)) == []


ENCODINGS = [
    *(Encoding(siting=SITINGS[name]) for name in ("topleft", "bottom")),
    *(Encoding(subsampling=grid) for grid in ((1, 1), (2, 1), (4, 4))),
    Encoding(siting=(1.0, 0.5)),
]


def seams_by_encoding(
    whole: Sessions,
    tiled: Sessions,
    name: str,
    encodings: Iterable[Encoding],
    shape: tuple[int, int],
    forms: Sequence[Form] = FORMS,
) -> list[str]:
    return [
        f"{encoding}: {line}"
        for encoding in encodings
        for line in seams(whole, tiled, STYLES[name], film_picture(*shape, encoding), forms)
    ]


@pytest.mark.parametrize(("name", "first"), [("saved", 0), ("scaled in between", 1)])
def test_no_seam_is_seen_in_any_kind_of_picture(
    name: str, first: int, whole: Sessions, tiled: Sessions
) -> None:
    encoding = ENCODINGS[(DAY + first) % len(ENCODINGS)]
    one, other, third = ([drawn(FORMS, f"{name} {each}")] for each in ("film", "first", "second"))
    assert seams_by_encoding(whole, tiled, name, [encoding], SHAPE, one) == []
    pictures = gray_picture(*SHAPE), packed_picture(*SHAPE)
    assert seams(whole, tiled, STYLES[name], pictures[first], other, target=VIDEO) == []
    assert seams(whole, tiled, STYLES[name], pictures[1 - first], third, target=RGB8, rgb=True) == []


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["saved", "scaled in between"])
def test_no_seam_is_seen_in_every_kind_of_picture(name: str, whole: Sessions, tiled: Sessions) -> None:
    shape = (157, 331)
    assert seams_by_encoding(whole, tiled, name, ENCODINGS, shape) == []
    for picture in (gray_picture(*shape), packed_picture(*shape)):
        assert seams(whole, tiled, STYLES[name], picture, target=VIDEO) == []
        assert seams(whole, tiled, STYLES[name], picture, target=RGB8, rgb=True) == []


SIZES = ((1, 1000), (1000, 1), (128, 128), (129, 128), (64, 1023), (700, 65))


@pytest.mark.parametrize("shape", SIZES)
def test_no_seam_is_seen_at_any_size(shape: tuple[int, int], whole: Sessions, tiled: Sessions) -> None:
    assert seams(whole, tiled, STYLES["equalize"], film_picture(*shape)) == []


@pytest.mark.thorough
@pytest.mark.parametrize("shape", SIZES)
def test_no_seam_is_seen_at_any_size_in_steps(
    shape: tuple[int, int], whole: Sessions, tiled: Sessions
) -> None:
    assert seams(whole, tiled, STYLES["scaled in between"], film_picture(*shape)) == []


def test_a_measure_over_tiles_is_of_the_whole_page(whole: Sessions, tiled: Sessions) -> None:
    """Dark and bright parts are in different tiles."""
    luma = np.full(SHAPE, 0.5, np.float32)
    luma[:90, :120], luma[-60:, -100:] = 0.2, 0.8
    source = Picture(FLOAT, luma=luma)
    chosen = style(step("equalize", low=2.0, high=98.0, lift=0.0))
    for form in FORMS:
        made, right = (each.run(form, chosen, source).luma for each in (tiled, whole))
        np.testing.assert_allclose(made, right, atol=1e-6)
        assert made is not None
        assert (made[0, 0], made[-1, -1]) == pytest.approx((0, 1), abs=1e-3)
