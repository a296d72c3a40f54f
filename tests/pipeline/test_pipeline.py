"""`render` as a function: results, progress, and early stops."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import CancelledError
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from faults import own_threads, packets, times, video
from media import make_clip, make_picture, rgb_from_frame, rms_error
from waiting import LONG, eventually

import vidstyle
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.errors import DeviceError, StyleError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import Reader
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.pipeline.progress import Progress
from vidstyle.pipeline.render import first_frames, render
from vidstyle.pipeline.stages import MAX_QUEUED_BATCHES, batches

ROOT = Path(__file__).parents[2]
POSTER = {"format": 1, "background": [{"block": "posterize", "levels": 2}]}


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_clip(tmp_path_factory.mktemp("clip") / "clip.mp4", frames=90, audio_tracks=1)


def test_every_frame_and_packet_arrives_at_its_time(clip: Path, tmp_path: Path):
    summary = render(clip, tmp_path / "out.mp4", POSTER)
    assert (summary.frames, summary.exit_code, summary.stopped, summary.partial) == (90, 0, False, None)
    assert summary.duration == pytest.approx(3)
    assert times(tmp_path / "out.mp4") == pytest.approx(times(clip), abs=0.001)
    assert packets(tmp_path / "out.mp4", "audio") == packets(clip, "audio")


def test_the_picture_is_restyled(clip: Path, tmp_path: Path):
    render(clip, tmp_path / "out.mkv", POSTER, write=vidstyle.WriteOptions(codec="ffv1"), frames=2)
    levels = rgb_from_frame(video(tmp_path / "out.mkv")[1])
    assert np.mean(np.minimum(levels, 255 - levels) < 40) > 0.9


def watch_writing(monkeypatch: pytest.MonkeyPatch, watch: Callable[[Frame], object]) -> None:
    """Let something see every frame before it is written."""
    original = FilmWriter.write

    def write(self: FilmWriter, item: object) -> None:
        if isinstance(item, Frame):
            watch(item)
        original(self, item)  # type: ignore[arg-type]

    monkeypatch.setattr(FilmWriter, "write", write)


def test_plain_hands_over_the_decoders_own_frames(
    clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    written: list[Frame] = []
    watch_writing(monkeypatch, written.append)
    render(clip, tmp_path / "out.mp4", "plain")
    assert len(written) == 90 and all(frame.native is not None for frame in written)


def test_the_queues_are_short(clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Before the first frame is written, as many are read as possible; then the writer continues."""
    # Two queues, and what each of the three threads has in its hands.
    most = 2 * MAX_QUEUED_BATCHES + 3
    read: list[int] = []
    written: list[int] = []
    ahead: list[int] = []
    original = Reader.__iter__

    def iterate(self: Reader):
        for item in original(self):
            if isinstance(item, Frame):
                read.append(item.pts)
            yield item

    def watch(frame: Frame) -> None:
        eventually(lambda: len(read) == min(90, len(written) + most))
        written.append(frame.pts)
        ahead.append(len(read) - len(written) + 1)

    monkeypatch.setattr(Reader, "__iter__", iterate)
    watch_writing(monkeypatch, watch)
    render(clip, tmp_path / "out.mp4", "plain")
    assert written == read and len(read) == 90
    assert max(ahead) == most


def test_a_run_of_packets_does_not_fill_the_queue():
    sizes = [len(batch) for batch in batches([object()] * 100)]
    assert sum(sizes) == 100 and max(sizes) <= 32


def test_progress_grows_to_the_whole(clip: Path, tmp_path: Path):
    told: list[Progress] = []
    render(clip, tmp_path / "out.mp4", "plain", on_progress=told.append)
    assert [one.frames for one in told] == sorted(one.frames for one in told)
    assert (told[-1].frames, told[-1].total_frames, told[-1].fraction) == (90, 90, 1.0)


