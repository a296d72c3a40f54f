"""Screens of nine that follow from choices, the taste learned from them, and the tuning pad."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise, product

import cv2
import numpy as np
import pytest
from covering import of_the_day
from media import photograph

from vidstyle.explore.choosing import candidate_generator
from vidstyle.explore.choosing import chooser as chooser_file
from vidstyle.explore.choosing.chooser import MAX_ROUNDS, Chooser
from vidstyle.explore.choosing.taste import Taste
from vidstyle.explore.choosing.tile_screen import FIRST_SCREEN_KINDS, SCREEN_KINDS, Tile
from vidstyle.explore.choosing.tile_selector import (
    MAX_EQUAL_RASTERS,
    MIN_LOOK_DISTANCE,
    MIN_TILE_DISTANCE,
    TileSelector,
)
from vidstyle.explore.colors import oklab
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.look import Look, look_distance, look_of
from vidstyle.explore.tuning_pad import tuning_pad_of
from vidstyle.style import Step, Style, load_style

MIDDLE = 4
PICTURE = cv2.resize(photograph("astronaut")[:340], (96, 64), interpolation=cv2.INTER_AREA)
SHIPPED = shipped_styles()
_known: dict[str, Look | None] = {}


def looks(styles: Sequence[Style]) -> list[Look | None]:
    """What styles make of a small photograph; each is tried once in all tests."""
    for style in styles:
        if repr(style) not in _known:
            _known[repr(style)] = look_of(PICTURE, style)
    return [_known[repr(style)] for style in styles]


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer candidates than on the page, as each takes 25 ms."""
    fewer = {"values": 6, "step": 3, "cross": 1, "wild": 1, "shipped": 4}
    monkeypatch.setattr(candidate_generator, "CANDIDATE_COUNTS", fewer)


def chooser(seed: int = 1, **given: object) -> Chooser:
    made = Chooser(looks, SHIPPED, seed, **given)  # type: ignore[arg-type]
    made.new_screen()
    return made


def names(tiles: Sequence[Tile]) -> list[str]:
    return [tile.style.name for tile in tiles]


def distances(made: Chooser, place: int) -> list[float]:
    """How far the mutants that a choice of this tile shows are from it."""
    notes = [style.note for style in made.likely_styles(place)]
    found = [re.findall(r"other values, distance ([\d.]+)", note)[-1:] for note in notes[:6]]
    return [float(distance) for (distance,) in found]


def structure(style: Style) -> dict[str, list[str]]:
    return {layer: [step.block for step in steps] for layer, steps in style.layers.items()}


def test_the_first_screen_has_mutants_of_shipped_styles_and_nothing_that_fails() -> None:
    screen = chooser().screen
    # Other kinds replace a kind of which too few pass.
    assert (Counter(FIRST_SCREEN_KINDS) - Counter(tile.kind for tile in screen.tiles)).total() <= 2
    shipped = {style.name for style in SHIPPED}
    mutants = [tile for tile in screen.tiles if tile.kind == "shipped"]
    assert len(mutants) >= 3 and {name for tile in mutants for name in tile.parents} <= shipped
    assert not [tile.look.fault for tile in screen.tiles if tile.look.fault]


def test_few_tiles_of_a_first_screen_have_the_same_marks() -> None:
    engraved = [Style("engraved", background=(Step("line_screen", {"angle": angle}),)) for angle in range(9)]
    others = [load_style(name) for name in ("poster", "oil", "noir")]
    look = look_of(PICTURE, others[0])
    assert look is not None
    found = []
    for number, style in enumerate([*engraved, *others]):
        apart = replace(look, signature=look.signature + number)
        vars(apart)["appearance"] = np.array([2.0 * number])
        found.append(Tile(style, "wild", apart))
    selector = TileSelector(lambda looks: np.linspace(100, 0, len(looks)), 0.4)
    chosen = selector.select(Counter({"wild": 4}), [], found)
    assert sum(tile.style in engraved for tile in chosen) == MAX_EQUAL_RASTERS
    assert len(selector.select(Counter({"wild": 4}), [], found[:9])) == 4, "if there are enough others"


