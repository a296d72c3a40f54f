"""The command line: output, streams and exit codes."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Iterable
from itertools import groupby
from pathlib import Path

import media
import pytest

from vidstyle import cli
from vidstyle.blocks import all_blocks
from vidstyle.gpu.device.devices import list_devices
from vidstyle.style import style_names

HEAVY = ("av", "cv2", "numpy", "numba", "moderngl", "rich", "tomlkit")


def run(capfd: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of the program with these arguments, run in-process."""
    exit_code = cli.main([str(argument) for argument in arguments])
    return exit_code, *capfd.readouterr()


def run_and_list(names: Iterable[str], *arguments: object) -> tuple[str, list[str]]:
    """Run the program in a separate process; return its output, and which of these modules it loads."""
    program = (
        "import sys; from vidstyle.cli import main; code = main(sys.argv[1:]);"
        f"print([name for name in {[*names]!r} if name in sys.modules], file=sys.stderr); sys.exit(code)"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program, *map(str, arguments)], capture_output=True, text=True
    )
    assert ended.returncode == 0
    return ended.stdout, ast.literal_eval(ended.stderr.splitlines()[-1])


@pytest.mark.parametrize("arguments", [["--help"], ["render", "--help"]])
def test_help_loads_nothing_heavy(arguments):
    shown, loaded = run_and_list(HEAVY, *arguments)
    assert "Usage: vidstyle" in shown and loaded == []


def test_a_film_loads_only_what_its_style_takes(tmp_path, capfd):
    film = media.make_clip(tmp_path / "film.mp4", size=(64, 48), frames=2)
    names = (*HEAVY, "importlib.metadata", "numpy.ma", "vidstyle.blocks.flow_dog", "vidstyle.blocks.halftone")
    for style, wanted in {
        "plain": {"av", "numpy"},
        "sketch": {"av", "cv2", "numpy", "vidstyle.blocks.flow_dog"},
    }.items():
        target = tmp_path / f"{style}.mp4"
        run(capfd, "render", film, target, "--style", style)  # compiles its kernels
        _, loaded = run_and_list(names, "render", film, target, "--style", style, "-y", "--progress", "none")
        assert set(loaded) == wanted


def test_help_has_one_line_for_each_command(capfd):
    _, out, _ = run(capfd, "--help")
    for name in ("blocks", "demo", "doctor", "render", "styles"):
        line = next(line for line in out.splitlines() if line.startswith(f"  {name} "))
        assert len(line.split()) > 3


def test_python_minus_m_is_the_program():
    ended = subprocess.run([sys.executable, "-m", "vidstyle", "--version"], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ended.stdout.startswith("vidstyle, version ")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["rendre"], "there is no command 'rendre'; did you mean 'render'?"),
        (["render", "a.mp4", "b.mp4", "--crf"], "--crf needs a value; see vidstyle"),
        (["render"], "INPUT is missing; see vidstyle render --help"),
        (["render", "a.mp4", "-s", "ink"], "OUTPUT is missing; see vidstyle render --help"),
        (["export", "ink"], "OUT is missing; see vidstyle export --help"),
        (["render", "a.mp4", "-i", "b.mp4", "c.mp4"], "'c.mp4'"),
        (["render", "a.mp4", "b.mp4"], "--style is missing; choose one of ascii, "),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--crf", "x"], "--crf: 'x' is not a number"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--crf", "64"], "--crf: 64 is outside 0 to 63"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--start", "-1"], "--start"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--start", "1:2:3:4"], "--start"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--size", "0x10"], "--size"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--size", "10"], "--size"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--fps", "0"], "--fps"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--fps", "30/0"], "--fps"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--frames", "0"], "--frames"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--compare", "wipe"], "--compare"),
        (["render", "a.mp4", "b.mp4", "--style", "plain", "--qqq"], "there is no option '--qqq'; see"),
        (["blocks", "posterise"], "posterize"),
    ],
)
def test_bad_usage_is_one_line_and_exit_2(capfd, arguments, words):
    exit_code, out, err = run(capfd, *arguments)
    assert (exit_code, out) == (2, "")
    assert err.startswith("vidstyle: ") and err.count("\n") == 1
    assert words in err


@pytest.mark.parametrize("words", ["-i {0} -o {1}", "{1} -i {0}", "-o {1} {0}", "{0} {1}"])
def test_paths_are_arguments_or_options(capfd, tmp_path, words):
    source, target = media.make_picture(tmp_path / "in.png"), tmp_path / "out.png"
    arguments = words.format(source, target).split()
    assert run(capfd, "render", "-s", "plain", *arguments)[0] == 0
    assert target.is_file()


def test_missing_folders_are_made_on_request_and_not_left_empty(capfd, tmp_path):
    source, folder = media.make_picture(tmp_path / "in.png"), tmp_path / "a" / "b"
    assert run(capfd, "render", "-s", "plain", source, folder / "out.png")[0] == 5
    exit_code, _, err = run(capfd, "render", "-s", "plain", source, f"{folder}/")
    assert (exit_code, err.count("\n")) == (5, 1)
    assert "b/ is not an existing folder; add --parents to create it" in err
    assert run(capfd, "render", "-s", "plain", "none.png", folder / "out.png", "--parents")[0] == 3
    assert not (tmp_path / "a").exists()
    assert run(capfd, "render", "-s", "plain", source, f"{folder}/", "--parents")[0] == 0
    assert [path.name for path in folder.iterdir()] == ["in.png"]


