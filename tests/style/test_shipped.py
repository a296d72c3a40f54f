"""The shipped styles as a set: they are complete, have notes, and look different."""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from covering import in_one_test, of_the_day
from media import photograph

from vidstyle.renderer import Renderer, stylize
from vidstyle.style import PLAIN, load_style, style_names

OF_THE_PAPER = ("ink", "crayon", "sketch", "cartoon", "impressionist")
STYLES = sorted(set(style_names()) - {PLAIN})
VARIANTS = [f"{name}:{variant}" for name in STYLES for variant in load_style(name).variants]
CLEAR = 12 / 255
"""Mean distance per sample of two pictures that nobody takes for the same style."""


@cache
def styled(name: str) -> np.ndarray:
    """A photograph of a person in the style, float32 RGB 0..1."""
    return stylize(photograph("astronaut"), name, device="cpu").astype(np.float32) / 255


def distance(one: str, other: str) -> float:
    return float(np.abs(styled(one) - styled(other)).mean())


def test_the_styles_of_the_paper_are_there() -> None:
    assert set(OF_THE_PAPER) < set(STYLES)


@in_one_test("name", STYLES)
def test_a_style_says_what_it_is_and_holds_still_at_any_size(name: str) -> None:
    style = load_style(name)
    assert len(style.note) >= 40
    assert style.steady > 0
    assert style.height == 720


@pytest.mark.parametrize("name", STYLES)
def test_a_style_changes_a_photograph_clearly(name: str) -> None:
    assert distance(name, PLAIN) > CLEAR


def test_no_two_styles_look_alike() -> None:
    pairs = {pair: distance(*pair) for pair in combinations(STYLES, 2)}
    assert {pair: found for pair, found in pairs.items() if found <= CLEAR} == {}


@pytest.mark.parametrize("name", of_the_day(VARIANTS, 12))
def test_a_variant_looks_other_than_its_style(name: str) -> None:
    """Return the result a second later, when redrawn marks differ."""
    made = []
    for each in (name, name.partition(":")[0]):
        with Renderer(each, device="cpu") as renderer:
            made.append(renderer(photograph("astronaut"), 1.0))
    assert not np.array_equal(*made)
