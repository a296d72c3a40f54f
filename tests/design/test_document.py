"""The document of the designer: random edits against a plain model of a style, undo, snapshots."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from design_model import SIZE, Fields, Random, run

from vidstyle.blocks import all_blocks
from vidstyle.design.document.document import Document
from vidstyle.design.document.state import state_of
from vidstyle.design.document.step_text import text_of_step
from vidstyle.errors import StyleError, UsageError
from vidstyle.gpu.compile.es import es_plan
from vidstyle.style import Step, Style, load_style, save_style, style_file, style_from_table, style_names
from vidstyle.style.files import read_style_text


@pytest.mark.parametrize("start", ["plain", "sketch"])
def test_random_edits_agree_with_a_plain_model(start: str, tmp_path: Path) -> None:
    assert run(start, 100, Random(random.randrange(2**32)), tmp_path / "style.toml") > 9


@pytest.mark.thorough
def test_a_thousand_random_edits_agree_with_a_plain_model(tmp_path: Path) -> None:
    choose = Random(random.randrange(2**32))
    for number, start in enumerate(["plain", "comic", "impressionist", "sketch"]):
        assert run(start, 250, choose, tmp_path / f"{number}.toml") > 50


@pytest.mark.parametrize("name", sorted(set(style_names()) - {"plain"}))
def test_a_shipped_style_opened_and_saved_keeps_its_bytes(name: str, tmp_path: Path) -> None:
    document = Document(load_style(name))
    assert document.mistakes == [] and not document.is_changed
    shipped = style_file(name)
    assert shipped is not None
    save_style(document.style, tmp_path / "copy.toml", read_style_text(shipped))
    assert (tmp_path / "copy.toml").read_bytes() == shipped.read_bytes()


def test_edits_of_one_gesture_are_undone_together() -> None:
    document = Document(Style("new"))
    step = document.edit("add", 1, layer="lines", index=0, block="flow_xdog")
    for value in (2, 3, 4):
        document.edit("set", 2, step=step, name="sigma", value=value)
    document.edit("set", 3, step=step, name="p", value=9)
    document.undo()
    document.undo()
    assert document.content.table()["lines"] == [{"block": "flow_xdog"}]
    document.redo()
    # Undo has ended the gesture, so the number of the next one does not matter.
    document.edit("set", 2, step=step, name="sigma", value=5)
    document.undo()
    assert document.content.table()["lines"] == [{"block": "flow_xdog", "sigma": 4.0}]
    assert document.history.redo_label == "Line width: 5"


def test_the_history_is_jumped_through_and_has_an_end() -> None:
    document = Document(Style("new"))
    for number in range(250):
        document.edit("field", number, name="steady", value=number / 250)
    entries = document.history.entries
    assert len(entries) == 200
    document.jump(entries[10].number)
    assert document.content.fields["steady"] == entries[10].state.fields["steady"]
    with pytest.raises(UsageError, match="is no longer in the history"):
        document.jump(3)


def test_a_snapshot_comes_back_and_that_can_be_undone() -> None:
    document = Document(load_style("sketch"))
    before = document.content
    document.snapshot("a")
    document.edit("field", 1, name="ink", value="red")
    document.restore("a")
    assert document.content == before
    document.undo()
    assert document.content.fields["ink"] == "#ff0000"
    with pytest.raises(UsageError, match="has not been taken"):
        document.restore("b")


def test_a_knob_and_a_variant_follow_their_step() -> None:
    table = {
        "format": 1,
        "knobs": ["posterize.levels", "ink"],
        "lines": [{"block": "posterize"}],
        "variants": {"flat": {"posterize.levels": 3, "ink": "#ff0000"}},
    }
    document = Document(style_from_table(table, "style"))
    [(_, _, only)] = document.content.steps
    document.edit("knob", 0, step=only.number, name="levels", on=False)
    assert document.content.table()["knobs"] == ["ink"]
    document.undo()
    document.edit("add", 1, layer="base", index=0, block="posterize")
    assert document.content.table()["knobs"] == ["lines.posterize.levels", "ink"]
    document.edit("variant", 2, name="flat")
    assert document.content.table()["lines"] == [{"block": "posterize", "levels": 3}]
    assert document.content.fields["ink"] == "#ff0000"
    assert state_of(document)["variant"] == "flat"
    [(_, _, base), (_, _, lines)] = document.content.steps
    document.edit("remove", 3, step=base.number)
    assert document.content.table()["knobs"] == ["posterize.levels", "ink"]
    document.edit("remove", 4, step=lines.number)
    assert document.content.table()["knobs"] == ["ink"]
    assert document.content.table()["variants"] == {"flat": {"ink": "#ff0000"}}


def test_a_variant_replaces_the_one_before_it_and_keeps_other_values() -> None:
    document = Document(load_style("ascii"))
    names = [each["name"] for each in state_of(document)["variants"]]
    assert names[0] == "" and state_of(document)["variant"] == ""
    document.edit("variant", 1, name="amber")
    assert state_of(document)["variant"] == "amber" and document.style.paper == "#ffb13b"
    document.edit("field", 2, name="strength", value=0.5)
    document.edit("variant", 3, name="white")
    assert document.style.paper == "#ffffff", "amber's paper is left"
    assert state_of(document)["variant"] == "white"
    document.edit("field", 4, name="paper", value="#123456")
    document.edit("variant", 5, name="")
    assert (document.style.paper, document.style.strength) == ("#ffffff", 0.5)
    assert state_of(document)["variant"] == ""
    document.edit("field", 6, name="paper", value="#123456")
    assert state_of(document)["variant"] is None


def test_steps_are_copied_from_one_style_and_pasted_into_another() -> None:
    ink, poster = Document(load_style("ink")), Document(Style("s", lines=(Step("posterize", {"levels": 5}),)))
    lines = ink.content.layers["lines"]
    count = len(poster.content.layers["lines"])
    text = text_of_step(ink.content, lines[0].number, whole=True)
    assert text.startswith("[[lines]]") and text.count("[[lines]]") == len(lines)
    first = poster.edit("paste", layer="lines", index=0, text=text)
    pasted = poster.content.layers["lines"]
    assert first == pasted[0].number and len(pasted) == count + len(lines)
    assert [step.table for step in pasted[: len(lines)]] == [step.table for step in lines]
    assert poster.history.entries[-1].label == f"Paste {len(lines)} steps"
    assert "no step before it saves" in poster.mistakes[0].text  # what a step of ink's base has saved
    poster.undo()
    assert poster.mistakes == [] and not poster.is_changed


def test_a_pasted_step_does_not_save_under_a_name_that_is_taken() -> None:
    document = Document(Style("s", background=(Step("posterize", {"levels": 5}, save="flat"),)))
    step = document.content.layers["background"][0]
    document.edit("paste", layer="lines", index=0, text=text_of_step(document.content, step.number, False))
    assert document.content.layers["lines"][0].table == {"block": "posterize", "levels": 5}
    assert document.mistakes == []


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("anything", "holds no steps of a style"),
        ('lines = ["x", 5]', "holds no steps of a style"),
        ("[[lines]]\nblock = 'posterise'", "did you mean 'posterize'?"),
        ("[[lines]]\nblock = 'posterize'\nlevels = 99", "is outside 2 to 32"),
        ("[[lines]]\nblock = 'pattern'\ntiles = '../../etc'", "the clipboard holds a mistake"),
        ("[[lines]]\nblock = 'hue'\n" * 300, "at most 256 steps"),
    ],
)
def test_other_texts_cannot_be_pasted(text: str, told: str) -> None:
    document = Document(load_style("ink"))
    before = document.content
    with pytest.raises(UsageError) as caught:
        document.edit("paste", layer="lines", index=0, text=text)
    assert told in str(caught.value) and document.content == before


def test_a_mistake_stands_at_its_step_and_the_last_good_style_is_shown() -> None:
    document = Document(load_style("comic"))
    good = document.style
    saving = next(step.number for _, _, step in document.content.steps if step.table.get("save"))
    document.edit("refer", 1, step=saving, name="save", value="")
    assert document.style == good and document.mistakes
    state = state_of(document)
    told = [node["error"] for nodes in state["layers"].values() for node in nodes if node["error"]]
    assert told and "no step before it saves" in told[0] and state["errors"] == []
    with pytest.raises(StyleError):
        document.valid_style()
    document.undo()
    assert document.mistakes == []


def test_a_saved_picture_is_renamed_where_it_is_used() -> None:
    document = Document(load_style("comic"))
    step = next(step for _, _, step in document.content.steps if step.table.get("save"))
    document.edit("refer", 1, step=step.number, name="save", value="renamed")
    assert document.mistakes == []


@pytest.mark.parametrize(
    "before",
    [
        Style("lines", lines=(Step("flow_xdog", {"phi": 0.02}),)),
        Style("tones", background=(Step("gaussian"), Step("luma_posterize", {"levels": 5}))),
    ],
    ids=lambda style: style.name,
)
def test_a_recipe_opens_into_steps_that_make_the_same_picture(before: Style) -> None:
    document = Document(before)
    before = document.style
    recipe = next(
        step.number
        for _, _, step in document.content.steps
        if "block" in step.table and all_blocks()[str(step.table["block"])].kind == "recipe"
    )
    document.edit("expand", 1, step=recipe)
    assert document.mistakes == [] and document.style.steps != before.steps
    plans = [es_plan(style, *SIZE) for style in (before, document.style)]
    assert plans[0]["values"] == plans[1]["values"] and plans[0]["shaders"] == plans[1]["shaders"]
    with pytest.raises(UsageError, match="is not a recipe"):
        document.edit("expand", 2, step=next(iter(document.content.steps))[2].number)


@pytest.mark.parametrize(
    ("kind", "fields", "told"),
    [
        ("set", {"step": 1, "name": "sigma", "value": 99.0}, "sigma: 99 is outside"),
        ("set", {"step": 1, "name": "sigmas", "value": 1.0}, "did you mean 'sigma'"),
        ("set", {"step": 9, "name": "sigma", "value": 1.0}, "no longer exists"),
        ("add", {"layer": "lines", "index": 9, "block": "hue"}, "is not in the layer"),
        ("add", {"layer": "line", "index": 0, "block": "hue"}, "is not a layer"),
        ("add", {"layer": "lines", "index": 0, "block": "hues"}, "did you mean 'hue'"),
        ("refer", {"step": 1, "name": "save", "value": "a b"}, "is not a name"),
        ("refer", {"step": 1, "name": "sigma", "value": "kept"}, "is not a picture or a file"),
        ("variant", {"name": "red"}, "is not a variant"),
        ("knob", {"step": None, "name": "inks", "on": True}, "did you mean 'ink'"),
        ("field", {"name": "strength", "value": 2}, "strength: 2 is outside 0 to 1"),
        ("rename", {"name": "\x07"}, "is not a text"),
    ],
)
def test_an_edit_with_wrong_values_is_refused_in_a_sentence(kind: str, fields: Fields, told: str) -> None:
    document = Document(Style("new"))
    document.edit("add", 1, layer="lines", index=0, block="flow_xdog")
    before = document.content
    with pytest.raises(UsageError) as caught:
        document.edit(kind, 2, **fields)
    assert told in str(caught.value) and document.content is before


def test_an_edit_of_a_field_keeps_the_kinds_and_the_style_behind_people() -> None:
    """They are no values that the page shows."""
    behind = {"background": [{"block": "gaussian"}]}
    table = {"format": 1, "name": "old", "kinds": ["drawn"], "base": [{"block": "invert"}], "behind": behind}
    document = Document(load_style(table))
    document.edit("rename", 1, name="new")
    document.edit("field", 2, name="steady", value=0.25)
    kept = document.content.fields
    assert (kept["name"], kept["steady"], kept["kinds"], kept["behind"]) == ("new", 0.25, ["drawn"], behind)


def test_a_new_name_is_no_edit_and_keeps_what_can_be_redone() -> None:
    document = Document(load_style({"format": 1, "name": "old", "base": [{"block": "invert"}]}))
    document.edit("field", 1, name="steady", value=0.25)
    document.undo()
    document.rename("new")
    assert document.content.fields["name"] == "new" and "steady" not in document.content.fields
    document.redo()
    assert (document.content.fields["name"], document.content.fields["steady"]) == ("new", 0.25)
    document.undo()
    document.undo()
    assert document.content.fields["name"] == "new"


def test_the_picture_is_put_behind_lines_unchanged() -> None:
    table = {"format": 1, "name": "n", "base": [{"block": "posterize"}], "lines": [{"block": "flow_xdog"}]}
    document = Document(load_style(table))
    document.edit("show_behind_lines", 1)
    assert [step.table for step in document.content.layers["background"]] == [{"save": "picture"}]
