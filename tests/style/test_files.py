"""Saving of styles: comments are preserved, and reading returns the saved style."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import pytest
from random_styles import add_comments, random_style

from vidstyle.errors import OutputError, StyleError
from vidstyle.style import Step, Style, load_style, save_style

COMMENTED = """\
# A style with words around it.
format = 1 # always
name = "talk"   # spaces kept

# Colours.

# First flatten.
[[background]]
# inside
block = "posterize" # why
levels = 5 # five

# Then lines.
# Two lines of words.
[[lines]]
block = "to_gray"

# Again colour.
[[background]]
block = "hue"

# The end.
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "talk.toml"
    path.write_text(COMMENTED, encoding="utf-8")
    return path


def lines_changed(path: Path) -> tuple[list[str], list[str]]:
    """The lines that went and those that came."""
    before, after = COMMENTED.splitlines(), path.read_text(encoding="utf-8").splitlines()
    return [line for line in before if line not in after], [line for line in after if line not in before]


def test_a_new_file_is_written(tmp_path: Path) -> None:
    style = Style("new", note="«Ünï»", ink="#102030", lines=(Step("posterize", {"levels": 3}, save="a"),))
    save_style(style, tmp_path / "new.toml")
    assert load_style(tmp_path / "new.toml") == replace(style, folder=tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["new.toml"]


def test_nothing_changes_when_nothing_was_changed(path: Path) -> None:
    save_style(load_style(path), path)
    assert path.read_text(encoding="utf-8") == COMMENTED


def test_changed_values_change_their_lines_only(path: Path) -> None:
    style = load_style(path)
    flat = replace(style.background[0], values={"levels": 7}, save="flat")
    save_style(replace(style, ink="#ff0000", background=(flat, style.background[1])), path)
    assert lines_changed(path) == (
        ["levels = 5 # five"],
        ['ink = "#ff0000"', "levels = 7 # five", 'save = "flat"'],
    )
    assert load_style(path).background[0].save == "flat"


def test_comments_go_with_their_steps(path: Path) -> None:
    style = load_style(path)
    save_style(replace(style, background=style.background[1:]), path)
    gone, came = lines_changed(path)
    assert gone == ["# First flatten.", "# inside", 'block = "posterize" # why', "levels = 5 # five"]
    assert came == []


def test_new_steps_stand_where_they_run(path: Path) -> None:
    style = load_style(path)
    steps = (Step("brightness"), style.background[0], Step("saturation"), style.background[1])
    save_style(replace(style, base=(Step("gaussian"),), background=steps), path)
    assert lines_changed(path)[0] == []
    text = path.read_text(encoding="utf-8")
    order = [
        text.index(f'"{name}"')
        for name in ("brightness", "posterize", "saturation", "to_gray", "hue", "gaussian")
    ]
    assert order == sorted(order)
    assert load_style(path).base == (Step("gaussian"),)


def test_a_field_that_is_written_out_stays_so(tmp_path: Path) -> None:
    path = tmp_path / "inked.toml"
    path.write_text("format = 1\nname = 'i'\nink = '#112233' # navy\nheight = 720\n", encoding="utf-8")
    save_style(Style("i"), path)
    assert path.read_text(encoding="utf-8") == "format = 1\nname = 'i'\nink = \"#000000\" # navy\n"


def test_the_line_breaks_of_a_note_stay(tmp_path: Path) -> None:
    path = tmp_path / "noted.toml"
    path.write_text('format = 1\nname = "n"\nnote = """\nOne\ntwo."""\n', encoding="utf-8")
    save_style(replace(load_style(path), ink="#ff0000"), path)
    assert 'note = """\nOne\ntwo."""\nink' in path.read_text(encoding="utf-8")


def test_line_ends_of_windows_stay(path: Path) -> None:
    path.write_bytes(COMMENTED.replace("\n", "\r\n").encode())
    save_style(replace(load_style(path), ink="#ff0000"), path)
    content = path.read_bytes()
    assert b"ink" in content
    assert content.count(b"\n") == content.count(b"\r\n")


@pytest.mark.parametrize(
    "text",
    [
        "format = 1 # one\nbase = [{ block = 'hue' }] # two\n",
        "format = 1 # one\n[['base']]\nblock = 'hue'\n",
        "format = 1 # one\n[[base]]\nblock = 'posterize'\n[['base']] # two\nblock = 'hue'\n",
    ],
)
def test_a_layout_that_cannot_be_edited_is_written_anew_and_said(
    path: Path, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    path.write_text(text, encoding="utf-8")
    with caplog.at_level(logging.WARNING, logger="vidstyle"):
        save_style(replace(load_style(path), base=(Step("posterize"),)), path)
    assert "without its comments" in caplog.text
    assert load_style(path).base == (Step("posterize"),)


@pytest.mark.parametrize("content", ["[project]\nname = 'x'\n", "format = 2\n", "format = true\n"])
def test_what_is_no_style_is_not_written_over(path: Path, content: str) -> None:
    path.write_text(content, encoding="utf-8")
    with pytest.raises(StyleError, match="exists and is not a style"):
        save_style(Style("new"), path)
    assert path.read_text(encoding="utf-8") == content


def test_a_style_with_mistakes_is_not_written(path: Path) -> None:
    with pytest.raises(StyleError, match="levels: 99 is outside"):
        save_style(Style("new", base=(Step("posterize", {"levels": 99}),)), path)
    assert path.read_text(encoding="utf-8") == COMMENTED


def test_a_folder_that_is_not_there_is_an_output_error(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"x\.toml: its folder does not exist"):
        save_style(Style("new"), tmp_path / "none" / "x.toml")


def test_saving_leaves_other_files_alone(tmp_path: Path) -> None:
    (tmp_path / "x.toml.partial").write_text("mine")
    save_style(Style("new"), tmp_path / "x.toml")
    assert (tmp_path / "x.toml.partial").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["x.toml", "x.toml.partial"]


def test_any_style_saved_over_any_other_reads_back(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    for number in range(60):
        path = tmp_path / f"{number}.toml"
        save_style(random_style(2 * number, tmp_path), path)
        add_comments(path)
        style = random_style(2 * number + 1, tmp_path)
        save_style(style, path)
        assert load_style(path) == style
        assert "format = 1 # beside" in path.read_text(encoding="utf-8")
    assert not caplog.records
