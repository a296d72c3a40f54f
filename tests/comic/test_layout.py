"""Properties of comic pages of random films."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
import pytest
from comic_key_frames import LANDSCAPE, PORTRAIT, SQUARE, WIDE, even_film, random_film

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.cost import MAX_PANEL_ASPECT, MIN_PANEL_ASPECT, wanted_areas
from vidstyle.comic.layout.crop import largest_window, required_box
from vidstyle.comic.layout.inset import find_insets
from vidstyle.comic.layout.layout import PageLayout, Panel, lay_out
from vidstyle.comic.layout.pages import MAX_EXTRA_COST, MAX_EXTRA_COST_PER_PANEL, default_pages
from vidstyle.comic.layout.paper import Paper, paper
from vidstyle.comic.layout.slant import corners, upright_area
from vidstyle.comic.layout.weights import perturb_weights
from vidstyle.errors import UsageError
from vidstyle.regions.boxes import Box, Rectangle

PAPERS = [
    paper(size, 75, landscape=aside)
    for size, aside in (("a4", False), ("letter", True), ("square", False), ("611x1003", False))
]
SHAPE_SETS = [(LANDSCAPE,), (WIDE,), (SQUARE,), (LANDSCAPE, PORTRAIT), (PORTRAIT,)]
PANEL_COUNTS = (1, 2, 3, 5, 8, 13, 7, 10, 6, 9)


@dataclass(frozen=True)
class Case:
    key_frames: list[KeyFrame]
    paper: Paper
    backwards: bool
    layout: PageLayout
    seed: int


SAMPLED_CASES = [number for number in range(100) if number % 7 == 2]
"""Contains all shapes, papers and directions."""


@pytest.fixture(
    scope="module", params=[SAMPLED_CASES, pytest.param(range(100), marks=pytest.mark.thorough)], ids=len
)
def cases(request: pytest.FixtureRequest) -> list[Case]:
    """Lay out a hundred films of 1 to 40 panels, or a sample.

    They have mixed shapes, all papers, some seeds and both directions.
    """
    made = []
    for number in request.param:
        count = 40 if number in (9, 59) else PANEL_COUNTS[number % 10]
        key_frames = random_film(number, count, SHAPE_SETS[number // 10 % 5])
        page, seed, backwards = PAPERS[number % 4], number // 3 % 7, number % 3 == 0
        layout = lay_out(key_frames, page, seed=seed, right_to_left=backwards)
        made.append(Case(key_frames, page, backwards, layout, seed))
    return made


def panels_by_page(layout: PageLayout) -> list[list[Panel]]:
    return [[panel for panel in layout.panels if panel.page == page] for page in range(len(layout.sizes))]


def rows_of(panels: Sequence[Panel]) -> list[list[Rectangle]]:
    """Return the panels of a page at the top of each of its rows, from the left."""
    rows: list[list[Rectangle]] = []
    bottom = -1
    for rectangle in sorted((panel.rectangle for panel in panels), key=lambda each: (each.top, each.left)):
        if rectangle.top >= bottom:
            rows.append([])
            top = rectangle.top
        if rectangle.top == top:
            rows[-1].append(rectangle)
        bottom = max(bottom, rectangle.bottom)
    return rows


def is_read_first(one: Rectangle, other: Rectangle, backwards: bool) -> bool:
    """Whether one panel is read before the other: above it, or next to it on the side that is read first."""
    if one.top < other.bottom and other.top < one.bottom:
        return one.left >= other.right if backwards else one.right <= other.left
    return one.bottom <= other.top


def rank_correlation(one: Sequence[float], other: Sequence[float]) -> float:
    ranks = [np.argsort(np.argsort(values)) for values in (one, other)]
    return float(np.corrcoef(*ranks)[0, 1])


def test_panels_are_in_chronological_order(cases: list[Case]) -> None:
    for case in cases:
        assert [panel.key_frame for panel in case.layout.panels] == list(range(len(case.key_frames)))
        assert [panel.page for panel in case.layout.panels] == sorted(p.page for p in case.layout.panels)
        for panels in panels_by_page(case.layout):
            for one, other in combinations(panels, 2):
                assert is_read_first(one.rectangle, other.rectangle, case.backwards)


def gutter_after(one: Rectangle, panels: Sequence[Panel], page: Paper) -> int:
    """Return the width of the gutter at the right of a panel: next to a stack, as wide as in the stack."""
    beside = [
        each.rectangle
        for each in panels
        if each.rectangle.left >= one.right
        and each.rectangle.top < one.bottom
        and one.top < each.rectangle.bottom
    ]
    nearest = min(beside, key=lambda each: each.left, default=one)
    return page.gutter if (nearest.top, nearest.bottom) == (one.top, one.bottom) else page.row_gutter


def test_pages_are_filled_and_gutters_exact(cases: list[Case]) -> None:
    """With a gutter at its right and below it, the panels tile the page without gaps or overlaps."""
    stack_gutters = 0
    for case in cases:
        page, inside = case.paper, case.paper.inside
        for panels in panels_by_page(case.layout):
            times = np.zeros((inside.height + page.row_gutter, inside.width + page.gutter), int)
            for left, top, right, bottom in (panel.rectangle for panel in panels):
                gutter = gutter_after(Rectangle(left, top, right, bottom), panels, page)
                stack_gutters += gutter == page.row_gutter
                assert inside.left <= left and inside.top <= top
                assert right <= inside.right and bottom <= inside.bottom
                down = slice(top - inside.top, bottom - inside.top + page.row_gutter)
                times[down, left - inside.left : right - inside.left + gutter] += 1
            assert (times == 1).all()
    assert stack_gutters > len(cases)


def test_crops_fill_their_panels(cases: list[Case]) -> None:
    for case in cases:
        for panel in case.layout.panels:
            height, width = case.key_frames[panel.key_frame].shape
            crop, rectangle = panel.crop, panel.rectangle
            assert 0 <= crop.left and crop.right <= width and 0 <= crop.top and crop.bottom <= height
            assert crop.width * rectangle.height / rectangle.width == pytest.approx(crop.height, abs=0.01)


def test_no_panel_is_a_sliver(cases: list[Case]) -> None:
    for case in cases:
        # With few panels, such as one portrait picture on a landscape page, slivers are unavoidable.
        if len(case.key_frames) > 3:
            assert all(
                MIN_PANEL_ASPECT <= panel.rectangle.aspect <= MAX_PANEL_ASPECT for panel in case.layout.panels
            )


def test_saliency_is_rarely_cut(cases: list[Case]) -> None:
    shown = [
        panel.crop.intersection(key_frame.saliency).area / key_frame.saliency.area
        for case in cases
        for panel, key_frame in zip(case.layout.panels, case.key_frames, strict=True)
    ]
    assert np.mean(np.array(shown) > 0.999) > 0.9
    assert np.mean(shown) > 0.95


def test_more_important_panels_are_larger(cases: list[Case]) -> None:
    ranks = [
        rank_correlation(
            [key_frame.importance for key_frame in case.key_frames],
            [panel.rectangle.width * panel.rectangle.height for panel in case.layout.panels],
        )
        for case in cases
        if len(case.key_frames) >= 5
    ]
    assert np.mean(ranks) > 0.55
    assert np.quantile(ranks, 0.1) > 0.1


def test_successive_rows_differ(cases: list[Case]) -> None:
    alike = pairs = 0
    for case in cases:
        for panels in panels_by_page(case.layout):
            for one, other in pairwise(rows_of(panels)):
                pairs += 1
                same = [(a.left, a.right) for a in one] == [(b.left, b.right) for b in other]
                alike += same and abs(one[0].height - other[0].height) < 0.05 * case.paper.height
    assert pairs > 1.5 * len(cases)
    assert alike <= 0.01 * pairs


def test_the_same_seed_gives_the_same_pages(cases: list[Case]) -> None:
    for case in cases[:4]:
        again = lay_out(case.key_frames, case.paper, seed=case.seed, right_to_left=case.backwards)
        assert again == case.layout


def test_seeds_give_other_pages_that_cost_little_more(cases: list[Case]) -> None:
    others = Counter()
    for case in cases[-60:]:
        best = lay_out(case.key_frames, case.paper)
        most = MAX_EXTRA_COST + MAX_EXTRA_COST_PER_PANEL * len(case.key_frames)
        assert -1e-9 <= case.layout.cost - best.cost <= most + 1e-9
        if len(case.key_frames) >= 5 and case.seed:
            mirrored = lay_out(case.key_frames, case.paper, right_to_left=case.backwards)
            others[case.layout.panels != mirrored.panels] += 1
    assert others[True] >= 0.8 * others.total() > 0.2 * len(cases)


def test_seeds_differ_from_one_another() -> None:
    film = random_film(5, 9)
    pages = {
        tuple(panel.rectangle for panel in lay_out(film, PAPERS[0], seed=seed).panels) for seed in range(8)
    }
    assert len(pages) >= 5


def test_the_main_key_frame_is_meant_to_be_the_largest_with_every_seed() -> None:
    film = random_film(4, 5)
    main = max(range(5), key=lambda number: film[number].importance)
    for seed in range(20):
        areas = wanted_areas(film, 1e6, 1.0, perturb_weights(seed, 0, 5, []))
        assert areas[main] == areas.max()


def test_right_to_left_order_mirrors_the_page() -> None:
    film, page = random_film(3, 9), PAPERS[0]
    there, back = lay_out(film, page), lay_out(film, page, right_to_left=True)
    for one, other in zip(there.panels, back.panels, strict=True):
        assert (one.rectangle.left, one.rectangle.top) == (
            page.width - other.rectangle.right,
            other.rectangle.top,
        )
        assert one.crop == other.crop


def test_an_outstanding_key_frame_is_a_splash() -> None:
    film = even_film(9)
    for index in (0, 4, 8):
        marked = [replace(m, importance=1.0 if n == index else 0.3) for n, m in enumerate(film)]
        panels = lay_out(marked, PAPERS[0]).panels
        areas = [panel.rectangle.width * panel.rectangle.height for panel in panels]
        assert areas[index] > 0.3 * sum(areas)
        assert areas[index] > 1.8 * max(areas[:index] + areas[index + 1 :])


def test_a_splash_keeps_its_share_of_a_crowded_page() -> None:
    film = [replace(m, importance=1.0 if n == 6 else 0.3) for n, m in enumerate(even_film(14))]
    areas = [p.rectangle.width * p.rectangle.height for p in lay_out(film, PAPERS[0], pages=1).panels]
    assert areas[6] > 0.25 * sum(areas)


def test_equal_key_frames_do_not_make_a_regular_grid() -> None:
    for count in (6, 8, 9, 12):
        panels = lay_out(even_film(count), PAPERS[0], pages=1).panels
        assert len({panel.rectangle.width for panel in panels}) > 2


def test_pages_prefer_to_end_with_a_scene() -> None:
    for first in (6, 7):
        film = [
            replace(key_frame, scene=int(number >= first)) for number, key_frame in enumerate(even_film(13))
        ]
        pages = Counter(panel.page for panel in lay_out(film, PAPERS[0]).panels)
        assert pages[0] == first


def test_the_number_of_pages_can_be_requested() -> None:
    film = random_film(1, 13)
    for pages in (1, 2, 5, 13):
        layout = lay_out(film, PAPERS[0], pages=pages)
        assert {panel.page for panel in layout.panels} == set(range(pages))
        assert len(layout.sizes) == pages
    for pages in (0, 14):
        with pytest.raises(UsageError, match=f"--pages: {pages} are too many for 13 panels"):
            lay_out(film, PAPERS[0], pages=pages)
    with pytest.raises(UsageError, match="no key frame"):
        lay_out([], PAPERS[0])


def test_pages_have_similar_numbers_of_panels() -> None:
    for count in (13, 40):
        pages = Counter(panel.page for panel in lay_out(random_film(2, count), PAPERS[0]).panels)
        assert len(pages) == default_pages(count)
        assert max(pages.values()) <= 2 * min(pages.values())


def test_only_full_width_panels_bleed() -> None:
    page = paper("a4", 75)
    film = random_film(4, 13)
    plain, bled = lay_out(film, page), lay_out(film, page, bleeding=True)
    beyond = 0
    for one, other in zip(plain.panels, bled.panels, strict=True):
        if one.rectangle.width == page.inside.width:
            beyond += 1
            assert (other.rectangle.left, other.rectangle.right) == (0, page.width)
            assert (other.rectangle.top == 0) == (one.rectangle.top == page.inside.top)
        else:
            assert other == one
        assert other.crop.width / other.crop.height == pytest.approx(other.rectangle.aspect)
    assert beyond


def test_an_area_scale_enlarges_its_panel() -> None:
    grown = []
    for seed in range(10):
        film = random_film(seed, 9)
        area_scales = [2.0 if number == 4 else 1.0 for number in range(9)]
        before, after = lay_out(film, PAPERS[0]), lay_out(film, PAPERS[0], area_scales=area_scales)
        areas = [each.panels[4].rectangle.width * each.panels[4].rectangle.height for each in (after, before)]
        grown.append(areas[0] / areas[1])
    assert np.mean(grown) > 1.25


@pytest.mark.parametrize("size", ["3000x750", "500x2000"])
def test_very_wide_and_very_tall_pages_have_no_slivers(size: str) -> None:
    for count in (2, 7, 20):
        layout = lay_out(random_film(count, count), paper(size))
        aspects = [panel.rectangle.aspect for panel in layout.panels]
        assert min(aspects) >= MIN_PANEL_ASPECT
        assert max(aspects) <= MAX_PANEL_ASPECT


def test_empty_and_full_saliency_can_be_laid_out() -> None:
    film = even_film(5)
    film[1], film[3] = (replace(film[1], saliency=box) for box in (Box(0, 0, 0, 0), Box(0, 0, 1920, 1080)))
    assert len(lay_out(film, PAPERS[0]).panels) == 5


@pytest.mark.parametrize("count", [1, 2, 9, 40])
def test_a_strip_is_one_column_of_varied_heights_and_pauses(count: int) -> None:
    page = paper("strip")
    film = random_film(count, count)
    layout = lay_out(film, page, seed=count % 3)
    rectangles = [panel.rectangle for panel in layout.panels]
    inside = page.inside
    for each in rectangles:
        assert inside.left <= each.left < each.right <= inside.right
        assert (each.left == inside.left) + (each.right == inside.right) == 1 + (each.width == inside.width)
        assert each.width > 0.7 * inside.width
    assert count % 3 or {each.width for each in rectangles} == {inside.width}
    assert layout.sizes == ((page.width, rectangles[-1].bottom + page.margin),)
    pauses = [other.top - one.bottom for one, other in pairwise(rectangles)]
    assert all(pause in (page.row_gutter, 2 * page.row_gutter, 3 * page.row_gutter) for pause in pauses)
    assert all(MIN_PANEL_ASPECT <= each.aspect <= MAX_PANEL_ASPECT for each in rectangles)
    same = sum(abs(one.height / other.height - 1) < 0.03 for one, other in pairwise(rectangles))
    assert same <= 0.1 * count


def test_seeds_inset_panels_of_a_strip_from_both_sides() -> None:
    page, film = paper("strip"), random_film(5, 8)
    strips = [[panel.rectangle for panel in lay_out(film, page, seed=seed).panels] for seed in range(12)]
    shapes = {tuple((each.left, each.width) for each in strip) for strip in strips}
    assert len(shapes) >= 6
    lefts = {
        each.left > page.inside.left for strip in strips for each in strip if each.width < page.inside.width
    }
    assert lefts == {True, False}
    drawn_in = [sum(each.width < page.inside.width for each in strip) for strip in strips]
    assert drawn_in[0] == 0 and max(drawn_in) <= 5


def test_a_strip_pauses_when_time_passes_and_most_at_scene_ends() -> None:
    film = [
        replace(key_frame, time=time, scene=scene)
        for key_frame, time, scene in zip(even_film(4), (0, 1, 3, 6), (0, 0, 0, 1), strict=True)
    ]
    rectangles = [panel.rectangle for panel in lay_out(film, paper("strip")).panels]
    pauses = [other.top - one.bottom for one, other in pairwise(rectangles)]
    assert pauses[0] < pauses[2]
    assert pauses == [paper("strip").row_gutter * times for times in (1, 1, 3)]


def test_slanted_gutters_are_as_wide_as_straight_ones() -> None:
    """At both ends; panels cover the same page, and gutters of whole rows lean to either side in turn."""
    page, key_frames = paper("a4"), random_film(3, 24)
    straight = lay_out(key_frames, page, kind="classic")
    leaning = lay_out(key_frames, page, kind="dynamic")
    sides = []
    for one, other in pairwise(leaning.panels):
        left, right = corners(one.rectangle, one.leans), corners(other.rectangle, other.leans)
        if one.leans[1] == 0 or other.leans[0] == 0:
            continue
        sides.append(one.leans[1] > 0)
        for end, start in ((left[1], right[0]), (left[2], right[3])):
            assert end[1] == start[1] and start[0] - end[0] == page.gutter
    assert set(sides) == {True, False}
    for before, after in zip(straight.panels, leaning.panels, strict=True):
        assert after.rectangle.contains(before.rectangle)
        assert before.rectangle.contains(upright_area(after.rectangle, after.leans))
        assert after.crop.aspect == pytest.approx(after.picture.aspect)
    assert all(each.leans == (0, 0) for each in straight.panels)


@pytest.mark.parametrize("count", [1, 2, 5, 6, 9, 16])
def test_a_grid_has_equal_panels_in_reading_order(count: int) -> None:
    page = paper("a4")
    panels = lay_out(even_film(count), page, kind="grid").panels
    for one, other in combinations(panels, 2):
        assert one.page != other.page or one.rectangle.intersection(other.rectangle).area == 0
        assert is_read_first(one.rectangle, other.rectangle, False) or one.page < other.page
    heights = Counter(each.rectangle.height for each in panels if each.page == 0)
    assert max(heights) - min(heights) <= 1
    bottom, right = (max(getattr(each.rectangle, side) for each in panels) for side in ("bottom", "right"))
    assert (right, bottom) == (page.inside.right, page.inside.bottom)


def test_a_close_up_is_an_inset_over_a_calm_corner() -> None:
    """It is in the panel before it, clear of faces; without a calm corner it becomes an ordinary panel."""
    key_frames = even_film(8)
    face = Box(800.0, 300.0, 1100.0, 700.0)
    key_frames[4] = replace(key_frames[4], faces=(face,), saliency=face)
    assert not find_insets(key_frames, [False] * 8)  # the only person
    key_frames[0] = replace(key_frames[0], faces=(face,))
    insets = find_insets(key_frames, [False] * 8)
    assert insets == (4,) and not find_insets(key_frames, [True] * 8)
    for backwards in (False, True):
        layout = lay_out(key_frames, PAPERS[0], insets=insets, right_to_left=backwards, kind="dynamic")
        below, inset = layout.panels[3:5]
        assert [each.key_frame for each in layout.panels] == list(range(8))
        assert below.insets == (inset.rectangle,) and below.rectangle.contains(inset.rectangle)
        assert inset.rectangle.area < 0.25 * below.rectangle.area
    all_over = replace(key_frames[3], saliency=Box(0.0, 0.0, 1920.0, 1080.0))
    full = [*key_frames[:3], all_over, *key_frames[4:]]
    assert lay_out(full, PAPERS[0], insets=insets) == lay_out(full, PAPERS[0])


def test_dark_panels_are_balanced() -> None:
    """The balance of light and dark is part of a layout's cost."""
    lights = [0.1, 0.9] * 4
    key_frames = [replace(each, light=light) for each, light in zip(even_film(8), lights, strict=True)]

    def imbalance(layout: PageLayout) -> float:
        ink = np.array([(1 - lights[each.key_frame]) * each.rectangle.area for each in layout.panels])
        aside = np.array(
            [np.subtract(each.rectangle.center, PAPERS[0].inside.center) for each in layout.panels]
        )
        return float(np.hypot(*(ink @ aside))) / ink.sum()

    assert imbalance(lay_out(key_frames, PAPERS[0])) < imbalance(lay_out(even_film(8), PAPERS[0]))


