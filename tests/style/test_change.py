"""Overrides of style values, expansion of recipes, and data derived from the declarations of blocks."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Annotated, Any

import jsonschema
import pytest
from covering import in_one_test
from PIL import ImageColor

from vidstyle.block import Block, Choice, Slider, block
from vidstyle.block.color_names import COLOR_NAMES
from vidstyle.blocks import all_blocks
from vidstyle.blocks.posterize import posterize
from vidstyle.errors import UsageError
from vidstyle.style import (
    Step,
    Style,
    describe,
    expand,
    load_style,
    override,
    set_values,
    style_names,
    style_schema,
    table_from_style,
)

FIXTURES = sorted((Path(__file__).parents[1] / "fixtures" / "styles").glob("*.toml"))
RECIPES = sorted(name for name, each in all_blocks().items() if each.kind == "recipe")

TWICE = Style(
    "twice",
    base=(Step("posterize"), Step("", save="kept"), Step("posterize")),
    lines=(Step("posterize"), Step("blend")),
)


@pytest.mark.parametrize(
    ("assignment", "layer", "number", "values"),
    [
        ("blend.opacity=0.25", "lines", 1, {"opacity": 0.25}),
        ("lines.blend.opacity = 1", "lines", 1, {"opacity": 1.0}),
        ("blend.mode=multiply", "lines", 1, {"mode": "multiply"}),
        ('blend.mode="multiply"', "lines", 1, {"mode": "multiply"}),
        ("blend.other=kept", "lines", 1, {"other": "kept"}),
        ("posterize#2.levels=5", "base", 2, {"levels": 5}),
        ("posterize#3.levels=5", "lines", 0, {"levels": 5}),
        ("base.posterize#2.levels=5", "base", 2, {"levels": 5}),
        ("lines.posterize.levels=5", "lines", 0, {"levels": 5}),
    ],
)
def test_a_value_is_set_on_the_step_that_is_meant(
    assignment: str, layer: str, number: int, values: dict[str, Any]
) -> None:
    changed = override(TWICE, [assignment])
    assert getattr(changed, layer)[number].values == values
    assert sum(bool(step.values) for step in changed.steps) == 1


def test_fields_are_set_too() -> None:
    changed = override(Style("plain"), ["ink=#FF0000", 'paper = "#00ff00"', "height=720"])
    assert changed == Style("plain", ink="#ff0000", paper="#00ff00", height=720, keeps_detail=True)
    assert override(TWICE, []) == TWICE


def test_colours_have_the_names_and_short_forms_of_css() -> None:
    assert override(Style("plain"), ["ink=Navy", "paper=#fe0"]) == Style(
        "plain", ink="#000080", paper="#ffee00"
    )
    assert COLOR_NAMES == ImageColor.colormap


@in_one_test(
    "assignment, mistake",
    [
        ("posterize", "'posterize' is not written as step.parameter=value"),
        ("posterize.levels=5", "may be base.posterize#1 or base.posterize#2 or lines.posterize"),
        ("base.posterize.levels=5", "may be base.posterize#1 or base.posterize#2"),
        ("posterize#4.levels=5", "there is no step 'posterize#4'; did you mean"),
        ("posterize#0.levels=5", "there is no step 'posterize#0'"),
        ("blnd.opacity=1", "there is no step 'blnd'; did you mean 'blend'?"),
        ("../x.opacity=1", "there is no step '../x'"),
        ("blend.opacty=1", "blend has no parameter 'opacty'; did you mean 'opacity'?"),
        ("blend.save=x", "blend has no parameter 'save'"),
        ("blend.opacity=2", "lines step 2 (blend): opacity: 2 is outside 0 to 1"),
        ("blend.opacity=nan", "opacity: nan is not a number"),
        ("blend.opacity=", "opacity: '' is not a number"),
        ("blend.opacity=1\nmode='add'", "is not a number"),
        ("blend.opacity=" + "[" * 9999, "is too long"),
        ("blend.mode=2", "mode: '2' is not one of normal"),
        ("blend.other=lost", "other: no step before it saves 'lost'"),
        ("inc=#ff0000", "'inc' is not a field of a style; did you mean 'ink'?"),
        ("ink=rde", "ink: 'rde' is not a colour"),
        ("name=x", "'name' is not a field"),
    ],
)
def test_a_wrong_assignment_is_named(assignment: str, mistake: str) -> None:
    with pytest.raises(UsageError) as caught:
        override(TWICE, [assignment])
    assert mistake.replace("\n", "\\n") in str(caught.value)


def test_all_wrong_assignments_are_named_at_once() -> None:
    with pytest.raises(UsageError) as caught:
        override(TWICE, ["blend.opacity=2", "posterize.levels=5", "ink=rde"])
    for mistake in ("opacity: 2 is outside", "'posterize' may be", "ink: 'rde'"):
        assert mistake in str(caught.value)


@pytest.mark.parametrize("name", RECIPES)
def test_every_recipe_becomes_valid_steps_at_defaults_and_at_the_ends(name: str) -> None:
    sliders = {
        key: each for key, each in all_blocks()[name].parameters.items() if isinstance(each.control, Slider)
    }
    lowest = {key: each.check(each.control.low) for key, each in sliders.items()}
    highest = {key: each.check(each.control.high) for key, each in sliders.items()}
    for values in ({}, lowest, highest):
        made = expand(Style("made", base=(Step("", save="chroma"), Step(name, values))))
        assert all(all_blocks()[step.block].kind != "recipe" for step in made.base if step.block)
        assert load_style(table_from_style(made)).base[1].block == made.base[1].block


@block("recipe", on="luma")
def inner(levels: Annotated[int, Slider(2, 32, "tones")] = 4) -> list[tuple[Block, dict[str, Any]]]:
    """Posterize twice."""
    return [(posterize, {"levels": levels}), (posterize, {"levels": 2})]


@block("recipe", on="color")
def outer(
    mode: Annotated[str, Choice(("all", "none"), "which")] = "all",
) -> list[tuple[Block, dict[str, Any]]]:
    """Stand for a recipe of recipes."""
    return [(posterize, {}), (inner, {"levels": 7})] if mode == "all" else []


@pytest.fixture
def with_recipes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(all_blocks(), "inner", inner)
    monkeypatch.setitem(all_blocks(), "outer", outer)


@pytest.mark.usefixtures("with_recipes")
def test_recipes_are_written_out() -> None:
    style = Style(
        "nested", lines=(Step("", save="a"), Step("outer", save="b", source="a"), Step("posterize"))
    )
    assert expand(style).lines == (
        Step("", save="a"),
        Step("posterize", source="a"),
        Step("posterize", {"levels": 7}, on="luma"),
        Step("posterize", {"levels": 2}, save="b", on="luma"),
        Step("posterize"),
    )
    nothing = Style("empty", base=(Step("outer", {"mode": "none"}, save="b", source="source"),))
    assert expand(nothing).base == (Step("", save="b", source="source"),)


@cache
def validator() -> jsonschema.Draft202012Validator:
    schema = json.loads(json.dumps(style_schema()))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def test_the_schema_takes_every_style_there_is() -> None:
    schema = validator()
    for style in (*style_names(), *FIXTURES, TWICE):
        schema.validate(table_from_style(load_style(style)))
    every = [
        {"block": name} | {key: each.default for key, each in item.parameters.items()}
        for name, item in all_blocks().items()
    ]
    schema.validate({"format": 1, "base": every})


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"format": 2},
        {"format": 1, "colour": "red"},
        {"format": 1, "ink": "#12"},
        {"format": 1, "base": [{}]},
        {"format": 1, "base": [{"levels": 5}]},
        {"format": 1, "base": [{"block": "posterise"}]},
        {"format": 1, "base": [{"block": "posterize", "levels": 99}]},
        {"format": 1, "base": [{"block": "posterize", "opacity": 1}]},
        {"format": 1, "base": [{"block": "blend", "mode": "mix"}]},
        {"format": 1, "base": [{"block": "posterize", "save": "a b"}]},
    ],
)
def test_the_schema_refuses_what_cannot_be_read(table: dict[str, Any]) -> None:
    assert not validator().is_valid(table)


def test_a_style_is_described_with_all_values() -> None:
    described = json.loads(json.dumps(describe(override(TWICE, ["blend.opacity=0.25"]))))
    blend = described["lines"][1]
    assert blend["parameters"]["opacity"]["value"] == 0.25
    assert blend["parameters"]["opacity"]["default"] == all_blocks()["blend"].parameters["opacity"].default
    assert set(blend["parameters"]) == set(all_blocks()["blend"].parameters)
    kept = {"block": "", "help": "", "from": "", "save": "kept", "mute": False, "parameters": {}}
    assert described["base"][1] == kept


def test_typed_values_need_no_text() -> None:
    style = Style("s", background=(Step("etf"), Step("posterize")))
    changed = set_values(style, {"etf.reselect": True, "posterize.levels": 5, "ink": "#FF0000"})
    assert changed == override(style, ["etf.reselect=true", "posterize.levels=5", "ink=#ff0000"])


def test_a_typed_value_is_not_parsed() -> None:
    with pytest.raises(UsageError) as caught:
        set_values(Style("s", background=(Step("posterize"),)), {"posterize.levels": "5", "inks": 1})
    assert "'inks' is not a field of a style" in caught.value.reason
    assert "levels: '5' is not a whole number" in caught.value.reason
