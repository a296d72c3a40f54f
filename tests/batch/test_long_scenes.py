"""A film that is one long scene, in a batch: segments that do not continue each other are made again."""

from __future__ import annotations

import json
import os
import threading
from fractions import Fraction
from pathlib import Path
from typing import Any

import faults
import media
import pytest

from vidstyle import cli
from vidstyle.batch.batch_film import BatchFilm
from vidstyle.batch.division import LOCK_NAME, Division
from vidstyle.batch.inputs import Source
from vidstyle.batch.journal import Journal
from vidstyle.batch.processes import Outcome
from vidstyle.errors import OutputError
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.pipeline import segment_borders
from vidstyle.pipeline.render import render
from vidstyle.pipeline.scene_memory import memory_path
from vidstyle.pipeline.segments import PLAN_NAME, SegmentedFilm
from vidstyle.style import load_style

STYLE = {"format": 1, "name": "settled", "steady": 0.5, "background": [{"block": "minimum_range"}]}
LOSSLESS = WriteOptions(codec="ffv1")


class InThisProcess:
    """Does what the processes of a batch do; each segment begins without a memory at first.

    Attributes:
        made: ranges in the order in which they were made.
    """

    def __init__(self, source: Path, target: Path, scratch: Path) -> None:
        self._film = SegmentedFilm(
            source, target, scratch, load_style(STYLE), ReadOptions(), LOSSLESS, "cpu", None, {}
        )
        self.made: list[str] = []

    def run(self, words: list[str], follow: Any) -> Outcome:
        stop = threading.Event()
        ranges = [word.partition("=")[2] for word in words if word.startswith("--range=")]
        if "--join" in words:
            self._film.join(False, stop)
        for name in ranges:
            self._make(name, stop)
        if any(word.startswith("--every") for word in words):
            self._film.plan(Fraction(1, 2), lambda progress: None, stop)
        return Outcome(0, "", {})

    def _make(self, name: str, stop: threading.Event) -> None:
        hidden = [] if name in self.made else list(self._film.folder.glob("*.memory"))
        for path in hidden:
            path.rename(path.with_suffix(".hidden"))
        self._film.render(name, lambda progress: None, stop)
        for path in hidden:
            path.with_suffix(".hidden").rename(path)
        self.made.append(name)


@pytest.fixture
def division(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Division, InThisProcess]:
    """A scene of four segments, whose warm-ups are too short."""
    monkeypatch.setattr(segment_borders, "MIN_PART_SECONDS", 1)
    monkeypatch.setattr(segment_borders, "MIN_PART_RATIO", 0)
    monkeypatch.setattr(segment_borders, "WARM_UP_FRAMES", 3)
    monkeypatch.setattr(segment_borders, "WARM_UP_FACTOR", 0)
    source = media.make_clip(tmp_path / "a.mp4", size=(96, 54), frames=100, audio_tracks=1)
    film = BatchFilm(Source(source, ""), "own", tmp_path / "b.mkv", {}, Journal(tmp_path))
    divided = Division(film, {}, "0.5", 1)
    return divided, InThisProcess(source, film.target, divided.scratch)


def pictures(path: Path) -> list[tuple[float, bytes]]:
    return [
        (float(frame.pts * frame.time_base), frame.to_ndarray().tobytes()) for frame in faults.video(path)
    ]


def in_one_run(source: Path) -> list[tuple[float, bytes]]:
    whole = source.with_name("whole.mkv")
    render(source, whole, load_style(STYLE), write=LOSSLESS, device="cpu")
    return pictures(whole)


def test_segments_are_made_again_until_each_continues_the_one_before(
    tmp_path: Path, division: tuple[Division, InThisProcess]
) -> None:
    divided, processes = division
    with divided.locked():
        outcome = divided.make([], processes.run)
        assert outcome is not None and outcome.exit_code == 0
        assert sorted(path.suffix for path in divided.scratch.iterdir() if path.name != LOCK_NAME) == [
            ".json", *[".segment"] * 4,
        ]  # fmt: skip
    first, *others = ["0:30", "30:60", "60:90", "90:100"]
    assert processes.made == [first, *others, *others]
    assert pictures(tmp_path / "b.mkv") == in_one_run(tmp_path / "a.mp4")


def test_a_lost_memory_is_made_again(tmp_path: Path, division: tuple[Division, InThisProcess]) -> None:
    divided, processes = division
    with divided.locked():
        divided.prepare([], processes.run)
        for segment in divided.missing_segments():
            processes.run(divided.segment_words([], segment), None)
        memory_path(divided.scratch / "0-30.segment").unlink()
        assert [each.name for each in divided.missing_segments()] == ["0:30"]
        divided.make([], processes.run)
    assert processes.made.count("0:30") == 2
    assert pictures(tmp_path / "b.mkv") == in_one_run(tmp_path / "a.mp4")


