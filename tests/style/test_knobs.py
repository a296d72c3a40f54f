"""Knobs, muted steps and strength: in files, on the CPU and on a GPU."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from covering import drawn
from gpu import FORMS, SMALL, Sessions, faults, film_picture
from pictures import noise, run_color, step, style

from vidstyle.assets import asset_folder
from vidstyle.core.picture import Picture
from vidstyle.cpu.step_pictures import step_pictures
from vidstyle.design.document.solo import solo
from vidstyle.errors import StyleError, UsageError
from vidstyle.renderer import stylize
from vidstyle.style import (
    Style,
    load_style,
    override,
    save_style,
    style_from_table,
    style_names,
    style_schema,
    table_from_style,
)
from vidstyle.style.knobs import knobs_of
from vidstyle.style.panel import panel

COLORS = noise(24, 30, 3)
MUTED = {"block": "posterize", "mute": True}

sessions = Sessions.fixture()


def made(**table: Any) -> Style:
    return style_from_table({"format": 1, **table}, "style")


def test_knobs_and_mute_are_in_files_and_in_their_schema(tmp_path: Path) -> None:
    table = {"format": 1, "name": "s", "knobs": ["posterize.levels", "ink"], "lines": [MUTED]}
    jsonschema.validate(table, style_schema())
    save_style(load_style(table), tmp_path / "s.toml")
    text = (tmp_path / "s.toml").read_text()
    assert 'knobs = ["posterize.levels", "ink"]' in text and "mute = true" in text
    assert table_from_style(load_style(tmp_path / "s.toml")) == table
    entries = panel(load_style(table), load_style(table))["entries"]
    main = [entry["path"] for entry in entries if entry["main"]]
    assert main == ["ink", "paper", "steady", "strength", "focus", "posterize.levels"]


@pytest.mark.parametrize(
    ("knobs", "told"),
    [
        ("ink", "knobs is not a list of paths"),
        ([1], "knobs is not a list of paths"),
        (["posterise.levels"], "knobs: there is no step 'posterise'; did you mean 'posterize'"),
        (["posterize.level"], "did you mean 'levels'"),
        (["ink", "ink"], "knobs: 'ink' is there twice"),
        (["ink"] * 17, "at most 16 knobs"),
    ],
)
def test_a_knob_names_a_value_once(knobs: object, told: str) -> None:
    with pytest.raises(StyleError) as caught:
        made(knobs=knobs, lines=[{"block": "posterize"}])
    assert told in str(caught.value)


def test_labels_say_what_values_do_in_this_style(tmp_path: Path) -> None:
    labels = {"lines.posterize#1.levels": "Shades", "lines.posterize#2.softness": "Mist", "ink": "Pen"}
    knobs = ["posterize#1.levels", "posterize#2.levels"]
    table = {
        "format": 1,
        "name": "s",
        "knobs": knobs,
        "labels": labels,
        "lines": [{"block": "posterize"}] * 2,
    }
    jsonschema.validate(table, style_schema())
    save_style(load_style(table), tmp_path / "s.toml")
    style = load_style(tmp_path / "s.toml")
    assert table_from_style(style) == table
    shown = {entry["path"]: entry["label"] for entry in panel(style, style)["entries"]}
    assert shown["ink"] == "Pen" and shown["paper"] == "Paper colour"
    assert shown["lines.posterize#1.levels"] == "Shades" and shown["lines.posterize#2.softness"] == "Mist"
    assert shown["lines.posterize#2.levels"] == "Number of tones"


def test_a_label_may_go_on_with_its_own_help() -> None:
    labels = {"posterize.levels": "Shades: fewer of them look flatter", "posterize.softness": "Mist"}
    style = made(labels=labels, lines=[{"block": "posterize"}])
    entries = {entry["path"]: entry for entry in panel(style, style)["entries"]}
    shades, mist = entries["posterize.levels"], entries["posterize.softness"]
    assert (shades["label"], shades["help"]) == ("Shades", "fewer of them look flatter")
    assert (mist["label"], mist["help"]) == ("Mist", "share of each step that is a ramp; reduces flicker")
    with pytest.raises(StyleError, match="at most 120 of help after a colon"):
        made(labels={"posterize.levels": "Shades: " + 121 * "x"}, lines=[{"block": "posterize"}])


@pytest.mark.parametrize("name", style_names())
def test_the_help_of_a_labelled_knob_is_not_that_of_its_block(name: str) -> None:
    style = load_style(name)
    shown = [entry["help"] for entry in panel(style, style)["entries"] if entry["main"]]
    assert not [help for help in shown if help.startswith("how much the picture on top")]


def test_equal_labels_of_knobs_are_numbered() -> None:
    knobs = ["posterize#1.levels", "posterize#2.levels"]
    style = made(knobs=knobs, lines=[{"block": "posterize"}] * 2)
    labels = [knob.label for knob in knobs_of(style, table_from_style(style)).values()]
    assert labels == ["Number of tones 1", "Number of tones 2"]


@pytest.mark.parametrize("name", style_names())
def test_the_knobs_of_a_style_have_labels_that_say_what_they_do(name: str) -> None:
    style = load_style(name)
    labels = [knob.label for knob in knobs_of(style, table_from_style(style)).values()]
    assert not {"Blend amount", "Blur"}.intersection(labels)
    assert not any(label[-1].isdigit() for label in labels)


@pytest.mark.parametrize(
    ("labels", "told"),
    [
        ("ink", "labels is not a table"),
        ({"ink": ""}, "labels: '' is not a text of 1 to 40 characters"),
        ({"ink": 5}, "labels: 5 is not a text"),
        ({"ink": "x" * 41}, "is not a text of 1 to 40 characters"),
        ({"posterise.levels": "x"}, "labels: there is no step 'posterise'; did you mean 'posterize'"),
        ({"posterize.levels": "a", "lines.posterize.levels": "b"}, "is there twice"),
        ({f"x{number}": "x" for number in range(65)}, "at most 64 labels"),
    ],
)
def test_a_label_is_a_short_text_for_a_value(labels: object, told: str) -> None:
    with pytest.raises(StyleError) as caught:
        made(labels=labels, lines=[{"block": "posterize"}])
    assert told in str(caught.value)


def test_mute_is_true_or_false() -> None:
    with pytest.raises(StyleError, match="mute: 'yes' is not true or false"):
        made(lines=[{"block": "posterize", "mute": "yes"}])


def test_a_muted_step_hands_on_and_saves_its_input() -> None:
    steps = (step("saturation", factor=0.2, save="pale"), step("hue", angle=90), step("blend", other="pale"))
    muted = (replace(steps[0], mute=True), *steps[1:])
    bare = (step(save="pale"), *steps[1:])
    assert (run_color(style(*muted), COLORS) == run_color(style(*bare), COLORS)).all()
    assert not np.allclose(run_color(style(*muted), COLORS), run_color(style(*steps), COLORS))


def test_what_a_muted_block_saves_by_itself_is_saved_all_the_same() -> None:
    muted = style(replace(step("to_gray"), mute=True), step("posterize", levels=4), step("to_color"))
    assert np.ptp(run_color(muted, COLORS), axis=2).max() > 0.1


def test_muted_lines_are_not_laid_over_the_background() -> None:
    drawn = Style("s", lines=(step("sobel"),), background=(step("hue", angle=90),))
    muted = replace(drawn, lines=(replace(drawn.lines[0], mute=True),))
    assert (run_color(muted, COLORS) == run_color(replace(drawn, lines=()), COLORS)).all()


@pytest.mark.parametrize("name", ["comic", "ink", "plain"])
def test_strength_mixes_the_result_with_the_source(name: str) -> None:
    whole = replace(load_style(name), steady=0.0)
    result = run_color(whole, COLORS)
    mixed = run_color(replace(whole, strength=0.25), COLORS)
    np.testing.assert_allclose(mixed, 0.75 * COLORS + 0.25 * result, atol=2e-5)
    assert override(whole, ["strength=0.25"]).strength == 0.25
    with pytest.raises(UsageError, match="is outside 0 to 1"):
        override(whole, ["strength=1.5"])


def test_a_gray_result_gets_the_colours_of_the_source_back_in_part() -> None:
    gray = style(step("to_gray"))
    mixed = run_color(replace(gray, strength=0.5), COLORS)
    np.testing.assert_allclose(mixed, (COLORS + run_color(gray, COLORS)) / 2, atol=2e-5)


def test_a_gpu_mutes_and_mixes_alike(sessions: Sessions) -> None:
    comic = replace(load_style("comic"), steady=0.0, strength=0.4)
    muted = replace(comic, background=tuple(replace(each, mute=True) for each in comic.background[:2]))
    for name, chosen in {"mixed": comic, "alone": replace(comic, strength=1.0), "muted": muted}.items():
        assert faults(sessions, chosen, film_picture(*SMALL), name, [drawn(FORMS, name)]) == []


@pytest.mark.parametrize("name", ["comic", "noir"])
def test_what_leaves_each_step_is_what_the_steps_before_it_make(name: str) -> None:
    chosen = replace(load_style(name), steady=0.0, keeps_detail=True)
    source = (COLORS * 255).astype(np.uint8).repeat(3, axis=0).repeat(3, axis=1)
    with ThreadPoolExecutor(2) as pool:
        pictures = step_pictures(chosen, Picture.from_array(source), pool)
    assert len(pictures) == len(chosen.steps)
    whole = {key: made for key, made in pictures.items() if made.shape == source.shape}
    assert len(whole) > 3
    for key, each in whole.items():
        alone = stylize(source, solo(chosen, *key), "cpu").astype(int)
        assert np.abs(alone - each).max() <= 1, key


def test_shipped_styles_name_their_kinds_and_others_are_refused() -> None:
    for path in asset_folder("styles").glob("*.toml"):
        assert load_style(path).kinds, f"{path.stem} would be listed under no kind"
    kept = load_style({"format": 1, "kinds": ["film", "drawn"]})
    assert table_from_style(kept)["kinds"] == ["film", "drawn"]
    with pytest.raises(StyleError, match="'drawm' is not a kind of look; did you mean 'drawn'"):
        load_style({"format": 1, "kinds": ["drawm", ["x"]]})
    with pytest.raises(StyleError, match="kinds is not a list"):
        load_style({"format": 1, "kinds": "drawn"})
