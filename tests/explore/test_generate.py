"""Random styles: valid, repeatable, by the paper's rules; variations keep what is locked."""

from __future__ import annotations

import math
from collections import Counter
from functools import cache
from itertools import chain
from pathlib import Path

import pytest

from vidstyle.explore.colors import MIN_CONTRAST, contrast, is_pale
from vidstyle.explore.composed.kept_parts import colors_origin, kept_shares, part_weight, parts_favor
from vidstyle.explore.composed.open_style import MAX_GROWTH_RATIO
from vidstyle.explore.composed.shipped_parts import families, shipped_styles
from vidstyle.explore.generate import alter, cross, mutate, random_style
from vidstyle.explore.paper.light import evened, lit, moderated
from vidstyle.explore.paper.paper_style import SMOOTHED
from vidstyle.explore.paper.rules import FILTER_COUNT_RANGE, FILTER_RULES, GRAY_SHARE, Rules
from vidstyle.explore.random_steps import is_valid
from vidstyle.style import LAYERS, Step, Style, load_style, style_text, table_from_style

PAPER_ENDS = {
    ("flow_dog", "sigma"): (0.5, 2),
    ("soft_threshold", "phi"): (0.013, 0.059),
    ("soft_threshold", "epsilon"): (50, 110),
    ("detail", "delta"): (-100, 60),
    ("luma_posterize", "levels"): (5, 12),
    ("saturation", "factor"): (1.5, 2.2),
    ("scale", "factor"): ((100 / 300) ** 0.5, 1),
}
"""Section 6.2, in our units: sigma is read as twice a variance, size as pixels of which 300 are all."""


@cache
def open_styles() -> list[Style]:
    return [random_style(seed) for seed in range(150)]


@cache
def paper_styles() -> list[Style]:
    return [random_style(seed, "paper") for seed in range(600)]


def blocks_of(style: Style) -> list[str]:
    return [step.block for step in style.steps]


def drawn_steps(style: Style) -> list[Step]:
    """The filters of a style by the paper's rules, without steps for its full size, light and colours."""
    saturation = [step for step in style.background if step.block == "saturation"]
    colors = style.background[len(moderated(saturation[0], SMOOTHED)) if saturation else 0 :]
    lines = [step for step in style.lines if step.block in ("flow_dog", "soft_threshold")]
    steps = [*style.base[LIT_COUNT:], *saturation, *colors, *lines]
    return [step for step in steps if step.block != "scale" or "method" not in step.values]


LIT_COUNT, EVENED_COUNT = len(lit()), len(evened())
"""Steps before the filters of the paper, and before those of lines."""
CRITICAL = {1: 10.83, 4: 18.47, 5: 20.52, 6: 22.46, 7: 24.32}
"""What chi-square exceeds by chance once in a thousand, by degrees of freedom."""


def check_valid(rules: Rules, seeds: range) -> None:
    for seed in seeds:
        style = random_style(seed, rules)
        assert is_valid(style), seed


@pytest.mark.parametrize("rules", ["open", "paper"])
def test_random_styles_are_valid(rules: Rules) -> None:
    check_valid(rules, range(15))


@pytest.mark.thorough
@pytest.mark.parametrize("rules", ["open", "paper"])
def test_two_thousand_random_styles_are_valid(rules: Rules) -> None:
    check_valid(rules, range(2000))


def test_same_seed_same_bytes() -> None:
    assert style_text(random_style(7)) == style_text(random_style("7"))
    assert style_text(random_style(7)) != style_text(random_style(8))


def chi_square(counts: list[int], shares: list[float]) -> float:
    total = sum(counts)
    return sum((n - total * share) ** 2 / (total * share) for n, share in zip(counts, shares, strict=True))


def test_paper_rules_keep_to_what_the_paper_says() -> None:
    styles = paper_styles()
    repeats = {rule.block for rule in FILTER_RULES if rule.repeats}
    assert repeats == {"flow_dog", "tvf"}
    for style in styles:
        assert FILTER_COUNT_RANGE[0] <= len(drawn_steps(style)) <= FILTER_COUNT_RANGE[1]
        twice = {block for block, n in Counter(step.block for step in drawn_steps(style)).items() if n > 1}
        assert twice <= repeats
    lengths = Counter(len(drawn_steps(style)) for style in styles)
    assert chi_square([lengths[n] for n in range(4, 10)], [1 / 6] * 6) < CRITICAL[5]
    gray = sum("to_gray" in [step.block for step in drawn_steps(style)] for style in styles)
    assert GRAY_SHARE == 0.2 and chi_square([gray, 600 - gray], [0.2, 0.8]) < CRITICAL[1]
    assert {step.block for style in styles for step in drawn_steps(style)} == {
        "to_gray", *(rule.block for rule in FILTER_RULES)
    }  # fmt: skip


