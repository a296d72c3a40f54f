"""Reading of styles: valid ones, reported mistakes, and safety of untrusted files."""

from __future__ import annotations

import operator
import os
import random
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
from covering import in_one_test

from vidstyle.block import Asset, block
from vidstyle.blocks import all_blocks
from vidstyle.errors import StyleError
from vidstyle.style import Step, Style, load_style, style_file, style_names, table_from_style, user_styles
from vidstyle.style.resolve import resolve

FIXTURES = sorted((Path(__file__).parents[1] / "fixtures" / "styles").glob("*.toml"))


def write(folder: Path, text: str | bytes, name: str = "style.toml") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def step(layer: str = "background", **keys: object) -> dict[str, Any]:
    return {"format": 1, layer: [{key.rstrip("_"): value for key, value in keys.items()}]}


def mistakes_of(style: str | Path | dict[str, Any]) -> list[str]:
    with pytest.raises(StyleError) as caught:
        load_style(style)
    assert "\n" not in str(caught.value)
    return caught.value.mistakes


@pytest.mark.parametrize("path", FIXTURES, ids=lambda path: path.stem)
def test_old_files_open(path: Path) -> None:
    style = load_style(path)
    assert load_style(table_from_style(style) | {"name": style.name}).steps == style.steps


def test_a_file_is_read_to_the_letter() -> None:
    style = load_style(FIXTURES[1])
    assert (style.name, style.ink, style.folder) == ("graph", "#000000", FIXTURES[1].parent)
    assert style.base == (Step("luma_posterize", {"levels": 6}, save="flat"),)
    assert style.background[0] == Step("", source="source")
    assert style.background[1].values == {"other": "flat", "mode": "multiply", "opacity": 1.0}
    assert [each.block for each in style.lines] == ["to_gray", "soft_threshold", "to_color", "to_gray"]


@pytest.mark.parametrize(
    ("old", "new"),
    [("abstraction", "cartoon"), ("anime", "cartoon"), ("blob", "poster"), ("ukiyo-e", "poster")],
)
def test_a_retired_style_loads_what_replaces_it(old: str, new: str, caplog: pytest.LogCaptureFixture) -> None:
    assert old not in style_names()
    assert load_style(old) == load_style(new) and style_file(old) == style_file(new)
    assert caplog.messages == [f"the style {old} is retired; {new} replaces it"]


def test_a_variant_of_a_retired_style_is_that_of_its_replacement() -> None:
    assert load_style("paint:animated") == load_style("impressionist:animated")


def test_a_style_of_the_user_may_have_a_retired_name(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    own = user_styles() / "paint.toml"
    own.parent.mkdir(parents=True)
    own.write_text('format = 1\nnote = "mine"\n')
    assert load_style("paint").note == "mine"


@in_one_test("name", style_names())
def test_every_shipped_style_opens_by_its_name(name: str) -> None:
    style = load_style(name)
    assert style.name == name
    assert style.is_plain == (name == "plain")
    assert style.note or style.is_plain


def test_a_style_may_be_given_in_every_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "format = 1\nink = '#FF0000'")
    monkeypatch.chdir(tmp_path)
    for form in ("style.toml", "./style.toml", tmp_path / "style.toml", {"format": 1, "ink": "#ff0000"}):
        assert load_style(form).ink == "#ff0000"
    assert load_style("style.toml").name == "style"
    assert load_style("style.toml").folder == tmp_path
    assert load_style(style := Style("mine")) is style


def test_the_style_in_the_readme_opens(tmp_path: Path) -> None:
    readme = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
    style = load_style(write(tmp_path, readme.partition("```toml\n")[2].partition("```")[0]))
    assert style.background and style.lines


def test_coloured_paper_alone_is_not_plain() -> None:
    assert Style("white").is_plain
    assert not Style("tinted", paper="#ffeedd").is_plain
    assert not Style("flat", lines=(Step("posterize"),)).is_plain


