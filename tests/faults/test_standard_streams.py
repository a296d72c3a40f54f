"""Standard input, output and error that are closed, full or abandoned by their reader."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from media import make_clip
from waiting import LONG

FOLDER = Path(__file__).parents[2]
RENDER = ("render", "--style", "plain", "-y", "--progress", "none")


def program(*arguments: str | Path, redirect: str = "", **pipes: int) -> subprocess.Popen[bytes]:
    """The program in a bare environment: PYTHONUNBUFFERED, for one, hides what a buffer does at the end."""
    command = [sys.executable, "-m", "vidstyle", *map(str, arguments)]
    environment = {name: os.environ[name] for name in ("PATH", "HOME") if name in os.environ}
    shell = ["sh", "-c", f'exec "$@" {redirect}', "sh", *command]
    return subprocess.Popen(shell, cwd=FOLDER, env=environment | {"LANG": "C.UTF-8"}, **pipes)


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_clip(tmp_path_factory.mktemp("clip") / "in.mp4", frames=40, size=(320, 180))


UNREADABLE = "standard input: not a readable video; raw video needs --input-size"


@pytest.mark.parametrize(
    ("arguments", "redirect", "exit_code", "said"),
    [
        (["blocks"], ">/dev/full", 5, "standard output cannot be written: the disk is full"),
        (["styles", "--schema"], ">/dev/full", 5, "standard output cannot be written: the disk is full"),
        (["blocks"], ">&-", 5, "standard output cannot be written: it is closed"),
        (["blocks"], "2>&- >/dev/null", 0, ""),
        (["blocks", "--wrong"], "2>/dev/full", 2, ""),
        (
            [*RENDER, "-", "out.mp4"],
            "<&-",
            3,
            "standard input: not a readable video; raw video needs --input-size",
        ),
    ],
)
def test_closed_and_full_streams(
    arguments: list[str], redirect: str, exit_code: int, said: str, tmp_path: Path
) -> None:
    arguments = [str(tmp_path / "out.mp4") if each == "out.mp4" else each for each in arguments]
    with program(*arguments, redirect=redirect, stderr=subprocess.PIPE) as process:
        _, error = process.communicate(timeout=LONG)
    assert (process.returncode, error.decode()) == (exit_code, f"vidstyle: {said}\n" if said else "")


@pytest.mark.parametrize("command", [["--help"], ["styles", "--schema"], ["styles", "ink"]])
def test_a_reader_that_leaves_at_once(command: list[str]) -> None:
    read, write = os.pipe()
    os.close(read)
    with program(*command, stdout=write, stderr=subprocess.PIPE) as process:
        os.close(write)
        assert b"Exception" not in process.communicate(timeout=LONG)[1]
    assert process.returncode == 5


def test_a_film_goes_on_when_nobody_reads_its_messages(clip: Path, tmp_path: Path) -> None:
    read, write = os.pipe()
    os.close(read)
    process = program(*RENDER, clip, tmp_path / "out.mp4", stdout=write, stderr=write)
    os.close(write)
    process.communicate(timeout=LONG)
    assert process.returncode == 0
    assert [path.name for path in tmp_path.iterdir()] == ["out.mp4"]


def test_messages_never_end_up_in_a_film(clip: Path, tmp_path: Path) -> None:
    """Where standard error is closed, the first file that is opened would take its number."""
    for name, redirect in (("a.mp4", ""), ("b.mp4", "<&- >&- 2>&-")):
        program(*RENDER, clip, tmp_path / name, redirect=redirect, stderr=subprocess.DEVNULL).communicate()
    assert (tmp_path / "a.mp4").read_bytes() == (tmp_path / "b.mp4").read_bytes()


def test_a_film_to_a_reader_that_leaves(clip: Path) -> None:
    command = (*RENDER, "--format", "y4m", clip, "-")
    for _ in range(3):
        with program(*command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
            assert process.stdout is not None and process.stderr is not None
            process.stdout.read(1000)
            process.stdout.close()
            error = process.stderr.read()
        assert process.returncode == 5
        assert error.count(b"\n") >= 1 and b"Exception" not in error and b"bug" not in error


ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0", "PYTHONIOENCODING": "ascii"}


def ascii_run(*arguments: str | Path) -> subprocess.CompletedProcess[bytes]:
    """The program in a locale without UTF-8."""
    command = [sys.executable, "-m", "vidstyle", *map(str, arguments)]
    return subprocess.run(command, cwd=FOLDER, env=os.environ | ASCII, capture_output=True, timeout=LONG)


@pytest.mark.skipif(
    not (sys.prefix + __file__).isascii(),
    reason="Python cannot start there: it reads .pth files in the encoding of the locale",
)
@pytest.mark.parametrize("name", ["\u00e4.mp4", "\udcff.mp4"])
def test_names_and_texts_in_an_ascii_locale(clip: Path, tmp_path: Path, name: str) -> None:
    source, target = tmp_path / name, tmp_path / f"o{name}"
    source.write_bytes(clip.read_bytes())
    done = ascii_run(*RENDER, source, target)
    assert (done.returncode, done.stderr) == (0, b"") and target.stat().st_size
    missing = ascii_run(*RENDER, tmp_path / f"x{name}", target)
    assert missing.returncode == 3 and missing.stderr.count(b"\n") == 1 and missing.stderr.isascii()
    style = tmp_path / "style.toml"
    style.write_text('format = 1\nname = "\u00d6l"\n[[background]]\nblock = "post\u00e4"\n', "utf-8")
    wrong = ascii_run("styles", style)
    assert wrong.returncode == 3 and rb"'post\xe4' is not a block" in wrong.stderr
    style.write_text('format = 1\nname = "\u00d6l"\nnote = "\u00d6l."\n', "utf-8")
    assert ascii_run("styles", style).returncode == 0
    hook = target.with_suffix(".hook")
    exported = ascii_run("export", style, hook)
    assert exported.returncode == 0 and hook.read_text("utf-8"), exported.stderr
    comic = ascii_run(
        "comic", clip, target.with_suffix(".svg"), "--title", "\u00c9t\u00e9", "--style", "plain"
    )
    assert comic.returncode == 0, comic.stderr
    assert "\u00c9T\u00c9" in target.with_suffix(".svg").read_text("utf-8").upper()
