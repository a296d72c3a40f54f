"""Batches with real processes: skipping, failing, continuing after a kill."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import media
import psutil
import pytest
from waiting import eventually

from vidstyle import cli
from vidstyle.batch.journal import JOURNAL
from vidstyle.media.write.resume_source import count_frames

TEMPLATE = "out/{name}.mp4"
LONG_FRAMES = 400
"""Frames of a film that takes long enough to be interrupted."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def make_films(*names: str, frames: int = 5) -> None:
    Path("in").mkdir(exist_ok=True)
    for number, name in enumerate(names):
        media.make_clip(Path("in") / name, size=(64, 48), frames=frames + number, audio_tracks=1)


def make_long_film(name: str) -> None:
    media.make_clip(Path(name), frames=LONG_FRAMES)


def batch(capfd: pytest.CaptureFixture[str], *words: str) -> tuple[int, list[dict[str, Any]], str]:
    """Exit code, films of the summary, standard error."""
    capfd.readouterr()
    line = ["batch", "-s", "plain", "-o", TEMPLATE, "--json", "--progress", "plain", *words]
    code = cli.main(line)
    out, err = capfd.readouterr()
    return code, json.loads(out)["films"] if out else [], err


def states(films: list[dict[str, Any]]) -> list[str]:
    return [film["state"] for film in films]


def start(*words: str, **options: Any) -> subprocess.Popen[str]:
    """The program, in the background."""
    line = [sys.executable, "-m", "vidstyle", "batch", "-o", TEMPLATE, "--json", *words]
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def left_over() -> list[str]:
    """The files in the folder of the results that are no results."""
    return sorted(path.name for path in Path("out").iterdir() if path.suffix != ".mp4" or "." in path.stem)


def test_a_film_that_fails_is_named_and_finished_ones_are_skipped(capfd: pytest.CaptureFixture[str]) -> None:
    make_films("a.mp4", "b.mkv")
    Path("in/bad.mp4").write_text("no film")
    Path("out").mkdir()
    Path("out/neighbour.mp4").write_text("mine")
    code, films, err = batch(capfd, "in", "-j", "2")
    assert (code, states(films)) == (3, ["done", "done", "failed"])
    assert [film["frames"] for film in films[:2]] == [5, 6]
    assert err.count("in/bad.mp4: not a readable video") == 1
    assert left_over() == [JOURNAL] and Path("out/neighbour.mp4").read_text() == "mine"
    os.utime("in/a.mp4", (1, 1))  # the content decides
    Path("in/bad.mp4").unlink()
    code, films, _ = batch(capfd, "in/*", "--crf", "23")
    assert (code, states(films)) == (2, ["failed", "failed"])
    assert "already exists, made with another crf; add -y to replace it" in films[0]["reason"]
    code, films, _ = batch(capfd, "in")
    assert (code, states(films)) == (0, ["skipped", "skipped"])
    media.make_clip(Path("in/a.mp4"), size=(64, 48), frames=9)
    code, films, _ = batch(capfd, "in", "--dry-run")
    assert (code, states(films)) == (2, ["failed", "skipped"])
    assert "made with another source" in films[0]["reason"]
    code, films, _ = batch(capfd, "in", "-y")
    assert (code, states(films)) == (0, ["done", "skipped"])
    assert len(media.read_all(Path("out/a.mp4"))) == 9


def test_options_of_render_apply_to_each_film(capfd: pytest.CaptureFixture[str]) -> None:
    make_films("a.mp4")
    words = ("in", "--size", "32x-2", "--frames", "3", "--audio", "none", "--threads", "1")
    assert batch(capfd, *words)[0] == 0
    assert [(frame.width, frame.height) for frame in media.read_all(Path("out/a.mp4"))] == [(32, 24)] * 3


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("-s", "ink"), "INPUT is missing"),
        (("in", "--style", "none"), "none"),
        (("in", "--start", "3", "--end", "2"), "--end: 2 s is not after the start"),
        (("in", "--csv"), "--csv: contradicts --json"),
        (("--watch", "nowhere"), "--watch: nowhere is not a folder"),
        (("in", "--format", "nut"), "there is no option '--format'"),
    ],
)
def test_wrong_options_are_refused_before_work(
    capfd: pytest.CaptureFixture[str], words: tuple[str, ...], message: str
) -> None:
    Path("in").mkdir()
    Path("in/a.mp4").touch()
    code, _, err = batch(capfd, *words)
    assert code in (2, 3) and err.count("\n") == 1 and message in err
    assert not Path("out").exists()


