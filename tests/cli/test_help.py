"""The help of every command, and hints for words that users of other programs type."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from media import make_clip

from vidstyle import cli
from vidstyle.cli import commands
from vidstyle.cli.parsing.command import MAX_UNGROUPED, Command, Group
from vidstyle.cli.parsing.foreign_names import FOREIGN_NAMES, KNOWN_FOREIGN_NAMES
from vidstyle.cli.terminal.reporting import Reporting

CONTEXT = click.Context(commands, info_name="vidstyle", obj=Reporting())
NAMES = commands.list_commands(CONTEXT)


def command_of(name: str) -> Command:
    command = commands.get_command(CONTEXT, name)
    assert isinstance(command, Command)
    return command


def help_of(name: str) -> str:
    command = command_of(name)
    return click.Context(command, CONTEXT, name, terminal_width=80, **cli.CONTEXT).get_help()


def error(capfd: pytest.CaptureFixture[str], line: str) -> str:
    """What the program says about a wrong command line: one line, exit code 2."""
    capfd.readouterr()
    assert cli.main(shlex.split(line)) == 2
    said = capfd.readouterr().err
    assert said.startswith("vidstyle: ") and said.count("\n") == 1
    return said


@pytest.mark.parametrize("name", NAMES)
def test_help_fits_80_columns_and_shows_every_option(name: str) -> None:
    text = help_of(name)
    assert max(map(len, text.splitlines())) <= 80 and "\\b" not in text and "\b" not in text
    options = [each for each in command_of(name).params if isinstance(each, click.Option)]
    titles = [group.value for group in Group if f"\n{group.value}:\n" in text]
    assert bool(titles) is (len(options) + 1 > MAX_UNGROUPED)
    for each in options:
        if each.hidden:
            continue
        assert len(re.findall(rf"^  (?:-\w, )?{max(each.opts, key=len)}\b(?!-)", text, re.MULTILINE)) == 1


@pytest.mark.parametrize("name", NAMES)
def test_examples_are_command_lines_that_parse(name: str) -> None:
    for line in command_of(name).examples:
        program, command, *words = shlex.split(line, comments=True)
        assert (program, command) == ("vidstyle", name)
        command_of(name).make_context(name, words, CONTEXT, resilient_parsing=True)


def test_large_commands_have_three_examples_and_lead_to_more() -> None:
    for name in ("render", "live", "comic"):
        assert len(command_of(name).examples) == 3
        assert "vidstyle styles" in help_of(name)
    guides = re.findall(r"docs/\w+\.md|README\.md", "".join(map(help_of, NAMES)))
    assert guides and all((Path(cli.__file__).parents[2] / guide).is_file() for guide in guides)


def test_the_program_alone_shows_a_first_command(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main([]) == 0
    out = capfd.readouterr().out
    assert "\n    vidstyle demo " in out and "\n    vidstyle render demo/film.mp4 " in out
    assert max(map(len, out.splitlines())) <= 80


def answers() -> Iterator[tuple[str, str]]:
    """Each foreign name, and a command that has our option for it."""
    for name in sorted(KNOWN_FOREIGN_NAMES):
        ours = {line.split()[0] for line, names in FOREIGN_NAMES.items() if name in names.split()}
        having = [
            command
            for command in ("render", "live")
            if ours & {opt for each in command_of(command).params for opt in each.opts}
        ]
        yield name, having[0]


@pytest.mark.parametrize(("name", "command"), [*answers()])
def test_a_foreign_name_is_answered_with_an_option_that_exists(
    capfd: pytest.CaptureFixture[str], name: str, command: str
) -> None:
    said = error(capfd, f"{command} {name} 1 in.mp4 out.mp4")
    found = re.fullmatch(rf"vidstyle: there is no option '{re.escape(name)}'; use (--.*?) \(.*\)\n", said)
    assert found is not None, said
    option = found[1].split()[0]
    assert option in {opt for each in command_of(command).params for opt in each.opts}
    command_of(command).make_context(command, [*found[1].split(), "in.mp4"], CONTEXT)  # its value is valid


def test_ten_names_and_more_are_known() -> None:
    assert {"-ss", "-t", "-to", "-c:v", "-vf", "-r", "-b:v", "-an", "-q", "--quality", "-e", "--encoder",
            "-crf", "-preset", "-pix_fmt", "-f"} <= KNOWN_FOREIGN_NAMES  # fmt: skip


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("render in.mp4 out.mp4 -s 640x360", "-s is for styles; use --size 640x360"),
        ("render in.mp4 out.mp4 -movflags faststart", "there is no option '-movflags'; see vidstyle render"),
        ("comic -ss 3 in.mp4 out.png", "there is no option '-ss'; see vidstyle comic --help"),
        ("render -i a.mp4 -i b.mp4 o.mp4", "--input is given more than once: 'a.mp4' and 'b.mp4'; keep one"),
        ("render a.mp4 -o b.mp4 --output c.mp4", "--output is given more than once: 'b.mp4' and 'c.mp4'"),
        ("render a b -s ink --style noir", "--style is given more than once: 'ink' and 'noir'"),
        ("comic a b --reading ltr --right-to-left", "--right-to-left: contradicts --reading ltr"),
        ("comic a b --reading ltr --layout manga", "--layout manga: contradicts --reading ltr"),
        ("render a b -s plain --no-autorotate --rotate 90", "--no-autorotate: contradicts --rotate 90"),
    ],
)
def test_what_would_be_misread_is_refused(capfd: pytest.CaptureFixture[str], line: str, words: str) -> None:
    assert words in error(capfd, line)


def test_replaced_options_have_the_effect_of_their_successors(
    capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    clip = str(make_clip(tmp_path / "clip.mp4", frames=2, rotation=90))
    for name, options in (("old", ["--no-autorotate"]), ("new", ["--rotate", "0"]), ("upright", [])):
        assert cli.main(["render", "-s", "plain", clip, str(tmp_path / f"{name}.y4m"), *options]) == 0
    assert "--no-autorotate: replaced by --rotate 0" in capfd.readouterr().err
    old, new, upright = ((tmp_path / f"{name}.y4m").read_bytes() for name in ("old", "new", "upright"))
    assert old == new != upright
    for name, options in (("old", ["--right-to-left"]), ("new", ["--reading", "rtl"])):
        saved = str(tmp_path / f"{name}.toml")
        page = str(tmp_path / f"{name}.png")
        assert cli.main(["comic", "-s", "plain", clip, page, "--save", saved, *options]) == 0
    assert "--right-to-left: replaced by --reading rtl" in capfd.readouterr().err
    assert 'reading = "rtl"' in (tmp_path / "old.toml").read_text()


def test_values_and_words_after_the_dashes_are_no_names(capfd: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["comic", "none.mp4", "page.png", "--title", "-t"]) == 3
    assert cli.main(["render", "-s", "plain", "--", "-ss", "out.mp4"]) == 3
    assert "-ss: no such file" in capfd.readouterr().err


def test_unquoted_names_and_patterns_get_the_right_hint(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("my film.mp4", "1.png", "2.png", "3.png"):
        Path(name).touch()
    assert "in quotes: 'my film.mp4'" in error(capfd, "render my film.mp4 out.mp4 -s ink")
    assert "a name with spaces in quotes" in error(capfd, "render 1.png my result.png -s ink")
    assert "a pattern such as 'frames/*.png'" in error(capfd, "render 1.png 2.png 3.png out.mp4 -s ink")