@pytest.mark.parametrize(("count", "threads"), [(1, 8), (20, 1), (20, 8), (90, 2), (500, 8)])
def test_so_many_frames_at_most_and_their_sound(
    clip: Path, tmp_path: Path, count: int, threads: int, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("VIDSTYLE_THREADS", str(threads))
    summary = render(clip, tmp_path / "out.mp4", "plain", frames=count)
    assert summary.frames == len(video(tmp_path / "out.mp4")) == min(count, 90)
    end = min(count, 90) / 30
    last = packets(tmp_path / "out.mp4", "audio")[-1][0]
    # Some sound lies before its picture in the file and has gone out by then.
    assert end - 0.06 < last < end + 0.1


def test_first_frames_lets_the_source_go(clip: Path):
    with vidstyle.media.read.reader.open_reader(clip) as reader:
        rest = iter(reader)
        items = first_frames(rest, 3, packets=False)
        assert sum(isinstance(item, Frame) for item in items) == 3
        after = next(item for item in rest if isinstance(item, Frame))
        assert after.time == Fraction(3, 30)  # without sound to come, nothing more is decoded


def test_stopping_keeps_what_is_done(clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    original, abandon = Reader.__iter__, FilmWriter.abandon
    stop, abandoned = threading.Event(), threading.Event()

    def iterate(self: Reader):
        for number, item in enumerate(original(self)):
            if number == 60:
                assert abandoned.wait(LONG)
            yield item

    def noted_abandon(self: FilmWriter) -> Path | None:
        abandoned.set()
        return abandon(self)

    def watch(progress: Progress) -> None:
        if progress.frames:
            stop.set()

    monkeypatch.setattr(FilmWriter, "abandon", noted_abandon)
    monkeypatch.setattr(Reader, "__iter__", iterate)
    summary = render(clip, tmp_path / "out.mp4", "plain", stop=stop, on_progress=watch)
    assert summary.stopped and summary.partial == tmp_path / "out.partial.mp4"
    assert 0 < len(video(summary.partial)) == summary.frames < 90
    assert not (tmp_path / "out.mp4").exists()
    assert summary.as_dict()["partial"] == str(summary.partial)


def test_stopping_waits_for_no_frame_that_is_restyled(
    clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    stop, running = threading.Event(), own_threads()

    def endless(self: CpuRenderer, *_: object) -> Picture:
        stop.set()
        assert self._threads.cancelled.wait(LONG)
        raise CancelledError

    monkeypatch.setattr(CpuRenderer, "_finish", endless)
    summary = render(clip, tmp_path / "out.mp4", POSTER, device="cpu", stop=stop)
    assert summary.stopped and summary.frames == 0 and not own_threads() - running


def test_a_frame_that_fails_ends_all_others(clip: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    finish, running = CpuRenderer._finish, own_threads()

    def failing(self: CpuRenderer, frame: Any, *others: Any) -> Picture:
        if frame.request.time == 0.5:
            raise ValueError("broken")
        return finish(self, frame, *others)

    monkeypatch.setattr(CpuRenderer, "_finish", failing)
    with pytest.raises(ValueError, match="broken"):
        render(clip, tmp_path / "out.mp4", POSTER, device="cpu")
    assert not own_threads() - running
    assert len(video(tmp_path / "out.partial.mp4")) <= 15


def test_what_the_caller_raises_ends_the_threads(clip: Path, tmp_path: Path):
    def interrupt(_: Progress) -> None:
        raise KeyboardInterrupt

    running = own_threads()
    with pytest.raises(KeyboardInterrupt) as raised:
        render(clip, tmp_path / "out.mp4", POSTER, on_progress=interrupt)
    assert not own_threads() - running
    notes = getattr(raised.value, "__notes__", [])
    assert bool(notes) == (tmp_path / "out.partial.mp4").exists()


@pytest.mark.parametrize(("how", "width"), [("side", 320), ("split", 160)])
def test_before_and_after(clip: Path, tmp_path: Path, how, width):
    render(clip, tmp_path / "out.mp4", POSTER, compare=how, frames=2, write=vidstyle.WriteOptions(crf=5))
    both = rgb_from_frame(video(tmp_path / "out.mp4")[1])
    source = rgb_from_frame(video(clip)[1])
    assert both.shape == (90, width, 3)
    left = 160 if how == "side" else 75
    assert rms_error(both[:, : left - 10], source[:, : left - 10]) < 4
    assert rms_error(both[:, -75:], source[:, -75:]) > 20


@pytest.mark.parametrize("size", [(61, 47), (64, 48)])
def test_before_and_after_of_a_picture(tmp_path: Path, size):
    make_picture(tmp_path / "one.png", size=size, mode="RGBA")
    render(tmp_path / "one.png", tmp_path / "both.png", POSTER, compare="side")
    with av.open(str(tmp_path / "both.png")) as container:
        frame = next(container.decode(video=0))
    assert (frame.width, frame.height) == (size[0] + size[0] % 2 + size[0], size[1])


def test_errors_come_before_anything_is_written(clip: Path, tmp_path: Path):
    with pytest.raises(StyleError):
        render(clip, tmp_path / "out.mp4", "no such style")
    with pytest.raises(DeviceError) as raised:
        render(clip, tmp_path / "out.mp4", POSTER, device="gpu:99")
    assert raised.value.exit_code == 6
    assert list(tmp_path.iterdir()) == []


def test_a_part_of_the_film(clip: Path, tmp_path: Path):
    read = vidstyle.ReadOptions(start=Fraction(1), end=Fraction(2))
    summary = render(clip, tmp_path / "out.mp4", "plain", read=read)
    assert summary.frames == 30 and times(tmp_path / "out.mp4")[0] == pytest.approx(0, abs=0.001)


def test_public_names_are_there_and_import_nothing_before():
    for name in vidstyle.__all__:
        assert getattr(vidstyle, name) is not None
    assert dir(vidstyle) == sorted([*vidstyle.__all__, "__version__"])
    with pytest.raises(AttributeError, match="no attribute 'rendr'"):
        vidstyle.rendr  # noqa: B018


@pytest.mark.parametrize(
    ("frames", "limit"), [("900", "20"), pytest.param("8000", "1", marks=pytest.mark.thorough)]
)
def test_memory_threads_and_files_stay_as_they_are(frames: str, limit: str):
    """A frame of 9 KB that is kept would be 90 MB in 10,000 frames."""
    soak = [sys.executable, str(ROOT / "tools" / "soak.py"), "--size", "96", "64"]
    command = [*soak, "--frames", frames, "--limit", limit]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=ROOT)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_what_is_no_picture_and_a_closed_renderer_are_refused():
    with pytest.raises(
        vidstyle.UsageError, match="'x.png' is of type str; give an array .*render takes files"
    ):
        vidstyle.stylize("x.png", "plain")
    with vidstyle.Renderer("plain") as renderer, pytest.raises(vidstyle.UsageError, match="of type str"):
        renderer("x.png")
    with pytest.raises(vidstyle.UsageError, match="renderer is closed"):
        renderer(np.zeros((4, 4, 3), np.uint8))


def test_arrays_of_any_type_and_layout() -> None:
    """Each result equals the result of a contiguous native copy, or is a one-line usage error."""
    random = np.random.default_rng(int(os.environ["VIDSTYLE_TEST_SEED"]))
    style = {"format": 1, "background": [{"block": "gaussian"}, {"block": "posterize"}]}
    types = "? i1 u1 >u2 <u2 >u4 i8 >f2 f4 >f4 >f8 g c8 >c16 O S3 U2 M8[s] V4 u1,u1,u1".split()
    layouts = {
        "plain": lambda array: array,
        "negative strides": lambda array: array[::-1, ::-1],
        "columns first": np.asfortranarray,
        "every other": lambda array: array[::2, 1::2],
        "broadcast": lambda array: np.broadcast_to(array[:1, :1], array.shape),
        "subclass": lambda array: array.view(np.recarray),
        "masked array": np.ma.masked_array,
        "part": lambda array: np.concatenate([array, array], 2)[..., : array.shape[2]],
        "no pixels": lambda array: array[:0],
    }
    failed = []
    for name, (layout, change), channels in itertools.product(types, layouts.items(), (3, 4)):
        whole = random.integers(0, 2, (8, 10, channels))
        array = change(whole.astype(np.dtype(name)) if "," not in name else np.zeros(whole.shape, name))
        try:
            found = vidstyle.stylize(array, style, device="cpu")
            plain = np.array(array, array.dtype.newbyteorder("="), order="C", subok=False)
            right = vidstyle.stylize(plain, style, device="cpu")
            if found.dtype != array.dtype or not np.array_equal(found, right):
                failed.append(f"{name}, {layout}: another result")
        except UsageError as error:
            if name.strip("<>") in ("u1", "u2", "f2", "f4", "f8") and layout != "no pixels":
                failed.append(f"{name}, {layout}: {error}")
        except Exception as error:
            failed.append(f"{name}, {layout}: {type(error).__name__}: {error}")
    assert not failed
