"""`vidstyle explore -o FOLDER`: style files, a sheet and a table, the same for the same seed."""

from __future__ import annotations

import json
from pathlib import Path
from threading import Event

import cv2
import pytest
from click.testing import CliRunner
from face_network import brightness_judge
from skimage import data

from vidstyle.cli import commands, main
from vidstyle.errors import InputError
from vidstyle.explore.crops.full_size import FullSize
from vidstyle.explore.generate import random_style
from vidstyle.explore.write_styles import PAGE_FILE, SHEET_FILE, TABLE_FILE, explore_to_folder
from vidstyle.style import load_style


@pytest.fixture(scope="module")
def photograph(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("explore") / "cat.png"
    cv2.imwrite(str(path), cv2.resize(data.chelsea(), (192, 128))[..., ::-1])
    return path


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_same_seed_same_bytes_on_any_number_of_cores(
    photograph: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    explore_to_folder(photograph, tmp_path / "one", count=2, seed=7)
    monkeypatch.setenv("VIDSTYLE_THREADS", "1")
    explore_to_folder(photograph, tmp_path / "two", count=2, seed=7)
    one = files(tmp_path / "one")
    assert one == files(tmp_path / "two")
    styles = [name for name in one if name.endswith(".toml")]
    assert len(styles) == 2 and {PAGE_FILE, SHEET_FILE, TABLE_FILE} < one.keys()
    table = json.loads(one[TABLE_FILE])
    assert [row["file"] for row in table["styles"]] != [] and table["passed"] == 2
    assert table["tried"] == table["passed"] + sum(table["discarded"].values())
    for row in table["styles"]:
        style = load_style(tmp_path / "one" / row["file"])
        assert style.name == row["name"] and "open rules, seed 7-" in style.note
        assert 0 <= row["score"] <= 1


def test_styles_are_judged_at_full_size(tmp_path: Path) -> None:
    picture = cv2.resize(data.chelsea(), (1500, 1000), interpolation=cv2.INTER_CUBIC)
    cv2.imwrite(str(tmp_path / "cat.png"), picture[..., ::-1])
    (found,) = explore_to_folder(tmp_path / "cat.png", tmp_path / "looks", 1, seed=7, tries=8).chosen
    measured = FullSize(picture).measure(random_style(found.style.name.removeprefix("open-")))
    assert found.full_size == pytest.approx(measured, abs=1e-6)


def test_the_best_of_many_are_chosen(photograph: Path, tmp_path: Path) -> None:
    found = explore_to_folder(photograph, tmp_path / "best", count=1, seed=7, tries=10)
    assert found.tried == 10 and len(found.chosen) == 1


def test_judge_ranks(photograph: Path, tmp_path: Path) -> None:
    (tmp_path / "judge.onnx").write_bytes(brightness_judge(10))
    found = explore_to_folder(photograph, tmp_path / "judged", 2, seed=7, judge=tmp_path / "judge.onnx")
    scores = [each.score for each in found.chosen]
    assert scores[0] == max(scores) and 1 <= min(scores)
    assert json.loads((tmp_path / "judged" / TABLE_FILE).read_text())["judge"] == "judge.onnx"


def test_a_stopped_search_keeps_what_is_there(photograph: Path, tmp_path: Path) -> None:
    stop = Event()

    def watch(step: str, done: float, total: float) -> None:
        if done == 1:
            stop.set()

    found = explore_to_folder(photograph, tmp_path / "stopped", 200, seed=7, on_step=watch, stop=stop)
    assert len(found.chosen) == 1 and (tmp_path / "stopped" / f"{found.chosen[0].style.name}.toml").is_file()


def test_a_picture_of_nothing_is_refused_in_a_line(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "black.png"), data.chelsea() * 0)
    with pytest.raises(InputError, match="no style passed of 4 candidates"):
        explore_to_folder(tmp_path / "black.png", tmp_path / "none", 1, seed=1, tries=4)
    assert not (tmp_path / "none").exists()


def test_command_reports_and_refuses(
    photograph: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["explore", str(photograph), "--count", "1", "--seed", "7", "-o"]
    assert main([*words, str(tmp_path / "new"), "--progress", "json"]) == 0
    lines = [json.loads(line) for line in capfd.readouterr().err.splitlines()]
    assert lines[-1]["event"] == "summary" and lines[-1]["styles"] == 1
    assert main([*words, str(tmp_path / "new")]) == 2
    assert "is not empty; add -y" in capfd.readouterr().err
    assert main([*words, str(tmp_path / "no" / "where")]) == 5


def test_help_names_the_options() -> None:
    text = CliRunner().invoke(commands, ["explore", "--help"]).output
    assert all(option in text for option in ("--count", "--seed", "--rules", "--judge", "--tries"))