@in_one_test(
    "table, mistake",
    [
        ({}, "format is missing; a style file says format = 1"),
        ({"format": 2, "shiny": 1}, "format 2 is unknown; this vidstyle reads format 1"),
        ({"format": True}, "format True is unknown; this vidstyle reads format 1"),
        ({"format": 1, "papper": "#ffffff"}, "'papper' is not a field of a style; did you mean 'paper'?"),
        (
            {"format": 1, "ink": "rde"},
            "ink: 'rde' is not a colour; did you mean 'red'? (#rrggbb, #rgb or a CSS",
        ),
        ({"format": 1, "ink": "#12345"}, "ink: '#12345' is not a colour (#rrggbb, #rgb or a CSS name)"),
        ({"format": 1, "height": 0}, "height: 0 is outside 16 to 65536 px"),
        ({"format": 1, "name": 7}, "name: 7 is not a text of at most 100 characters"),
        ({"format": 1, "note": "\x1b[2J"}, "note: '\\x1b[2J' is not a text of at most 1000 characters"),
        ({"format": 1, "base": {"block": "hue"}}, "base is not a list of steps; write [[base]] above each"),
        (step(block="posterise"), "background step 1: 'posterise' is not a block; did you mean 'posterize'?"),
        (step(block="posterize", levls=5), "'levls' is not a parameter; did you mean 'levels'?"),
        (step(block="posterize", levels=99), "background step 1 (posterize): levels: 99 is outside 2 to 32"),
        (step(block="posterize", levels=1), "levels: 1 is outside 2 to 32"),
        (step(block="posterize", levels=2.5), "levels: 2.5 is not a whole number (2 to 32)"),
        (step(block="posterize", levels=float("nan")), "levels: nan is not a whole number (2 to 32)"),
        (step(block="posterize", levels=float("inf")), "levels: inf is not a whole number (2 to 32)"),
        (step(block="posterize", levels=1e308), "levels: 1e+308 is outside 2 to 32"),
        (step(block="posterize", levels=10**5000), "levels: a huge number is outside 2 to 32"),
        (step(block="posterize", levels=True), "levels: True is not a whole number (2 to 32)"),
        (step(block="posterize", levels="5"), "levels: '5' is not a whole number (2 to 32)"),
        (
            step(block="posterize", levels=[5]),
            "levels: a list is not a text, a number or a truth value (2 to 32)",
        ),
        (step(block="blend", mode="multipy"), "mode: 'multipy' is not one of normal, multiply"),
        (step(levels=5), "background step 1: block is missing; `vidstyle blocks` lists all"),
        (step(from_="source", levels=5), "background step 1: 'levels' needs a block, and the step has none"),
        (step(from_="sauce", block="hue"), "from: no step before it saves 'sauce'; did you mean 'source'?"),
        (step(save="a b"), "save: 'a b' is not a name of letters and digits"),
        (step(save="source"), "save: 'source' is the untouched picture; choose another name"),
        (step(block="blend", other="x"), "other: no step before it saves 'x'; there are source"),
        (step(block="to_color"), "chroma: no step before it saves 'chroma'; there are source"),
    ],
)
def test_a_mistake_is_named(table: dict[str, Any], mistake: str) -> None:
    (found,) = mistakes_of(table)
    assert mistake in found


def test_all_mistakes_are_named_at_once() -> None:
    table = step("lines", block="posterize", levels=99, levls=3) | {
        "ink": "bleu",
        "bace": [],
        "base": [{"block": "x"}],
    }
    assert len(mistakes_of(table)) == 5


def test_a_flood_of_mistakes_is_cut_off() -> None:
    found = mistakes_of({"format": 1} | {f"key{number}": 0 for number in range(500)})
    assert (len(found), found[-1]) == (51, "and 450 more mistakes")


def test_the_ends_of_a_range_are_allowed() -> None:
    for levels in (2, 32, 5.0):
        style = load_style(step(block="posterize", levels=levels))
        assert style.background[0].values == {"levels": levels}
        assert isinstance(style.background[0].values["levels"], int)


def test_saved_pictures_are_seen_by_all_later_steps() -> None:
    layers = {"background": [{"from": "a", "save": "b"}], "base": [{"save": "a"}], "lines": [{"from": "b"}]}
    assert load_style({"format": 1} | layers).lines == (Step("", source="b"),)
    swapped = {"background": [{"from": "b"}], "lines": [{"save": "b"}]}
    assert "no step before it saves 'b'" in mistakes_of({"format": 1} | swapped)[0]
    assert "from: no step" in mistakes_of(step(from_="own", save="own"))[0]
    twice = mistakes_of({"format": 1, "base": [{"save": "a"}], "lines": [{"save": "a"}]})
    assert twice == ["lines step 1: save: an earlier step has saved 'a'; choose another name"]