def test_paper_styles_have_lines_over_flat_tones_of_a_smooth_picture() -> None:
    """Lines are no halos and draw no noise, flat tones are not outlined, and nothing whitens the colours."""
    drawings = 0
    for style in paper_styles():
        base, colors, lines = ([step.block for step in style.layers[layer]] for layer in LAYERS)
        assert set(base[LIT_COUNT:]) <= {"detail", "tvf", "to_gray"} and base[-1] in ("tvf", "to_gray")
        drawings += not colors
        if colors:
            assert "luma_posterize" in colors and lines[:EVENED_COUNT] == [step.block for step in evened()]
        else:
            assert len(drawn_steps(style)) == 4 and base[-1] == "to_gray"
        assert set(lines[EVENED_COUNT * bool(colors) : -1 - bool(colors)]) == {"flow_dog"}
        assert lines[-1] == "soft_threshold"
        strengths = [step.values["p"] for step in style.lines if step.block == "flow_dog"]
        assert all(1 <= p <= 40 for p in strengths) and math.prod(1 + p for p in strengths if p > 1) < 43
        times = [step.values["time"] for step in style.base[LIT_COUNT:] if step.block == "tvf"]
        assert sum(times) == pytest.approx(8)
    assert drawings


def test_paper_values_are_even_between_the_ends_of_the_paper() -> None:
    for (block, name), (low, high) in PAPER_ENDS.items():
        values = [
            step.values[name]
            for style in paper_styles()
            for step in drawn_steps(style)
            if step.block == block
        ]
        assert low - 0.002 <= min(values) and max(values) <= high + 0.002
        bins = 8 if name == "levels" else 5
        width = (high - low + (name == "levels")) / bins
        counts = Counter(min(int((value - low) / width), bins - 1) for value in values)
        assert chi_square([counts[n] for n in range(bins)], [1 / bins] * bins) < CRITICAL[bins - 1], name


def test_paper_styles_end_at_the_size_of_the_picture() -> None:
    """Their flat tones are made there, so that edges are sharp."""
    backgrounds = [style.background for style in paper_styles()[:200]]
    sized = [steps for steps in backgrounds if any(step.block == "scale" for step in steps)]
    assert len(sized) > 50
    for steps in sized:
        blocks = [step.block for step in steps]
        small, full = (place for place, block in enumerate(blocks) if block == "scale")
        assert steps[small].values["factor"] * steps[full].values["factor"] == pytest.approx(1, abs=0.01)
        assert "luma_posterize" not in blocks or blocks.index("luma_posterize") == full + 1


def test_ink_is_readable_on_paper() -> None:
    # As in `crayon`, an ink as pale as the paper covers what is left of it between marks.
    drawn = [style for style in open_styles()[:30] if not (is_pale(style.ink) and is_pale(style.paper))]
    assert len(drawn) > 15 and all(contrast(style.ink, style.paper) >= MIN_CONTRAST for style in drawn)


def test_open_styles_combine_whole_layers_of_many_styles() -> None:
    shipped = [(layer, blocks) for style in shipped_styles() for layer in ("background", "lines")
               if (blocks := layer_blocks(style, layer))]  # fmt: skip
    pairs = set()
    for style in open_styles():
        used = {
            layer: max((len(blocks), number) for number, (of, blocks) in enumerate(shipped)
                       if of == layer and contains(layer_blocks(style, layer), blocks))[1]
            for layer in ("background", "lines") if style.layers[layer]
        }  # fmt: skip
        pairs.add(tuple(used.values()))
    assert len(pairs) > 2 * len(shipped_styles())


def test_parts_that_people_kept_are_drawn_more_often_but_all_are_drawn() -> None:
    styles = *open_styles(), *(random_style(f"more {seed}") for seed in range(450))
    drawn = Counter(colors_origin(style) for style in styles)
    names = {style.name for style in shipped_styles()}
    kept = {name for name, share in kept_shares()["colors"].items() if share > 0.45} - {"mean"}
    assert kept <= drawn.keys() <= names and part_weight("colors", "pixel") > 0
    assert kept_shares()["colors"].keys() | kept_shares()["lines"].keys() <= {*names, "mean"}
    assert min(drawn[name] for name in ("engraving", "impressionist", "sketch")) > 4 * drawn["poster"]


