"""Paper sizes, margins and gutters."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.fit import MIN_SOURCE_DPI, fit_paper, place_panels
from vidstyle.comic.layout.layout import PageLayout, lay_out
from vidstyle.comic.layout.paper import PAPER_SIZES_MM, Paper, paper
from vidstyle.errors import UsageError
from vidstyle.regions.boxes import Box


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


def key_frames_of(count: int, width: int, height: int) -> list[KeyFrame]:
    whole = Box(0.0, 0.0, float(width), float(height))
    return [KeyFrame(float(number), (height, width), 0.5, whole, (), number) for number in range(count)]


def pages_of(key_frames: Sequence[KeyFrame], page: Paper, is_trimmed: bool = False) -> PageLayout:
    fitted = fit_paper(page, key_frames, [1.0] * len(key_frames))
    return place_panels(lay_out(key_frames, fitted), fitted, page, is_trimmed, is_trimmed)


@pytest.mark.parametrize("count", [1, 2])
def test_a_small_film_gets_small_panels_in_the_middle_of_the_page(count: int) -> None:
    page = paper()
    layout = pages_of(key_frames_of(count, 320, 240), page)
    assert layout.sizes == ((page.width, page.height),)
    for panel in layout.panels:
        assert panel.rectangle.width <= 320 * page.dpi / MIN_SOURCE_DPI + 1
        assert panel.crop.width > 300  # nearly the whole picture
    left, right = (pick(each) for pick, each in (
        (min, [panel.rectangle.left for panel in layout.panels]),
        (max, [panel.rectangle.right for panel in layout.panels]),
    ))  # fmt: skip
    assert abs(left - (page.width - right)) <= 2


def test_a_trimmed_page_has_the_height_of_its_panels_and_equal_margins() -> None:
    page = paper()
    layout = pages_of(key_frames_of(2, 1920, 1080), page, is_trimmed=True)
    ((width, height),) = layout.sizes
    ((small_width, _),) = pages_of(key_frames_of(2, 320, 240), page, is_trimmed=True).sizes
    assert width == page.width > small_width
    assert height < 0.9 * page.height
    assert min(each.rectangle.top for each in layout.panels) == page.margin
    assert height - max(each.rectangle.bottom for each in layout.panels) == pytest.approx(page.margin, abs=1)


def test_a_single_large_picture_has_its_own_shape() -> None:
    (panel,) = pages_of(key_frames_of(1, 1920, 1080), paper()).panels
    assert panel.rectangle.width == paper().inside.width
    assert panel.rectangle.aspect == pytest.approx(16 / 9, rel=0.05)


def test_many_large_pictures_fill_the_page() -> None:
    page = paper()
    for key_frames in (key_frames_of(3, 1920, 1080), key_frames_of(6, 640, 480)):
        assert fit_paper(page, key_frames, [1.0] * len(key_frames)) == page


def test_panels_grow_for_their_text() -> None:
    key_frames = key_frames_of(1, 320, 240)
    usual, roomy = (fit_paper(paper(), key_frames, [scale]) for scale in (1.0, 1.6))
    assert roomy.inside.area > 1.3 * usual.inside.area


@pytest.mark.parametrize(("width", "height"), [(1, 1), (2, 4000), (4000, 2), (16, 16)])
def test_extreme_pictures_get_a_panel(width: int, height: int) -> None:
    (panel,) = pages_of(key_frames_of(1, width, height), paper()).panels
    assert panel.rectangle.width > 100 and panel.rectangle.height > 100


def test_strips_are_unchanged() -> None:
    assert fit_paper(paper("strip"), key_frames_of(1, 32, 24), [1.0]) == paper("strip")
