"""Long films in a batch: divided, made by several processes, killed, continued and joined."""

from __future__ import annotations

import hashlib
import json
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import faults
import media
import psutil
import pytest
from waiting import eventually

from vidstyle.batch.journal import JOURNAL
from vidstyle.batch.scratch import LOCK_NAME, OWNER

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals and locks")
FRAMES, SCENE_FRAMES = 120, 30
SEGMENTS = 4


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    media.make_clip(
        Path("long.mp4"),
        frames=FRAMES,
        scene_frames=SCENE_FRAMES,
        audio_tracks=1,
        subtitles=("eng",),
        chapters=2,
    )
    return tmp_path


def start(*words: str) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "vidstyle", "batch", "long.mp4", "-s", "sketch", "--json", *words]
    return subprocess.Popen(line, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def ended(driver: subprocess.Popen[str]) -> dict[str, Any]:
    """Run a batch without errors and return its result."""
    out, err = driver.communicate()
    assert driver.returncode == 0, err
    return json.loads(out)["films"][0]


def segments(folder: str) -> dict[str, int]:
    """The finished segments of a film, and when they were written."""
    found = Path(folder).glob(".long.mp4.segments-*/*-*.segment")
    return {path.name: path.stat().st_mtime_ns for path in found if path.stem.count(".") == 0}


def workers_on_segments(driver: subprocess.Popen[str]) -> list[psutil.Process]:
    found = []
    for worker in psutil.Process(driver.pid).children():
        with suppress(psutil.Error):  # it has ended meanwhile
            found += [worker] * any(word.startswith("--range=") for word in worker.cmdline())
    return found


def contents(path: Path) -> tuple[object, ...]:
    """All that a film holds: times and packets of the pictures, and the other streams."""
    streams = [faults.packets(path, kind) for kind in ("video", "audio", "subtitles")]
    return len(faults.video(path)), hashlib.sha256(repr(streams).encode()).hexdigest()


def test_a_killed_film_continues_with_the_segments_that_are_missing() -> None:
    words = ("-o", "killed/{name}.mp4", "--segment", "0.5", "-j", "2")
    neighbours = ["killed/long.mkv", "killed/.long.mp4.segments", "killed/.long.mp4.segments-mine"]
    Path("killed").mkdir()
    for name in neighbours:
        Path(name).write_text("mine")
    driver = start(*words)
    eventually(lambda: len(segments("killed")) >= 1)
    workers = psutil.Process(driver.pid).children(recursive=True)
    driver.kill()
    driver.communicate()
    psutil.wait_procs(workers, 60)
    assert not any(worker.is_running() for worker in workers)
    done = segments("killed")
    assert len(done) < SEGMENTS and not Path("killed/long.mp4").exists()

    again = start(*words)
    eventually(lambda: workers_on_segments(again))
    for worker in workers_on_segments(again):
        worker.send_signal(signal.SIGKILL)
    _, err = again.communicate()
    assert segments("killed").items() >= done.items(), "complete segments are not made again"
    assert (again.returncode, "its process was ended by SIGKILL" in err) == (137, True), err

    damaged = next(Path("killed").glob(f".long.mp4.segments-*/{next(iter(done))}"))
    damaged.write_bytes(damaged.read_bytes()[:-100])
    both = [start(*words) for _ in range(2)]
    assert sorted(ended(each)["state"] for each in both) == ["done", "skipped"]
    assert sorted(path.name for path in Path("killed").iterdir()) == sorted(
        [JOURNAL, "long.mp4", *(Path(name).name for name in neighbours)]
    )

    left = Path("killed/.long.mp4.segments-0123456789abcdef")
    left.mkdir()
    (left / LOCK_NAME).write_bytes(OWNER)
    assert ended(start(*words))["state"] == "skipped" and not left.exists()

    alone = ended(start("-o", "alone/{name}.mp4", "--segment", "0.5", "-j", "1"))
    assert (alone["state"], alone["frames"]) == ("done", FRAMES)
    assert contents(Path("killed/long.mp4")) == contents(Path("alone/long.mp4"))


def test_segments_of_other_settings_are_removed() -> None:
    driver = start("-o", "{name}-ink.mp4", "--segment", "0.5", "-j", "2")
    eventually(lambda: list(Path().glob(".long-ink.mp4.segments-*/plan.json")))
    driver.kill()
    driver.communicate()
    stale = next(Path().glob(".long-ink.mp4.segments-*"))
    film = ended(start("-o", "{name}-ink.mp4", "--segment", "100", "--crf", "30"))
    assert (film["state"], film["frames"]) == ("done", FRAMES)
    assert not stale.exists() and not list(Path().glob(".long-ink*"))