def test_the_origin_of_colours_speaks_for_or_against_a_style(tmp_path: Path) -> None:
    engraving, poster = load_style("engraving"), load_style("poster:pink")
    assert parts_favor(engraving) > 0.5 > -0.5 > parts_favor(poster)
    assert parts_favor(mutate(poster, 1)) == parts_favor(poster)
    for crossed in (cross(engraving, poster, 3), cross(poster, engraving, 3)):
        assert crossed.note.endswith(("lines of poster:pink, seed 3.", "background of engraving, seed 3."))
        assert colors_origin(crossed) == "engraving"
    saved = tmp_path / "saved.toml"
    saved.write_text(style_text(mutate(random_style(3), 1)), encoding="utf-8")
    assert (
        colors_origin(load_style(saved))
        == colors_origin(random_style(3))
        in {style.name for style in shipped_styles()}
    )
    assert parts_favor(random_style(3, "paper")) == 0
    for style in shipped_styles():
        assert parts_favor(mutate(style, 1)) == parts_favor(style)


def test_open_styles_lighten_colours_below_lines_that_draw_tones() -> None:
    """Hatching over another style's dark colours would hide the subject."""
    hatched = [style for style in open_styles() if style.background
               and any(step.block == "line_screen" for step in style.lines)]  # fmt: skip
    own = [style for style in hatched if "colorize" in layer_blocks(style, "background")]
    lightened = [style for style in hatched if any(step.save == "dark" for step in style.background)]
    assert len(lightened) > 10 and {style.name for style in hatched} <= {
        style.name for style in own + lightened
    }


def test_random_values_are_near_those_of_shipped_styles() -> None:
    """Marks larger than in any shipped style would hide faces."""
    values: dict[str, list[float]] = {"halftone.cell": [], "glyphs.cell": [], "mosaic.size": []}
    largest = dict.fromkeys(values, 0.0)
    for found, styles in ((values, open_styles()), (None, chain(*families()))):
        for step in (step for style in styles for step in style.steps):
            for path in values:
                block, name = path.split(".")
                if step.block == block and found is not None:
                    found[path].append(step.values[name])
                elif step.block == block:
                    largest[path] = max(largest[path], step.values[name])
    for path, drawn in values.items():
        assert drawn and max(drawn) <= MAX_GROWTH_RATIO * largest[path], path


def layer_blocks(style: Style, layer: str) -> list[str]:
    return [step.block for step in style.layers[layer] if step.block]


def contains(blocks: list[str], wanted: list[str]) -> bool:
    """Whether the blocks include a layer, whose last gradient may be replaced."""
    wanted = wanted[:-1] if wanted[-1] == "gradient" else wanted
    return any(blocks[place : place + len(wanted)] == wanted for place in range(len(blocks)))


@pytest.mark.parametrize("style", shipped_styles()[2::6] + [random_style(5)], ids=lambda style: style.name)
def test_variations_are_valid_and_keep_what_is_locked(style: Style) -> None:
    other = random_style(11)

    def changes(seed: int, *locks: str) -> list[Style]:
        return [mutate(style, seed, 0.8, locks), alter(style, seed, locks), cross(style, other, seed, locks)]

    for seed in range(4):
        for free in changes(seed):
            assert is_valid(free) and free != style
        assert changes(seed) == changes(seed)
        assert all(each.lines == style.lines for each in changes(seed, "lines"))
        for kept in changes(seed, "background", "colors"):
            assert (kept.base, kept.background) == (style.base, style.background)
            assert (kept.ink, kept.paper) == (style.ink, style.paper)
        assert all(blocks_of(each) == blocks_of(style) for each in changes(seed, "steps"))


def test_distance_says_how_far() -> None:
    style = load_style("comic")
    assert table_from_style(mutate(style, 1, 0.0))["background"] == table_from_style(style)["background"]

    def moved(distance: float) -> float:
        changed = [mutate(style, seed, distance).steps for seed in range(6)]
        pairs = [pair for steps in changed for pair in zip(steps, style.steps, strict=True)]
        numbers = [(new.values.get(name, old), old) for new, step in pairs for name, old in
                   step.values.items() if isinstance(old, float)]  # fmt: skip
        return sum(abs(new - old) / (old or 1) for new, old in numbers)

    assert 0 < moved(0.1) < moved(0.8)


def test_variations_keep_the_middle_tone() -> None:
    """An even number of tones would have an edge in the middle, where noise becomes visible."""
    style = {"format": 1, "background": [{"block": "posterize", "levels": 7}]}
    for distance in (0.1, 1.0):
        varied = [mutate(load_style(style), seed, distance).background[0] for seed in range(100)]
        levels = Counter(step.values["levels"] for step in varied)
        assert len(levels) > 2 and all(each % 2 and 3 <= each <= 31 for each in levels), levels


def test_note_says_rules_seed_and_parents() -> None:
    parent = shipped_styles()[0]
    style = cross(random_style("7-3"), parent, 5)
    for part in ("open rules, seed 7-3", f"of {parent.name}, seed 5"):
        assert part in style.note