@pytest.mark.skipif(os.name != "posix", reason="Windows has no such owners")
@pytest.mark.parametrize("is_link", [False, True])
def test_segments_of_somebody_else_are_not_used(
    tmp_path: Path, division: tuple[Division, InThisProcess], monkeypatch: pytest.MonkeyPatch, is_link: bool
) -> None:
    divided, _ = division
    if is_link:
        (tmp_path / "mine").mkdir()
        divided.scratch.symlink_to(tmp_path / "mine")
    else:
        divided.scratch.mkdir()
        owner = os.geteuid()
        monkeypatch.setattr(os, "geteuid", lambda: owner + 1)
    with (
        pytest.raises(OutputError, match="was not created by vidstyle batch for this user"),
        divided.locked(),
    ):
        pass
    assert not list(tmp_path.glob("mine/*"))


def test_a_long_scene_is_made_by_several_processes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the real lengths: four frames a second make a film of seconds a long one."""
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("a.mp4"), size=(64, 36), rate=4, frames=640, audio_tracks=1)
    Path("own.toml").write_text('format = 1\nsteady = 0.5\n[[background]]\nblock = "minimum_range"\n')
    words = ["batch", "a.mp4", "-s", "own.toml", "--codec", "ffv1", "-d", "cpu", "--progress", "none"]
    assert cli.main([*words, "-o", "b.mkv", "--segment", "30", "-j", "2"]) == 0
    assert cli.main([*words, "-o", "c.mkv"]) == 0
    assert pictures(Path("b.mkv")) == pictures(Path("c.mkv"))
    assert faults.packets(Path("b.mkv"), "audio") == faults.packets(Path("c.mkv"), "audio")
    assert not list(Path().glob(".b.mkv.segments-*"))


def test_the_plan_of_a_long_scene_has_parts(tmp_path: Path) -> None:
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), rate=4, frames=640)
    words = ["segment", str(source), str(tmp_path / "b.mkv"), "-s", "sketch", "-d", "cpu", "--every", "30"]
    assert cli.main([*words, "--scratch", str(tmp_path), "--progress", "none"]) == 0
    plan = json.loads((tmp_path / PLAN_NAME).read_text())
    parts = [(each["first"], each["end"], each["before_pts"]) for each in plan["segments"]]
    assert [part[:2] for part in parts] == [(0, 608), (608, 640)] and parts[1][2] is not None


@pytest.mark.parametrize("ending", ["gif", "png"])
def test_pictures_are_made_in_one_piece(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str) -> None:
    monkeypatch.chdir(tmp_path)
    frames = 1 if ending == "png" else 20
    media.make_clip(Path("a.mp4"), size=(64, 36), frames=frames, scene_frames=5)
    words = [
        "batch",
        "a.mp4",
        "-s",
        "plain",
        "-o",
        f"out/a.{ending}",
        "--segment",
        "0.1",
        "--progress",
        "none",
    ]
    assert cli.main(words) == 0
    assert sorted(path.name for path in Path("out").glob("*a.*")) == [f"a.{ending}"]


def test_nothing_is_left_of_a_film_that_cannot_be_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.mp4").write_bytes(b"")
    media.make_clip(Path("b.mp4"), size=(64, 36), frames=4)
    words = ["-s", "plain", "-o", "out/{name}.png", "--segment", "1", "--progress", "none"]
    assert cli.main(["batch", "a.mp4", "b.mp4", *words]) == 3
    assert not list(Path("out").glob(".*segments*"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-o", "out"), "out is not a folder and has no extension; write 'out/' for a folder, or 'out.mp4'"),
        (("-o", "out/{name}"), "out/{name} is not a folder"),
        (("-o", "out/", "--segment", "0"), "--segment: 0 is not a length"),
    ],
)
def test_wrong_options_name_the_remedy(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("a.mp4"), size=(64, 36), frames=2)
    assert cli.main(["batch", "a.mp4", "-s", "plain", *words]) == 2
    assert message in capfd.readouterr().err


def test_a_film_without_segments_refuses_single_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    media.make_picture(Path("a.png"))
    words = ["segment", "a.png", "b.mp4", "-s", "plain"]
    assert cli.main([*words, "--every", "1"]) == 0
    assert capfd.readouterr().out == "[]\n"
    for step in (["--range", "0:1"], ["--join"]):
        assert cli.main([*words, *step]) == 2
        assert "a.png has no segments: it is a picture; use 'vidstyle render'" in capfd.readouterr().err
    assert cli.main([*words, "--every", "0"]) == 2
    assert "--every: 0 is not a length" in capfd.readouterr().err