@pytest.mark.parametrize("good", [0, 3])
def test_a_picture_that_few_styles_suit_gets_nine_tiles_too(
    good: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    passed: list[Style] = []

    def fail_most(styles: Sequence[Style]) -> list[Look | None]:
        passed.extend(styles[: good - len(passed)])
        return [
            look and replace(look, fault="" if style in passed else "muddy")
            for style, look in zip(styles, looks(styles), strict=True)
        ]

    monkeypatch.setattr(chooser_file, "MAX_OTHER_ROUNDS", 1)
    made = Chooser(fail_most, shipped_styles(), 1)
    tiles = made.new_screen().tiles
    assert len({repr(tile.style) for tile in tiles}) == 9
    assert {tile.style.name for tile in tiles if not tile.look.fault} == {style.name for style in passed}
    assert len(made.more_like(0).tiles) == 9


def test_the_tile_that_was_taken_stays_in_the_middle_and_the_others_follow_from_it() -> None:
    made = chooser()
    taken = made.screen.tiles[2]
    tiles = made.more_like(2).tiles
    assert (tiles[MIDDLE].style, tiles[MIDDLE].kind) == (taken.style, "chosen")
    # Other kinds replace a kind of which too few pass or look different: there are four of other kinds.
    assert (Counter(SCREEN_KINDS) - Counter(tile.kind for tile in tiles)).total() <= 3
    for tile in tiles:
        if tile.kind in ("values", "step", "cross"):
            assert tile.parents[0] == taken.style.name
        if tile.kind == "values":
            assert structure(tile.style) == structure(taken.style) and tile.style != taken.style


def test_no_two_tiles_look_alike_and_none_fails() -> None:
    made = chooser()
    for screen in (made.screen, made.more_like(2)):
        for place, one in enumerate(screen.tiles):
            assert not one.look.fault or place == MIDDLE
            assert all(
                look_distance(one.look, other.look) >= MIN_TILE_DISTANCE for other in screen.tiles[:place]
            )


def test_a_screen_shows_different_looks_and_repeated_choices_do_not_end_that(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    more = {"values": 6, "step": 4, "cross": 2, "wild": 3, "shipped": 10}
    monkeypatch.setattr(candidate_generator, "CANDIDATE_COUNTS", more)
    made, place = chooser(near=0.1), 2
    assert different_looks(made.screen.tiles) >= 7
    counts = []
    for _ in range(2):
        tiles = made.more_like(place).tiles
        place = MIDDLE
        counts.append(different_looks(tiles))
    # The choice and what is near it are one look, and four others are wanted; one of eight may have failed.
    assert sum(counts) >= 9, counts
    near, far = (
        np.mean([np.linalg.norm(tile.look.appearance - tiles[MIDDLE].look.appearance) for tile in some])
        for some in (
            [tile for tile in tiles if tile.kind == "values"],
            [tile for tile in tiles if tile.kind not in ("values", "chosen")],
        )
    )
    assert near < 0.7 * far


def different_looks(tiles: Sequence[Tile]) -> int:
    """The number of tiles, in order, that are different looks from all before."""
    found: list[np.ndarray] = []
    for tile in tiles:
        if all(np.linalg.norm(tile.look.appearance - each) >= MIN_LOOK_DISTANCE for each in found):
            found.append(tile.look.appearance)
    return len(found)


def test_the_same_seed_and_the_same_clicks_give_the_same_screens_and_others_do_not() -> None:
    made, again = chooser(), chooser()
    assert names(made.more_like(2).tiles) == names(again.more_like(2).tiles)
    assert not set(names(made.screen.tiles)) & set(names(chooser(2).screen.tiles))


def test_what_the_next_click_will_try_is_known_before_it() -> None:
    tried: list[str] = []

    def recorded(styles: Sequence[Style]) -> list[Look | None]:
        tried.extend(style.name for style in styles)
        return looks(styles)

    made = chooser()
    likely = [style.name for style in made.likely_styles(2)]
    made.looks = recorded
    made.more_like(2)
    assert tried[: len(likely)] == likely


@pytest.mark.parametrize("lock", of_the_day(["lines", "background", "colors", "steps"], 2))
def test_what_is_locked_stays(lock: str) -> None:
    made = chooser()
    made.locks = frozenset({lock})
    for _ in range(5):  # which styles are drawn depends on the shipped ones
        if any(tile.style.lines and tile.style.background for tile in made.screen.tiles):
            break
        made.new_screen()
    place = next(n for n, tile in enumerate(made.screen.tiles) if tile.style.lines and tile.style.background)
    taken = made.screen.tiles[place].style
    for tile in made.more_like(place).tiles:
        if tile.kind != "wild" or lock == "steps":
            same = {
                "lines": tile.style.lines == taken.lines,
                "background": tile.style.background == taken.background,
                "colors": (tile.style.ink, tile.style.paper) == (taken.ink, taken.paper),
                "steps": structure(tile.style) == structure(taken),
            }
            assert same[lock], tile.kind


@pytest.mark.thorough
def test_with_everything_locked_there_are_nine_tiles_still() -> None:
    made = chooser()
    made.locks = frozenset({"lines", "background", "colors", "steps"})
    assert len(made.more_like(2).tiles) == 9


@pytest.mark.thorough
def test_far_is_farther_than_near() -> None:
    def spread(near: float) -> float:
        made = chooser(near=near)
        tiles = made.more_like(2).tiles
        apart = [look_distance(tiles[MIDDLE].look, tile.look) for tile in tiles if tile.kind == "values"]
        return float(np.mean(apart))

    assert spread(0.1) < spread(0.8)


def test_one_goes_back_to_where_one_came_from_and_forward_again() -> None:
    made = chooser()
    first = made.screen
    second = made.more_like(2)
    made.back()
    assert made.screen is first and first.taken == 2
    made.back()  # there is none before
    assert made.screen is first
    made.forward()
    assert made.screen is second


def test_later_tiles_are_crossed_with_what_is_kept() -> None:
    made = chooser()
    kept = made.screen.tiles[0]
    made.star(kept, True)
    assert made.stars == [kept]
    crossed = [each for each in made._generate(made.screen.tiles[2], 0) if each.kind == "cross"]
    assert kept.style.name in crossed[0].parents
    made.star(kept, False)
    assert made.stars == []


def test_taste_follows_clicks() -> None:
    """Of pictures with four numbers, somebody always takes that with the largest first one."""
    random = np.random.default_rng(5)
    taste = Taste(np.array([0.0, 1.0, 0.0, 0.0]))
    assert taste.utility(np.eye(4)).argmax() == 1
    for _ in range(8):
        shown = random.normal(size=(9, 4))
        best = int(shown[:, 0].argmax())
        taste.learn(shown[best], list(np.delete(shown, best, axis=0)))
    shown = random.normal(size=(200, 4))
    assert np.corrcoef(taste.utility(shown), shown[:, 0])[0, 1] > 0.9


def test_a_tuning_pad_has_the_style_on_it_and_changes_what_is_seen() -> None:
    paint = {"block": "posterize", "levels": 4}, {"block": "saturation", "factor": 0.5}
    lines = {"block": "flow_xdog", "sigma": 1.4, "p": 20}
    knobs = ["flow_xdog.p", "saturation.factor"]
    table = {"format": 1, "height": 720, "background": [*paint], "lines": [lines]}
    style, plain = load_style({**table, "knobs": knobs}), tuning_pad_of(load_style(table), looks)
    pad = tuning_pad_of(style, looks)
    assert plain is not None and pad is not None
    assert {axis.path for axis in pad.axes} == set(knobs) != {axis.path for axis in plain.axes}
    (same,) = looks([pad.style_at(*pad.start)])
    (own, *corners) = looks([style, *(pad.style_at(x, y) for x in (0, 1) for y in (0, 1))])
    assert own is not None and same is not None and look_distance(own, same) < 0.02
    assert all(each is not None and look_distance(own, each) > MIN_TILE_DISTANCE for each in corners)


def test_the_axes_of_a_tuning_pad_change_the_picture_in_both_directions() -> None:
    paint = {"block": "saturation", "factor": 0.5}, {"block": "posterize", "levels": 4}, {"block": "invert"}
    style = load_style({"format": 1, "height": 720, "background": [*paint]})
    pad = tuning_pad_of(style, looks)
    assert pad is not None and "invert.above" not in {axis.path for axis in pad.axes}


class ColorLook(Look):
    """What somebody sees who looks at ink and paper only."""

    appearance = property(lambda self: self.signature)  # type: ignore[assignment]


def point_of(*colors: str) -> np.ndarray:
    codes = [[int(color[place : place + 2], 16) / 255 for place in (1, 3, 5)] for color in colors]
    return 5 * oklab(np.array(codes)).ravel()


def color_looks(styles: Sequence[Style]) -> list[Look | None]:
    points = [point_of(style.ink, style.paper) for style in styles]
    return [ColorLook(np.zeros((1, 1, 3), np.uint8), point, point) for point in points]


def test_who_takes_the_nearest_tile_comes_nearer_than_who_takes_any() -> None:
    """`tools/explore/simulated_user.py` does the same with pictures."""
    wishes = [point_of("#102a80", "#f5d0d8"), point_of("#f0e060", "#203010"), point_of("#803010", "#e8f4ff")]
    nearest: dict[bool, list[float]] = {True: [], False: []}
    for choice, seed, wish in product(nearest, (3, 4), wishes):
        made, random = Chooser(color_looks, SHIPPED, seed), np.random.default_rng(seed)
        made.new_screen()
        for _ in range(5):
            apart = [float(np.linalg.norm(tile.look.signature - wish)) for tile in made.screen.tiles]
            made.more_like(int(np.argmin(apart)) if choice else int(random.integers(9)))
        nearest[choice].append(min(apart))
    assert np.mean(nearest[True]) < 0.8 * np.mean(nearest[False])


def test_a_tile_that_is_taken_again_gives_nearer_ones() -> None:
    made, place = Chooser(color_looks, SHIPPED), 2
    made.new_screen()
    found = [distances(made, place)]
    for _ in range(3):
        made.more_like(place)
        place = MIDDLE
        found.append(distances(made, place))
    for before, after in pairwise(found):
        assert after == pytest.approx([0.7 * distance for distance in before], rel=1e-4)
    assert distances(made, 0) == found[0], "another tile begins at the first distance"


def test_nine_tiles_differ_even_where_all_that_is_near_the_choice_looks_alike() -> None:
    made = chooser()
    taken = made.screen.tiles[2]
    made._learn(2)
    rounds = range(MAX_ROUNDS)
    alike = {repr(each.style) for number in rounds for each in made._generate(taken, number)}
    made.looks = lambda styles: [taken.look if repr(each) in alike else looks([each])[0] for each in styles]
    tiles = made.more_like(2).tiles
    apart = [look_distance(one.look, other.look) for at, one in enumerate(tiles) for other in tiles[:at]]
    assert min(apart) >= MIN_TILE_DISTANCE