def test_a_panel_is_never_worse_than_the_whole_picture(cases: list[Case]) -> None:
    """The main face is whole if it fits, and larger than in a panel with the whole picture."""
    for case in cases:
        for panel in case.layout.panels:
            key_frame = case.key_frames[panel.key_frame]
            height, width = key_frame.shape
            kept, room = required_box(key_frame), largest_window(key_frame, panel.picture.aspect)
            if key_frame.faces and kept.width <= room[0] and kept.height <= room[1]:
                face = max(key_frame.faces, key=lambda face: face.area)
                assert panel.crop.intersection(face).area > 0.999 * face.area
            whole = min(panel.picture.width / width, panel.picture.height / height)
            assert panel.picture.width / panel.crop.width >= whole * (1 - 1e-2)


@pytest.mark.parametrize("apart", [300, 900, 1400])
def test_the_shape_of_a_panel_changes_before_a_pair_is_separated(apart: int) -> None:
    key_frames = even_film(7)
    pair = tuple(Box(left, 300.0, left + 250, 600.0) for left in (130.0, 130.0 + apart))
    for number in (1, 4):
        alone = replace(key_frames[number], faces=pair, saliency=pair[0])
        layout = lay_out([*key_frames[:number], alone, *key_frames[number + 1 :]], PAPERS[0])
        assert all(layout.panels[number].crop.contains(face) for face in pair)


@pytest.mark.parametrize("count", [4, 5, 6])
def test_a_place_at_the_start_is_not_larger_than_people(count: int) -> None:
    """Though its importance is close to theirs and its picture wants the width of the page."""
    place, *others = even_film(count, WIDE)
    face = Box(300, 60, 420, 200)
    people = [replace(each, faces=(face,), importance=0.6) for each in others]
    layout = lay_out([replace(place, importance=0.45), *people], paper("a4", 75))
    areas = [panel.rectangle.area for panel in layout.panels]
    assert areas[0] < max(areas[1:])