@pytest.mark.parametrize(
    ("arguments", "kinds"),
    [
        (["render", "film.mp4", "out.mp4", "-s", "plain"], ["notice", "progress", "summary"]),
        (["styles", "plain", "--preview", "film.mp4", "-o", "out.png"], ["progress", "summary"]),
        (["render", "none.mp4", "out.mp4", "-s", "ink"], ["error"]),
        (["render", "--bogus"], ["error"]),
        (["comic", "film.mp4", "out.gif"], ["error"]),
    ],
)
def test_with_progress_json_standard_error_holds_json_alone(capfd, tmp_path, monkeypatch, arguments, kinds):
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("film.mp4"), frames=3, size=(65, 49), pix_fmt="yuv444p")
    exit_code, _, err = run(capfd, *arguments, "--progress", "json")
    events = [json.loads(line) for line in err.splitlines()]
    assert [kind for kind, _ in groupby(event["event"] for event in events)] == kinds
    assert all(event["text"] for event in events if event["event"] != "progress")
    assert events[-1].get("exit_code", 0) == exit_code


def test_an_unknown_style_is_one_line_and_exit_3(capfd):
    exit_code, out, err = run(capfd, "render", "a.mp4", "b.mp4", "--style", "plian")
    assert (exit_code, out, err.count("\n")) == (3, "", 1)
    assert "plain" in err


def test_each_mistake_of_a_style_is_one_line(capfd, tmp_path):
    (tmp_path / "bad.toml").write_text("format = 1\ninc = 2\n\n[[lines]]\nblock = 'sobel'\ninvert = yes\n")
    exit_code, out, err = run(capfd, "styles", tmp_path / "bad.toml")
    assert (exit_code, out, err.count("\n")) == (3, "", 2)
    assert "bad.toml: line 6: yes is not a value; write invert = true\n" in err
    assert "bad.toml: line 2: 'inc' is not a field" in err


def test_a_bug_of_ours_is_one_line_unless_debugging(capfd, monkeypatch):
    def broken() -> None:
        raise RuntimeError("two\nlines")

    monkeypatch.setattr("vidstyle.style.style_names", broken)
    exit_code, _, err = run(capfd, "styles")
    assert (exit_code, err.count("\n")) == (1, 1)
    assert r"internal error: RuntimeError: two\nlines" in err and "--debug" in err
    exit_code, _, err = run(capfd, "styles", "--debug")
    assert exit_code == 1 and "Traceback" in err


def test_every_style_is_listed_and_described(capfd):
    _, out, _ = run(capfd, "styles")
    assert [line.split()[0] for line in out.splitlines()] == style_names()
    described = json.loads(run(capfd, "styles", "--json")[1])
    assert [style["name"] for style in described] == style_names()
    for name in style_names():
        exit_code, out, err = run(capfd, "styles", name)
        assert (exit_code, err) == (0, "") and out.startswith(name)
        assert json.loads(run(capfd, "styles", name, "--json")[1])["name"] == name


def test_a_broken_style_of_the_user_hides_no_other(capfd, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    (folder := tmp_path / "vidstyle" / "styles").mkdir(parents=True)
    (folder / "broken.toml").write_text("format = 2")
    exit_code, out, err = run(capfd, "styles")
    assert (exit_code, err.count("\n")) == (0, 1) and "broken.toml: line 1: format 2 is unknown" in err
    assert [line.split()[0] for line in out.splitlines()] == [n for n in style_names() if n != "broken"]


def test_the_schema_of_style_files_is_printed(capfd):
    schema = json.loads(run(capfd, "styles", "--schema")[1])
    assert schema["properties"]["format"] == {"const": 1}


def test_every_block_is_listed_with_all_that_can_be_set(capfd):
    _, out, _ = run(capfd, "blocks")
    listed = [line.split()[0] for line in out.splitlines() if "  " in line]  # others are headings
    assert sorted(listed) == sorted(all_blocks())
    described = {block["name"]: block for block in json.loads(run(capfd, "blocks", "--json")[1])}
    for name, block in all_blocks().items():
        _, out, _ = run(capfd, "blocks", name)
        assert block.help in out
        for parameter in block.parameters.values():
            assert f"  {parameter.name} = " in out and parameter.control.range_text in out
        assert set(described[name]["parameters"]) == set(block.parameters)


def test_devices_are_listed(capfd):
    exit_code, out, err = run(capfd, "render", "--list-devices")
    wanted = [str(device) + " (software)" * device.software for device in list_devices()]
    assert (exit_code, err, out.splitlines()) == (0, "", ["cpu", *wanted])


def test_the_doctor_names_what_bug_reports_need(capfd):
    exit_code, out, err = run(capfd, "doctor", "--json")
    assert (exit_code, err) == (0, "")
    facts = json.loads(out)
    assert facts["encoders"]["libx264"] == "works"
    assert facts["hdr encoders"]["libx265"] == facts["hdr encoders"]["libsvtav1"] == "HDR10, HLG"
    assert "libx264" not in facts["hdr encoders"]
    assert facts["encoders"]["h264_nvenc"] != "works" or Path("/dev/nvidiactl").exists()
    assert facts["libraries"]["av"][0].isdigit() and facts["ffmpeg"][0].isdigit()
    exit_code, out, _ = run(capfd, "doctor")
    assert exit_code == 0
    for name in facts:
        assert f"\n{name} " in f"\n{out}"


def test_a_closed_standard_output_is_no_traceback():
    command = '"$0" -m vidstyle styles --schema | true; exit ${PIPESTATUS[0]}'
    ended = subprocess.run(["bash", "-c", command, sys.executable], capture_output=True, text=True)
    assert ended.returncode in (0, 5)
    assert ended.stderr.count("\n") <= 1 and "bug" not in ended.stderr and "Exception" not in ended.stderr