def test_render_leads_to_batch(capfd: pytest.CaptureFixture[str]) -> None:
    Path("in").mkdir()
    for name in ("in/a.mp4", "in/b.mp4"):
        Path(name).touch()
    for words, code in ((["in"], 3), (["in/*.mp4"], 2), (["in/a.mp4", "in/b.mp4"], 2)):
        assert cli.main(["render", *words, "out.mp4", "-s", "plain"]) == code
        err = capfd.readouterr().err
        assert "'vidstyle batch'" in err and err.count("\n") == 1


def test_a_killed_batch_leaves_no_process_and_is_continued(capfd: pytest.CaptureFixture[str]) -> None:
    make_films("a.mp4")
    make_long_film("in/b.mp4")
    driver = start("in", "-s", "oil", "-j", "2")
    eventually(lambda: Path("out/a.mp4").exists() and Path("out/b.partial.mp4").exists())
    workers = psutil.Process(driver.pid).children(recursive=True)
    driver.kill()
    driver.communicate()
    assert workers
    psutil.wait_procs(workers, 60)
    assert not any(worker.is_running() for worker in workers)
    made = Path("out/a.mp4").stat().st_mtime_ns
    again = start("in", "-s", "oil", "-j", "2")
    out, err = again.communicate()
    assert again.returncode == 0, err
    assert states(json.loads(out)["films"])[1] == "done"
    assert Path("out/a.mp4").stat().st_mtime_ns == made
    assert len(media.read_all(Path("out/b.mp4"))) == LONG_FRAMES and left_over() == [JOURNAL]


def test_two_batches_share_the_work(capfd: pytest.CaptureFixture[str]) -> None:
    make_films("a.mp4", "b.mp4", "c.mp4")
    both = [start("in", "-s", "plain", "-j", "1") for _ in range(2)]
    films = []
    for each in both:
        out, err = each.communicate()
        assert each.returncode == 0, err
        films.append(states(json.loads(out)["films"]))
    assert all({*pair} <= {"done", "skipped"} and "done" in pair for pair in zip(*films, strict=True))
    assert left_over() == [JOURNAL]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
def test_a_killed_process_is_named_and_tried_again() -> None:
    make_long_film("a.mp4")
    driver = start("a.mp4", "-s", "oil", "--retry", "1")
    eventually(lambda: Path("out/a.partial.mp4").exists())
    for worker in psutil.Process(driver.pid).children():
        worker.send_signal(signal.SIGKILL)
    out, err = driver.communicate()
    film = json.loads(out)["films"][0]
    assert (driver.returncode, film["state"], film["attempts"]) == (0, "done", 2), err
    assert len(media.read_all(Path("out/a.mp4"))) == LONG_FRAMES


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such limit")
def test_a_full_disk_fails_one_film_and_not_the_other() -> None:
    import resource

    make_films("a.mp4")
    media.make_clip(Path("in/b.mp4"), size=(640, 360), frames=30)
    limit = 60_000
    limited = start(
        "in", "-s", "plain", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit,) * 2)
    )
    out, err = limited.communicate()
    films = json.loads(out)["films"]
    assert (limited.returncode, states(films)) == (5, ["done", "failed"]), err
    assert "the file size limit is reached" in films[1]["reason"]
    again = start("in", "-s", "plain")
    assert again.communicate() and again.returncode == 0
    assert len(media.read_all(Path("out/b.mp4"))) == 30 and left_over() == [JOURNAL]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
def test_a_stopped_batch_closes_its_film() -> None:
    Path("in").mkdir()
    media.make_clip(Path("in/a.mp4"), frames=10 * LONG_FRAMES)  # not done before the signal
    driver = start("--watch", "in", "in", "-s", "oil")
    eventually(lambda: count_frames(Path("out/a.partial.mp4")))
    driver.send_signal(signal.SIGTERM)
    out, err = driver.communicate()
    assert (driver.returncode, states(json.loads(out)["films"])) == (143, ["stopped"]), err
    assert media.read_all(Path("out/a.partial.mp4"))


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signal")
def test_a_signal_ends_a_batch_that_reads_a_large_source() -> None:
    with open("large.mp4", "wb") as file:
        file.truncate(2**42)  # takes no room, and an hour to read
    driver = start("large.mp4", "-s", "plain")
    try:
        eventually(
            lambda: any(each.path.endswith("large.mp4") for each in psutil.Process(driver.pid).open_files())
        )
        driver.send_signal(signal.SIGTERM)
        eventually(lambda: driver.poll() is not None)
    finally:
        driver.kill()
    out, _ = driver.communicate()
    assert driver.returncode == 128 + signal.SIGTERM
    assert states(json.loads(out)["films"]) == ["stopped"]
