"""Lists, journals, folders and names of a batch that an attacker has prepared."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import media
import pytest

from vidstyle import cli
from vidstyle.batch.division import SCRATCH_MARK
from vidstyle.batch.journal import JOURNAL, Journal
from vidstyle.batch.scratch import LOCK_NAME, OWNER
from vidstyle.pipeline.segments import PLAN_NAME

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pipes with names")
NAMES = [
    "a'b.mp4",
    'a"b.mp4',
    "$(touch pwned).mp4",
    "`touch pwned`.mp4",
    "; touch pwned #.mp4",
    "-y.mp4",
    "a\rb.mp4",
]
STANDS_FOR_VIDSTYLE = '#!/bin/sh\nfor word; do printf "%s\\n" "$word"; done >> words\n'


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("a.mp4"), size=(64, 48), frames=40, scene_frames=20)
    return tmp_path


def batch(capfd: pytest.CaptureFixture[str], *words: str) -> tuple[int, list[dict[str, Any]]]:
    capfd.readouterr()
    code = cli.main(["batch", "-s", "plain", "-o", "out/{name}.mp4", "--json", "--progress", "plain", *words])
    out = capfd.readouterr().out
    return code, json.loads(out)["films"] if out else []


def snapshot(*places: str) -> dict[str, bytes]:
    """The content of all files, and where links lead."""
    paths = [path for place in places for path in (Path(place), *Path(place).rglob("*"))]
    files = [path for path in paths if path.is_symlink() or not path.is_dir()]
    return {
        str(path): os.readlink(path).encode() if path.is_symlink() else path.read_bytes() for path in files
    }


@pytest.mark.parametrize("name", ["list.txt", "a.mkv"])
@pytest.mark.parametrize("make", [os.mkfifo, lambda name: os.symlink("/dev/zero", name)])
def test_inputs_that_never_end_are_refused(capfd, name: str, make: Callable[[str], None]) -> None:
    make(name)
    code, films = batch(capfd, name)
    assert code == 3 and "is not a file" in films[0]["reason"]


def test_a_list_that_names_itself_ends(capfd) -> None:
    Path("list.txt").write_text("list.txt\na.mp4\n")
    code, films = batch(capfd, "list.txt")
    assert code == 3 and [film["state"] for film in films] == ["failed", "done"]


@pytest.mark.parametrize("make", [os.mkfifo, os.mkdir, lambda name: os.symlink("../mine", name)])
def test_a_journal_that_is_no_file_is_left_alone(capfd, make: Callable[[str], None]) -> None:
    Path("mine").write_text("mine")
    Path("out").mkdir()
    make(f"out/{JOURNAL}")
    code, films = batch(capfd, "a.mp4")
    assert code == 5 and JOURNAL in films[0]["reason"]
    assert Path("mine").read_text() == "mine" and os.listdir("out") == [JOURNAL]


@pytest.mark.parametrize(
    "entry",
    [
        {"target": "a.mp4", "parts": 7},
        {"target": "a.mp4", "parts": []},
        {"target": "a.mp4", "parts": {}, "begun": "now", "result": None, "source file": {}},
        {"target": ["a.mp4"], "parts": {}},
        [],
        {},
    ],
)
def test_entries_of_other_types_do_not_count(capfd, entry: object) -> None:
    Path("out").mkdir()
    damaged = f"{json.dumps(entry)}\n\0\xff{{\n{'[' * 10**5}\n"
    Path("out", JOURNAL).write_text(damaged)
    code, films = batch(capfd, "a.mp4")
    assert code == 5 and "is not a journal of a batch" in films[0]["reason"]
    assert Path("out", JOURNAL).read_text() == damaged
    Path("out", JOURNAL).write_text(f'{{"target": "b.mp4", "parts": {{}}}}\n{damaged}')
    assert batch(capfd, "a.mp4")[0] == 0
    assert [film["state"] for film in batch(capfd, "a.mp4")[1]] == ["skipped"]
    Path("out/a.mp4").write_text("mine")
    code, films = batch(capfd, "a.mp4")
    assert code == 2 and "already exists" in films[0]["reason"] and Path("out/a.mp4").read_text() == "mine"


def test_a_journal_that_another_batch_begins_is_one(folder: Path) -> None:
    for round_number in range(100):
        (place := folder / str(round_number)).mkdir()
        together = Barrier(4)

        def begin(number: int, place: Path = place, together: Barrier = together) -> None:
            together.wait()
            Journal(place).begin(place / f"{number}.mp4", {"source": "a" * 5000})

        with ThreadPoolExecutor(4) as pool:
            list(pool.map(begin, range(4)))
        assert len(Journal(place).names()) == 4


def scratch() -> Path:
    """The folder that a batch will take for its segments."""
    cli.main(["batch", "a.mp4", "-s", "plain", "-o", "out/{name}.mp4", "--segment", "0.5", "--emit", "shell"])
    (found,) = Path("out").glob(f".a.mp4{SCRATCH_MARK}*")
    for path in found.iterdir():
        path.unlink()
    found.rmdir()
    return found


def plant_link(place: Path) -> None:
    place.symlink_to("../mine")


def plant_folder(place: Path) -> None:
    place.mkdir()
    for name in (LOCK_NAME, PLAN_NAME, "a.mp4", "diary.txt", "0-20.segment"):
        (place / name).write_text("mine")


def plant_link_as_lock(place: Path) -> None:
    place.mkdir()
    (place / LOCK_NAME).symlink_to("../../mine/lock")


@pytest.mark.parametrize("plant", [plant_link, plant_folder, plant_link_as_lock])
def test_folders_of_others_are_neither_used_nor_removed(capfd, plant: Callable[[Path], None]) -> None:
    Path("mine").mkdir()
    for name in (PLAN_NAME, "a.mp4", "diary.txt"):
        Path("mine", name).write_text("mine")
    Path("mine", LOCK_NAME).write_bytes(OWNER)
    place = scratch()
    plant(place)
    plant(other := place.with_name(f".a.mp4{SCRATCH_MARK}mine"))
    before = snapshot("mine", str(place), str(other))
    code, films = batch(capfd, "a.mp4", "--segment", "0.5")
    assert code == 5 and "was not created by vidstyle batch" in films[0]["reason"]
    (place.unlink if place.is_symlink() else lambda: place.rename("kept"))()
    assert batch(capfd, "a.mp4", "--segment", "0.5")[0] == 0
    for name, content in snapshot("mine", str(other)).items():
        assert before[name] == content


def test_a_damaged_plan_is_made_again(capfd) -> None:
    cli.main(["batch", "a.mp4", "-s", "plain", "-o", "out/{name}.mp4", "--segment", "0.5", "--emit", "shell"])
    (plan,) = Path("out").glob(f".a.mp4{SCRATCH_MARK}*/{PLAN_NAME}")
    plan.write_text('{"segments": [{}]}')
    assert batch(capfd, "a.mp4", "--segment", "0.5")[0] == 0
    assert sorted(os.listdir("out")) == [JOURNAL, "a.mp4"]


def test_segment_keeps_files_of_the_names_that_it_uses(capfd) -> None:
    Path("mine").mkdir()
    words = ["segment", "a.mp4", "out/a.mp4", "-s", "plain", "--threads", "1"]
    Path("out").mkdir()
    Path("out/.a.mp4.segments").symlink_to("../mine")
    assert cli.main([*words, "--every", "0.5"]) == 2 and "is a link" in capfd.readouterr().err
    Path("mine/a.mp4").write_text("mine")
    words += ["--scratch", "mine"]
    assert cli.main([*words, "--every", "0.5"]) == 0
    names = json.loads(capfd.readouterr().out)
    assert cli.main([*words, "--join"]) == 2 and "--range" in capfd.readouterr().err
    assert [cli.main([*words, "--range", name]) for name in names] == [0] * len(names)
    assert cli.main([*words, "--join"]) == 0
    assert Path("mine/a.mp4").read_text() == "mine" and Path("out/a.mp4").exists()


@pytest.mark.parametrize("manager", ["shell", "slurm", "openjd"])
def test_names_are_words_and_not_commands(capfd, folder: Path, manager: str) -> None:
    Path("in").mkdir()
    for name in NAMES:
        Path("in", name).write_bytes(Path("a.mp4").read_bytes())
    capfd.readouterr()
    output = "out $(touch pwned) ' \" ;/{name}.mkv"
    assert cli.main(["batch", "in", "-s", "plain", "-o", output, "--emit", manager]) == 0
    job = capfd.readouterr().out
    for name, text in {
        "vidstyle": STANDS_FOR_VIDSTYLE,
        "sbatch": "#!/bin/sh\ncat > script\necho 1\n",
    }.items():
        Path(name).write_text(text)
        Path(name).chmod(0o700)
    environment = {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}
    script = json.loads(job)["steps"][0]["script"]["embeddedFiles"][0]["data"] if manager == "openjd" else job
    subprocess.run(["sh"], input=script.encode(), env=environment, check=True)
    for number in range(len(NAMES)) if manager != "shell" else ():
        case = ["sh", "script"] if manager == "slurm" else ["sh", "-c", script, "sh", str(number)]
        subprocess.run(case, env={**environment, "SLURM_ARRAY_TASK_ID": str(number)}, check=True)
    words = Path("words").read_bytes().decode().split("\n")
    assert not list(Path().rglob("pwned"))
    for name in NAMES:
        assert str(folder / "in" / name) in words
        assert f"--output={folder}/{output.partition('{')[0]}{name[:-4]}.mkv" in words


@pytest.mark.parametrize("name", ["a\nb.mp4", "{{Task.File.Commands}}.mp4"])
def test_names_that_a_job_cannot_hold_are_refused(capfd, name: str) -> None:
    Path("a.mp4").rename(name)
    assert cli.main(["batch", ".", "-s", "plain", "-o", "out/{name}.mkv", "--emit", "shell"]) == 2
    assert "rename the film" in capfd.readouterr().err
