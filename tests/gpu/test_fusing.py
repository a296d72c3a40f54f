"""Random styles give the same result with fused calls and with a separate pass for each call."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import pytest
from covering import DAY, of_the_day
from gpu import (
    FORMS,
    SMALL,
    Sessions,
    differences,
    disagreements,
    faults,
    film_picture,
    gray_picture,
    max_code_difference,
    packed_picture,
)
from pictures import VIDEO, run, step
from random_styles import Chance

from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.gpu.compile.passes import MAX_STORED_VALUES
from vidstyle.gpu.compile.plan import make_plan
from vidstyle.style import Step, Style
from vidstyle.style.resolve import resolve

SHAPE = SMALL
SOURCES = (
    film_picture(*SHAPE),
    film_picture(*SHAPE, Encoding(subsampling=(1, 1))),
    gray_picture(*SHAPE),
    packed_picture(*SHAPE),
)


fused = Sessions.fixture()
apart = Sessions.fixture(fused=False)
"""Sessions with a pass for each call."""


def pages_of(chosen: Style, seed: int, *sessions: Sessions) -> Iterator[tuple[str, list[Picture]]]:
    """For each form, the result on the CPU and in each session."""
    source = SOURCES[seed % len(SOURCES)]
    started = {form: [each.start(form, chosen, source, target=VIDEO) for each in sessions] for form in FORMS}
    right = run(chosen, source, target=VIDEO)
    for form, pages in started.items():
        yield form, [right, *(page() for page in pages)]


TAME, WILD, LEARNED = range(50), (*range(50, 85), *range(90, 105)), range(100, 116)
"""Seeds of styles that are known to agree."""


@pytest.mark.parametrize("seed", of_the_day(TAME, 5))
def test_random_styles_agree_fused_and_unfused(seed: int, fused: Sessions, apart: Sessions) -> None:
    chosen = Chance(seed, wild=False).style()
    for form, (right, one, other) in pages_of(chosen, seed, fused, apart):
        assert max_code_difference(one, other) <= 1, (form, chosen)
        assert disagreements(right, one) == [], (form, chosen)


@pytest.mark.parametrize("seed", of_the_day(WILD, 5))
def test_wild_styles_agree_except_for_few_samples(seed: int, fused: Sessions, apart: Sessions) -> None:
    """If contrast is increased a thousandfold, rounding in textures is visible in some samples."""
    chosen = Chance(seed, wild=True).style()
    for form, (right, one, other) in pages_of(chosen, seed, fused, apart):
        assert disagreements(one, other) == [], (form, chosen)
        assert disagreements(right, one) == [], (form, chosen)


def most_different(fused: Sessions, apart: Sessions, seeds: Iterable[int]) -> list[float]:
    """The share of samples that differ by more than a level, of each style with learned blocks and form."""
    off = []
    for seed in seeds:
        chosen = Chance(seed, wild=False, learned=True).style()
        for _, (right, *pages) in pages_of(chosen, seed, fused, apart):
            for page in pages:
                shares = [(np.abs(levels) > 1).mean() for levels in differences(right, page).values()]
                off.append(max(shares))
    return off


def test_learned_blocks_agree_except_at_ambiguous_structure(fused: Sessions, apart: Sessions) -> None:
    """At the border of two bins rounding decides; later steps may amplify the difference."""
    seeds = np.random.default_rng(DAY).choice(LEARNED, 2, replace=False)
    assert max(most_different(fused, apart, seeds)) < 0.03, seeds


@pytest.mark.thorough
def test_learned_blocks_agree_on_average(fused: Sessions, apart: Sessions) -> None:
    off = most_different(fused, apart, LEARNED)
    assert np.mean(off) < 0.003 and max(off) < 0.03, off


@pytest.mark.thorough
def test_random_styles_of_the_day_agree(fused: Sessions, apart: Sessions) -> None:
    """With new seeds every day."""
    found = []
    for seed in range(DAY * 100, DAY * 100 + 32):
        chosen = Chance(seed, wild=False).style()
        for form, (right, one, other) in pages_of(chosen, seed, fused, apart):
            found += [f"{seed} {form}: {line}" for line in disagreements(right, one)]
            if max_code_difference(one, other) > 1:
                found.append(f"{seed} {form}: fused and apart differ")
    assert not found, "\n".join(found)


def many_saved(*first: Step) -> Style:
    """Saves twelve pictures, then blurs each and blends all of them."""
    names = [f"tone_{number}" for number in range(12)]
    base = [
        step("brightness", name, first[-1].save if first else "source", factor=0.5 + 0.1 * number)
        for number, name in enumerate(names)
    ]
    base += [step("gaussian", f"soft_{name}", name, sigma=0.8) for name in names]
    base += [step("blend", other=f"soft_{name}", mode="lighten", opacity=0.4) for name in names]
    return Style("many", base=(*first, *base))


@pytest.mark.parametrize(
    "chosen", [many_saved(), many_saved(step("gaussian", save="start"))], ids=["of planes", "of a blur"]
)
def test_no_pass_stores_more_pictures_than_render_targets(chosen: Style, fused: Sessions) -> None:
    for form in FORMS:
        plan = make_plan(chosen, resolve(chosen, *SHAPE), PictureLayout.of(SOURCES[0]), VIDEO, False, form)
        assert max(len(each.stored) for each in plan.passes) == MAX_STORED_VALUES
    assert faults(fused, chosen, SOURCES[0], "twelve saved pictures") == []
