"""Paper sizes, margins and gutters."""

from __future__ import annotations

import pytest

from vidstyle.comic.layout.paper import PAPER_SIZES_MM, paper
from vidstyle.errors import UsageError


@pytest.mark.parametrize("name", PAPER_SIZES_MM)
@pytest.mark.parametrize("dpi", [72, 150, 300])
def test_a_page_has_its_size_in_millimetres(name: str, dpi: int) -> None:
    page = paper(name, dpi)
    for pixels, millimetres in zip((page.width, page.height), PAPER_SIZES_MM[name], strict=True):
        assert abs(pixels / dpi * 25.4 - millimetres) < 0.5 * 25.4 / dpi


def test_lengths_keep_their_physical_size_at_any_resolution() -> None:
    coarse, fine = paper("a4", 100), paper("a4", 400)
    for length in ("margin", "gutter", "row_gutter", "border"):
        assert abs(getattr(fine, length) / getattr(coarse, length) - 4) < 0.4


def test_small_paper_has_small_margins() -> None:
    assert paper("a5").margin < paper("a4").margin == paper("a3").margin
    assert paper("400x600").margin < 0.1 * 400


def test_landscape_swaps_the_sides() -> None:
    upright, aside = paper("letter"), paper("letter", landscape=True)
    assert (aside.width, aside.height) == (upright.height, upright.width)


@pytest.mark.parametrize(
    ("size", "sides"),
    [
        ("1200x1800", (1200, 1800)),
        ("1200x1800px", (1200, 1800)),
        (" 800 X 600 ", (800, 600)),
        ("254x127mm", (1000, 500)),
        ("strip", (1080, 0)),
    ],
)
def test_sizes_in_pixels_and_millimetres(size: str, sides: tuple[int, int]) -> None:
    page = paper(size, 100)
    assert (page.width, page.height) == sides
    assert page.is_strip == (size == "strip")


@pytest.mark.parametrize(
    ("arguments", "subject", "reason"),
    [
        ({"size": "a44"}, "a44", "is not a paper size"),
        ({"size": "10x10"}, "10x10", "is a page of 10x10 pixels"),
        ({"size": "40000x100"}, "40000x100", "is a page of 40000x100 pixels"),
        ({"dpi": 0}, "--dpi", "0 is outside 10 to 2400"),
    ],
)
def test_impossible_paper_is_refused(arguments: dict, subject: str, reason: str) -> None:
    with pytest.raises(UsageError) as caught:
        paper(**arguments)
    assert caught.value.subject == subject
    assert reason in caught.value.reason
    assert "\n" not in str(caught.value)


def test_a_border_can_be_absent_but_never_invisible() -> None:
    assert paper("a4", 30, border=0).border == 0
    assert paper("a4", 30, border=0.5).border == 1