def test_to_gray_puts_the_colours_aside_for_to_color() -> None:
    steps = [{"block": "to_gray", "save": "gray"}, {"block": "to_gray"}, {"block": "to_color"}]
    assert len(load_style({"format": 1, "background": steps}).background) == 3


def test_the_number_of_steps_is_limited() -> None:
    steps = [{"block": "posterize"}] * 128
    assert len(load_style({"format": 1, "base": steps, "lines": steps}).steps) == 256
    assert mistakes_of({"format": 1, "base": steps, "lines": [*steps, *steps]}) == [
        "lines: a style has at most 256 steps"
    ]


@block("pixel", on="channels")
def stamp(
    picture: np.ndarray, file: Annotated[Any, Asset("what is stamped", Path.read_bytes, optional=True)] = ""
) -> np.ndarray:
    """Stand for any block that takes a file."""
    return picture


@pytest.fixture
def with_stamp(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(all_blocks(), "stamp", stamp)


@pytest.mark.usefixtures("with_stamp")
def test_paths_stay_in_the_folder_of_the_style(tmp_path: Path) -> None:
    folder = tmp_path / "mine"
    (folder / "tiles").mkdir(parents=True)
    write(tmp_path, "secret", "secret")
    write(folder, "tile", "tiles/one.png")
    (folder / "link").symlink_to(tmp_path / "secret")
    (folder / "inner").symlink_to(folder / "tiles")
    (folder / "loop").symlink_to(folder / "loop")
    os.mkfifo(folder / "pipe")
    for good in ("tiles/one.png", "tiles", "./inner/one.png", ""):
        load_style(write(folder, f"format = 1\nlines = [{{block = 'stamp', file = '{good}'}}]"))
    bad = [
        "../secret",
        "/etc/passwd",
        "tiles/../../secret",
        "link",
        "C:x",
        "a\\b",
        "none.png",
        "pipe",
        "loop",
    ]
    for path in [*bad, "n" * 199, "é" * 199, "n" * 9999]:
        text = f"format = 1\nlines = [{{block = 'stamp', file = '{path}'}}]"
        (found,) = mistakes_of(write(folder, text))
        assert "folder" in found, path
    assert "no folder" in mistakes_of(step(block="stamp", file="tiles/one.png"))[0]


@pytest.mark.usefixtures("with_stamp")
def test_files_of_a_style_are_few_and_read_once(tmp_path: Path) -> None:
    for number in range(5):
        write(tmp_path, str(number), f"{number}.png")
    steps = [f"{{block = 'stamp', file = '{number % 4}.png'}}" for number in range(8)]
    chosen = load_style(write(tmp_path, f"format = 1\nlines = [{', '.join(steps)}]"))
    read = [step.values["file"] for step in resolve(chosen, 4, 4)["lines"]]
    assert read[:4] == [b"0", b"1", b"2", b"3"] and all(map(operator.is_, read[:4], read[4:]))
    steps.append("{block = 'stamp', file = '4.png'}")
    (found,) = mistakes_of(write(tmp_path, f"format = 1\nlines = [{', '.join(steps)}]"))
    assert "'4.png' is one too many: a style reads at most 4 files" in found


@pytest.mark.parametrize(
    ("content", "mistake"),
    [
        (b"format = 1\nname = \xff", "line 2 is not UTF-8 text"),
        (b"format = 1\nname = = 'x'", "is not TOML: Invalid value (at line 2, column 8)"),
        (b"format = 1\nname = 'a'\nname = 'b'\n", "is not TOML: Cannot overwrite a value (at line 3"),
        (b"#" * (64 * 1024 + 1), "is larger than 64 KiB"),
        (b"format = 1\nname = " + b"[" * 60000, "line 2 is nested too deeply; 16 levels are possible"),
        (b"format = 1\n[[base]]\nblock = 'hue'\n" + b"x." * 16 + b"x = 1", "'x' is not a parameter"),
        (b"format = 1\nheight." + b"x." * 15 + b"x = 1", "height: a table is not a text, a number"),
        (b"format = 1\n" + b"x." * 30000 + b"x = 1", "line 2 is nested too deeply; 16 levels are possible"),
        (b"format = 1\nheight = " + b"9" * 60000, "line 2 has an integer of more than 64 bits"),
        (b"format = 1\nheight = 2026-01-01", "height: 2026-01-01 is not a text, a number"),
        (b"\0" * 100, "is not TOML"),
    ],
)
def test_a_hostile_file_is_refused(tmp_path: Path, content: bytes, mistake: str) -> None:
    (found,) = mistakes_of(write(tmp_path, content))
    assert mistake in found
    assert len(found) < 400


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.toml")
    assert mistakes_of(tmp_path / "pipe.toml") == ["is not a file"]
    assert mistakes_of(tmp_path) == ["cannot be read: Is a directory"]
    assert mistakes_of(tmp_path / "none.toml") == ["cannot be read: No such file or directory"]
    assert mistakes_of(tmp_path / ("n" * 999 + ".toml")) == ["cannot be read: File name too long"]
    assert mistakes_of("nul\0.toml") == ["embedded null byte"]
    assert "did you mean 'plain'?" in mistakes_of("plian")[0]
    assert "there is no style" in mistakes_of("..")[0]


def test_the_user_s_own_styles_have_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    user_styles().mkdir(parents=True)
    text = 'format = 1\nink = "#123456"\n[variants.red]\nink = "#ff0000"\n'
    for name in ("mine", "ink"):
        write(user_styles(), text, f"{name}.toml")
    assert "mine" in style_names() and len(set(style_names())) == len(style_names())
    assert load_style("mine:red").ink == "#ff0000" and load_style("ink").ink != "#123456"
    assert mistakes_of("mime") == ["there is no style 'mime'; did you mean 'mine'?"]


def test_all_mistakes_of_a_file_have_their_lines(tmp_path: Path) -> None:
    head = "format = 1|inc = '#000000'|ink = #f00000|[[lines]]|block = 'sobel'|invert = yes"
    text = f"{head}|[[lines]]|block = 'hue'|angel = 3|[[lines]]|save = 'source'|".replace("|", "\n")
    starts = [mistake.split(";")[0] for mistake in mistakes_of(write(tmp_path, text))]
    assert starts == [
        "line 3: #f00000 is not a value",
        "line 6: yes is not a value",
        "line 2: 'inc' is not a field of a style",
        "line 9: lines step 2 (hue): 'angel' is not a parameter",
        "line 11: lines step 3: save: 'source' is the untouched picture",
    ]


def test_a_note_of_several_lines_becomes_one(tmp_path: Path) -> None:
    assert load_style(write(tmp_path, 'format = 1\nnote = """\nOne\r\n  two."""')).note == "One two."


def test_a_byte_order_mark_does_no_harm(tmp_path: Path) -> None:
    assert load_style(write(tmp_path, b"\xef\xbb\xbfformat = 1\r\nname = 'x'\r\n")).name == "x"


def test_a_bad_style_leaves_the_others_usable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(tmp_path, "format = 1\nnote = 'fine'", "good.toml")
    write(tmp_path, "no style", "bad.toml")
    monkeypatch.setattr("vidstyle.style.asset_folder", lambda name: tmp_path)
    assert style_names() == ["bad", "good", "plain"]
    assert load_style("good").note == "fine"
    assert "is not TOML" in mistakes_of("bad")[0]


def mutated(text: bytes, chance: random.Random) -> bytes:
    """The text with a few bytes, lines or values changed."""
    words = [
        b"nan",
        b"-inf",
        b"1e999",
        b"''",
        b"[[",
        b"]]",
        b"{",
        b"=",
        b"\n",
        b"\0",
        b"\xff",
        b"[[base]]\n",
        b"9" * 40,
    ]
    words += [
        b"from='x'\n",
        b"save='source'\n",
        b"block='to_color'\n",
        b"../..",
        b"true",
        b"a.b.c=1\n",
        b'"""',
        b"#",
    ]
    for _ in range(chance.randint(1, 8)):
        start = chance.randrange(len(text) + 1)
        end = start + chance.choice((0, 0, 1, 5, 40))
        text = text[:start] + chance.choice(words) + text[end:]
    return text


def test_mutated_files_open_or_are_refused(tmp_path: Path) -> None:
    """300 files; the seed is fixed, so that what fails once fails again."""
    chance = random.Random(20)
    refused = 0
    for _ in range(300):
        content = mutated(chance.choice(FIXTURES).read_bytes(), chance)
        try:
            load_style(write(tmp_path, content))
        except StyleError as error:
            refused += 1
            assert str(error).isprintable(), content
    assert 100 < refused < 300
