"""Variants: named sets of values in the file of a style."""

from __future__ import annotations

import itertools
import json
import random
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from covering import in_one_test
from random_styles import add_comments, random_style

from vidstyle.cli import main
from vidstyle.errors import StyleError
from vidstyle.style import (
    Step,
    Style,
    describe,
    load_style,
    override,
    save_style,
    style_names,
    style_schema,
    table_from_style,
)

FILE = """\
format = 1
name = "inked"
height = 720

[[background]]
block = "luma_posterize"
levels = 5

[[lines]]
block = "gaussian"

[[lines]]
block = "gaussian"
sigma = 3

# For the night.
[variants.dark-blue]
ink = "#101040" # navy
"luma_posterize.levels" = 3

# Bold.
[variants.2]
"lines.gaussian#2.sigma" = 5
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(FILE, encoding="utf-8")
    return path


def table(**variants: Any) -> dict[str, Any]:
    steps = {"base": [{"block": "posterize"}], "lines": [{"block": "hue"}, {"block": "hue"}]}
    return {"format": 1, "name": "t", **steps, "variants": variants}


def mistakes_of(style: Any) -> list[str]:
    with pytest.raises(StyleError) as caught:
        load_style(style)
    return caught.value.mistakes


def test_a_variant_is_the_style_with_its_values_set(path: Path) -> None:
    style = load_style(path)
    blue = load_style(f"{path}:dark-blue")
    steps = (Step("luma_posterize", {"levels": 3}),)
    assert blue == replace(style, name="inked:dark-blue", ink="#101040", background=steps, variants={})
    bold = load_style(f"{path}:2")
    assert [step.values for step in bold.lines] == [{}, {"sigma": 5.0}]
    assert style.lines[1].values == {"sigma": 3.0}
    assert override(style, ["ink=#ff0000"]).variants == style.variants
    assert load_style(table_from_style(blue)) == replace(blue, folder=None)


def test_shipped_styles_have_variants_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "ink.toml").write_text(FILE.replace("inked", "ink"), encoding="utf-8")
    monkeypatch.setattr("vidstyle.style.asset_folder", lambda name: tmp_path)
    assert load_style("ink:dark-blue").name == "ink:dark-blue"
    assert mistakes_of("ink:dark-bleu") == ["there is no variant 'ink:dark-bleu'; did you mean 'dark-blue'?"]
    assert mistakes_of("ink:") == ["there is no variant 'ink:'; there are dark-blue, 2"]
    assert mistakes_of("plain:x") == ["there is no variant 'plain:x'; there are none"]
    assert mistakes_of("inc:dark-blue") == ["there is no style 'inc'; did you mean 'ink'?"]


def test_every_shipped_variant_loads_and_differs_from_its_style() -> None:
    for name in style_names():
        style = load_style(name)
        for variant in style.variants:
            varied = load_style(f"{name}:{variant}")
            assert varied != replace(style, name=varied.name, variants={}), varied.name


def test_other_colons_are_no_variants(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a:b.toml", "C:drive.toml", "C:\\folder\\x.toml", "mine.toml:own", "mine.toml:dark-blue"):
        Path(name).write_text(f"format = 1\nnote = '{name}'", encoding="utf-8")
        assert load_style(name).note == name
    Path("a:b.toml").write_text(FILE, encoding="utf-8")
    assert load_style("a:b.toml:dark-blue").name == "inked:dark-blue"
    Path("mine.toml:dark-blue").unlink()
    assert load_style("mine.toml:dark-blue").name == "inked:dark-blue"
    Path("plain:x").write_text(FILE, encoding="utf-8")
    assert "there is no variant 'plain:x'" in mistakes_of("plain:x")[0]
    assert mistakes_of("C:none.toml") == ["cannot be read: No such file or directory"]


@in_one_test(
    "variants, mistake",
    [
        ("x", "variants: 'x' is not a table; write [variants.NAME] above each"),
        ({"blue": 3}, "variants.blue: 3 is not a table of values"),
        ({"Dark Blue": {}}, "variants: 'Dark Blue' is not a name of 1 to 40 of a-z, 0-9 and -; did you mean"),
        ({"a" * 41: {}}, "is not a name of 1 to 40"),
        ({"": {}}, "variants: '' is not a name of 1 to 40 of a-z, 0-9 and -"),
        ({"é\n": {}}, "is not a name"),
        ({f"v{number}": {} for number in range(33)}, "variants: a style has at most 32 variants"),
        ({"b": {"posterize.levels": 99}}, "variants.b: posterize.levels: 99 is outside 2 to 32"),
        (
            {"b": {"posterize.levls": 9}},
            "variants.b: posterize has no parameter 'levls'; did you mean 'le",
        ),
        (
            {"b": {"posterise.levels": 9}},
            "variants.b: there is no step 'posterise'; did you mean 'posterize'?",
        ),
        ({"b": {"hue.angle": 9}}, "variants.b: 'hue' may be lines.hue#1 or lines.hue#2"),
        ({"b": {"inc": "#000000"}}, "variants.b: 'inc' is not a field of a style; did you mean 'ink'?"),
        ({"b": {"name": "x"}}, "variants.b: 'name' is not a field"),
        ({"b": {"variants": {}}}, "variants.b: 'variants' is a table"),
        (
            {"b": {"posterize": {"levels": 5}}},
            "variants.b: 'posterize' is a table; write \"posterize.levels\"",
        ),
        ({"b": {"ink": "rde"}}, "variants.b: ink: 'rde' is not a colour"),
        ({"b": {"steady": 2}}, "variants.b: steady: 2 is outside 0 to 1"),
        ({"b": {"ink": ["#000000"]}}, "variants.b: ink: a list is not a text"),
        ({"b": {"posterize.levels": "5"}}, "variants.b: posterize.levels: '5' is not a whole number"),
    ],
)
def test_a_mistake_is_named(variants: Any, mistake: str) -> None:
    (found,) = mistakes_of(table() | {"variants": variants})
    assert mistake in found


def test_a_variant_must_be_right_as_a_whole() -> None:
    layers = {"base": [{"save": "a"}, {"block": "blend", "other": "a"}]}
    found = mistakes_of({"format": 1, **layers, "variants": {"b": {"blend.other": "lost"}}})
    assert found == [
        "variants.b: base step 2 (blend): other: no step before it saves 'lost'; "
        "there are source, people, background, faces, skin, backdrop, a"
    ]
    long = table(b={}) | {"name": "n" * 99}
    assert mistakes_of(long)[0].startswith("variants.b: name: ")


def test_all_mistakes_are_named_at_once_and_at_the_command_line_in_one_line(
    path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    assert len(mistakes_of(table(a={"ink": 7, "x.y": 3}, b={"posterize.levels": 1}, C={}))) == 4
    path.write_text(FILE.replace('"#101040"', '"#12"'), encoding="utf-8")
    assert main(["styles", f"{path}:dark-blue"]) == 3
    err = capfd.readouterr().err
    assert err == (
        f"vidstyle: {path}: line 18: variants.dark-blue: ink: "
        "'#12' is not a colour (#rrggbb, #rgb or a CSS name)\n"
    )


def test_a_flood_of_variants_is_refused_soon(tmp_path: Path) -> None:
    steps = {"base": [{"block": "hue"}] * 256}
    paths = {f"hue#{'9' * 3}{' ' * number}.x": 0 for number in range(600)}
    calls = itertools.count()
    sys.setprofile(lambda *_: next(calls))
    try:
        found = mistakes_of({"format": 1, **steps, "variants": {f"v{number}": paths for number in range(32)}})
    finally:
        sys.setprofile(None)
    assert next(calls) < 3_000_000
    assert len(found) <= 51 and max(map(len, found)) < 2000


def test_saving_keeps_variants_and_the_words_around_them(path: Path) -> None:
    style = load_style(path)
    save_style(style, path)
    assert path.read_text(encoding="utf-8") == FILE
    changed = {"dark-blue": {"ink": "#101040", "luma_posterize.levels": 4}, "red": {"ink": "#ff0000"}}
    save_style(replace(style, variants=changed, height=360), path)
    lines, before = path.read_text(encoding="utf-8").splitlines(), FILE.splitlines()
    assert [line for line in lines if line not in before] == [
        "height = 360",
        '"luma_posterize.levels" = 4',
        "[variants.red]",
        'ink = "#ff0000"',
    ]
    assert [line for line in before if line not in lines] == [
        "height = 720",
        '"luma_posterize.levels" = 3',
        "# Bold.",
        "[variants.2]",
        '"lines.gaussian#2.sigma" = 5',
    ]
    assert load_style(path).variants == changed
    save_style(replace(style, variants={}), path)
    assert "variants" not in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "text",
    [
        'format = 1\nvariants.blue.ink = "#0000ff"\n',
        'format = 1\n[variants]\nblue = { ink = "#0000ff" }\n',
        'format = 1\n[variants]\n[variants.blue]\nink = "#0000ff"\n',
        'format = 1\n[variants."blue"]\nink = "#0000ff"\n[[base]]\nblock = "hue"\n',
    ],
)
def test_variants_in_another_layout_are_not_lost(tmp_path: Path, text: str) -> None:
    path = tmp_path / "x.toml"
    path.write_text(text, encoding="utf-8")
    style = replace(load_style(path), paper="#eeeeee")
    save_style(style, path)
    assert load_style(path) == style
    assert load_style(f"{path}:blue").ink == "#0000ff"


def test_any_style_with_variants_saved_over_any_other_reads_back(tmp_path: Path) -> None:
    chance = random.Random(5)
    for number in range(30):
        path = tmp_path / f"{number}.toml"
        for _ in range(2):
            names = chance.sample(["a", "b", "2-c", "-d"], chance.randint(0, 4))
            variants = {name: {"ink": f"#{chance.randrange(2**24):06x}", "steady": 0.5} for name in names}
            style = replace(random_style(chance.randrange(2**32), tmp_path), variants=variants)
            save_style(style, path)
            assert load_style(path) == style
            add_comments(path)


def test_schema_and_descriptions_hold_variants(path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    validator = jsonschema.Draft202012Validator(style_schema())
    style = load_style(path)
    validator.validate(table_from_style(style))
    for wrong in ({"B": {}}, {"b": {"inc": 1}}, {"b": {"ink": "#12"}}, {"b": {"hue.angle": []}}, {"b": 1}):
        assert not validator.is_valid(table(**wrong)), wrong
    assert describe(style)["variants"] == style.variants
    assert json.loads(json.dumps(describe(style)))["variants"]["2"] == {"lines.gaussian#2.sigma": 5.0}
    assert main(["styles", str(path)]) == 0
    out = capfd.readouterr().out
    assert '  variant dark-blue: ink = "#101040", luma_posterize.levels = 3\n' in out


def test_the_list_of_styles_names_variants(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "ink.toml").write_text(FILE.replace('"inked"', '"ink"\nnote = "Ink."'), encoding="utf-8")
    monkeypatch.setattr("vidstyle.style.asset_folder", lambda name: tmp_path)
    assert main(["styles"]) == 0
    lines = capfd.readouterr().out.splitlines()
    assert lines[0] == f"{'ink':16} Ink. Variants: ink:dark-blue, ink:2."
    assert main(["styles", "ink:dark-blue", "--json"]) == 0
    assert json.loads(capfd.readouterr().out)["ink"] == "#101040"


def test_an_empty_style_without_variants_stays_as_it_was() -> None:
    assert Style("x") == Style("x", variants={})
    assert table_from_style(Style("x")) == {"format": 1, "name": "x"}
