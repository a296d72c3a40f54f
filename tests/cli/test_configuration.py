"""The user's configuration file, and the completion of names in a shell."""

from __future__ import annotations

import json
import os
from pathlib import Path

import media
import pytest

from vidstyle import cli


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The user's configuration file, which is not there yet."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "vidstyle").mkdir()
    return tmp_path / "vidstyle" / "config.toml"


def test_defaults_come_from_the_file_and_the_command_line_goes_before(
    file: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file.write_text(
        '[render]\nstyle = "plain"\nprogress = "json"\nset = "x.y=1"\n[live]\nto = ["page", "null"]\n'
    )
    media.make_picture(Path("in.png"))
    assert cli.main(["render", "in.png", "out.png", "--json"]) == 2
    (event,) = map(json.loads, capfd.readouterr().err.splitlines())
    assert event["event"] == "error" and "there is no step 'x'" in event["text"]
    file.write_text('[render]\nstyle = "nope"\noverwrite = true\n')
    Path("out.png").touch()
    assert cli.main(["render", "in.png", "out.png", "-s", "plain"]) == 0
    assert cli.main(["--config", "none", "render", "in.png", "out.png", "-s", "plain"]) == 2


def test_the_quality_of_films_is_none_of_pictures(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file.write_text('[render]\ncrf = 30\npreset = "fast"\nstyle = "plain"\n')
    media.make_picture(Path("in.png"))
    assert cli.main(["render", "in.png", "out.png"]) == 0
    assert cli.main(["render", "in.png", "other.png", "--crf", "30"]) == 2
    assert "--crf: the encoder png has no such setting" in capfd.readouterr().err
    file.write_text('[live]\ncrf = 30\nstyle = "plain"\n')
    live = ["live", "test", "--size", "32x24", "--frames", "1", "--no-keys", "--to"]
    assert cli.main([*live, "out.gif"]) == 0
    assert cli.main([*live, "other.gif", "--crf", "30"]) == 2


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("\n[rendr]\n", "line 2: there is no command 'rendr'; did you mean 'render'?"),
        ('[live]\nstyle = "ink"\n[render]\nstile = "ink"', "line 4: render has no option 'stile'; did you"),
        ("[live]\ncrf = 5\n[render]\n'crf' = 99", "line 4: crf: 99 is outside 0 to 63"),
        ("[render]\nfps = [25]", "line 2: fps: is not a text, a number or a truth value"),
        ("[render]\nstyle = ink", 'line 2: ink is not a value; write style = "ink"'),
        ("render = 1", "line 1: render is a command; write [render] above its options"),
        ("[render", "is not TOML: "),
        ("x = " + "[" * 20000, "line 1 is nested too deeply; 16 levels are possible"),
        ("a." * 20000 + "b = 1", "line 1 is nested too deeply; 16 levels are possible"),
        ("\n[render]\ncrf = " + "9" * 5000, "line 3 has an integer of more than 64 bits"),
        ('[render]\nmodel = "\\u0000"', "line 2: model: contains a NUL character"),
        ("[render]\noverwrite = 1.5", "line 2: overwrite: 1.5 is not true or false"),
    ],
)
def test_a_mistake_is_one_line_with_its_place(
    file: Path, capfd: pytest.CaptureFixture[str], text: str, mistake: str
) -> None:
    file.write_text(text)
    assert cli.main(["blocks"]) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert mistake in line and str(file) in line


def test_a_configuration_that_is_no_file_is_refused(file: Path, capfd: pytest.CaptureFixture[str]) -> None:
    os.mkfifo(file)
    assert cli.main(["blocks"]) == 2
    assert capfd.readouterr().err == f"vidstyle: {file} is not a file\n"


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("vidstyle ren", ["plain,render"]),
        ("vidstyle render -s ink:b", ["plain,ink:blue"]),
        ("vidstyle comic -s ink,no", ["plain,ink,noir", "plain,ink,noir:gray"]),
        ("vidstyle blocks poster", ["plain,posterize"]),
        ("vidstyle styles water", ["plain,watercolor"]),
        ("vidstyle render fi", ["file,fi"]),
    ],
)
def test_a_shell_completes_names(
    words: str, wanted: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("_VIDSTYLE_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", words)
    monkeypatch.setenv("COMP_CWORD", str(len(words.split()) - 1))
    assert cli.main([]) == 0
    assert capfd.readouterr() == ("".join(f"{line}\n" for line in wanted), "")
