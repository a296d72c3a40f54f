"""Long scenes in segments: the same pictures as in one run, by a warm-up or a stored state."""

from __future__ import annotations

import threading
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import cv2
import faults
import media
import pytest
from pictures import picture_with_face

from vidstyle.errors import InputError, OutputError
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.write.segment_file import read_index
from vidstyle.pipeline import segment_borders, segments
from vidstyle.pipeline.render import render
from vidstyle.pipeline.scene_memory import memory_path, unproved_segments
from vidstyle.pipeline.segment_plan import SegmentPlan
from vidstyle.pipeline.segments import SegmentedFilm, segment_path
from vidstyle.style import load_style

FRAMES = 80
UNEVEN = [Fraction(number, 30) + Fraction(number % 3, 100) for number in range(FRAMES)]
PALETTE = {"format": 1, "name": "own", "background": [{"block": "palette", "colors": "film-8"}]}
STEADY = {"format": 1, "steady": 0.2, "background": [{"block": "posterize"}, {"block": "noise", "rate": 12}]}
"""A style whose memory of earlier frames fades within 30 of them."""
SETTLED = {"format": 1, "name": "settled", "steady": 0.5, "background": [{"block": "minimum_range"}]}


@pytest.fixture(autouse=True)
def short_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Divide scenes into parts of at least a second, and warm up for 10 frames."""
    monkeypatch.setattr(segment_borders, "MIN_PART_SECONDS", 1)
    monkeypatch.setattr(segment_borders, "MIN_PART_RATIO", 0)
    warm_up(monkeypatch, 10)


def warm_up(monkeypatch: pytest.MonkeyPatch, frames: int) -> None:
    monkeypatch.setattr(segment_borders, "WARM_UP_FRAMES", frames)
    monkeypatch.setattr(segment_borders, "WARM_UP_FACTOR", 0)


def one_scene(path: Path, **more: Any) -> Path:
    return media.make_clip(path, **{"size": (96, 54), "frames": FRAMES, "audio_tracks": 1, **more})


def segmented(source: Path, style: object, read: ReadOptions | None = None) -> SegmentedFilm:
    folder = source.with_suffix(".segments")
    folder.mkdir(exist_ok=True)
    target, options = source.with_suffix(".joined.mkv"), WriteOptions(codec="ffv1")
    chosen: Any = style
    return SegmentedFilm(
        source, target, folder, load_style(chosen), read or ReadOptions(), options, "cpu", None, {}
    )


def planned(film: SegmentedFilm) -> SegmentPlan:
    return film.plan(Fraction(1, 2), lambda progress: None, threading.Event())


def make(film: SegmentedFilm, *names: str) -> None:
    for name in names:
        film.render(name, lambda progress: None, threading.Event())


def unproved(film: SegmentedFilm, plan: SegmentPlan) -> list[str]:
    indexes = {each: read_index(segment_path(film.folder, each)) for each in plan.segments}
    return [each.name for each in unproved_segments(plan, indexes)]


def pictures(path: Path) -> list[tuple[float, bytes]]:
    return [
        (float(frame.pts * frame.time_base), frame.to_ndarray().tobytes()) for frame in faults.video(path)
    ]


def joined(film: SegmentedFilm) -> list[tuple[float, bytes]]:
    film.join(True, threading.Event())
    return pictures(film.target)


def in_one_run(film: SegmentedFilm) -> list[tuple[float, bytes]]:
    target = film.source.with_suffix(".whole.mkv")
    write = replace(film.write, overwrite=True)
    render(film.source, target, film.style, read=film.read, write=write, device="cpu")
    return pictures(target)


@pytest.mark.parametrize(
    ("name", "clip", "style", "read"),
    [
        ("measured.mp4", {"options": {"bf": "3", "sc_threshold": "0"}}, "watercolor", ReadOptions()),
        ("redrawn.mkv", {"times": UNEVEN}, "vhs", ReadOptions()),
        ("deep.mkv", {"pix_fmt": "yuv420p10le", "codec": "libx265"}, "comic", ReadOptions()),
        ("rate.mp4", {}, "sketch", ReadOptions(fps=Fraction(25), start=Fraction(1, 5))),
        ("floats.mkv", {"codec": "ffv1", "pix_fmt": "yuv444p16le"}, "ink", ReadOptions()),
    ],
)  # fmt: skip
def test_the_memory_of_a_segment_goes_to_the_next(
    tmp_path: Path, name: str, clip: dict[str, Any], style: object, read: ReadOptions
) -> None:
    film = segmented(one_scene(tmp_path / name, **clip), style, read)
    plan = planned(film)
    assert len(plan.segments) >= 2 and all(each.before_pts is not None for each in plan.segments[1:])
    make(film, *(each.name for each in plan.segments))
    assert not unproved(film, plan)
    assert joined(film) == in_one_run(film)


def test_a_warm_up_that_is_long_enough_is_proved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Segments of two machines, which do not see each other's memory."""
    warm_up(monkeypatch, 30)
    film = segmented(one_scene(tmp_path / "a.mkv"), STEADY)
    plan = planned(film)
    make(film, *(each.name for each in plan.segments[::-1]))
    assert not unproved(film, plan)
    assert joined(film) == in_one_run(film)


@pytest.mark.parametrize("is_lost", [False, True])
def test_a_warm_up_that_is_too_short_is_made_again(tmp_path: Path, is_lost: bool) -> None:
    film = segmented(one_scene(tmp_path / "a.mkv"), SETTLED)
    plan = planned(film)
    names = [each.name for each in plan.segments]
    make(film, *names[::-1])
    assert unproved(film, plan) == names[1:]
    with pytest.raises(InputError, match=f"does not continue the segment before it; .*{names[1]}"):
        film.join(True, threading.Event())
    memory = memory_path(segment_path(film.folder, plan.segments[0]))
    if is_lost:  # a damaged memory is not used
        memory.write_bytes(memory.read_bytes()[:-1] + b"?")
    make(film, *names[1:])
    assert unproved(film, plan) == (names[1:2] if is_lost else [])
    if not is_lost:
        assert joined(film) == in_one_run(film)


def test_other_frames_before_a_segment_are_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As where a decoder gives other pictures after a jump: here, it enters the film too late."""
    from vidstyle.media.read.film_source import FilmSource

    caplog.set_level("INFO", "vidstyle")
    film, seek = segmented(one_scene(tmp_path / "a.mp4"), "vhs"), FilmSource.seek
    plan = planned(film)
    late = float(plan.segments[1].pts * Fraction(plan.time_base))
    monkeypatch.setattr(FilmSource, "seek", lambda self, time: seek(self, Fraction(late)))
    make(film, *(each.name for each in plan.segments))
    assert "is decoded from the start" in caplog.text
    assert joined(film) == in_one_run(film)


def test_a_segment_that_is_replaced_while_it_is_joined_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a process that was slow, and whose segment another one has made meanwhile."""
    film = segmented(one_scene(tmp_path / "a.mkv"), SETTLED)
    plan = planned(film)
    names = [each.name for each in plan.segments]
    make(film, names[1])
    late = segment_path(film.folder, plan.segments[1]).read_bytes()
    make(film, *names)
    checked = segments.unproved_segments

    def checked_early(*found: Any) -> Any:
        result = checked(*found)
        segment_path(film.folder, plan.segments[1]).write_bytes(late)
        return result

    monkeypatch.setattr(segments, "unproved_segments", checked_early)
    with pytest.raises(OutputError, match="was replaced while it was joined"):
        film.join(False, threading.Event())
    monkeypatch.undo()
    assert not film.target.exists() and unproved(film, plan)[0] == names[1]
    make(film, *names[1:])
    assert joined(film) == in_one_run(film)


@pytest.mark.parametrize("style", [PALETTE, "vhs"])
def test_scenes_whose_memory_is_not_compared_are_one_segment(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, style: object
) -> None:
    """Colours of the film follow a whole scene; the memory of a GPU is not read back."""
    if style == "vhs":
        monkeypatch.setattr(segment_borders, "runs_on_cpu", lambda style, device: False)
    film = segmented(one_scene(tmp_path / "a.mkv"), style)
    assert [each.name for each in planned(film).segments] == [f"0:{FRAMES}"]


def film_with_faces(path: Path, places: list[float | None]) -> Path:
    """Write a film of `picture_with_face`, with few frames between two searches for faces."""
    with av.open(str(path), "w") as container:
        video = container.add_stream("ffv1", rate=10)
        video.width, video.height, video.pix_fmt = 320, 240, "yuv420p"
        for place in places:
            picture = cv2.resize(picture_with_face(place), (320, 240), interpolation=cv2.INTER_AREA)
            container.mux(
                video.encode(av.VideoFrame.from_ndarray(picture, "rgb24").reformat(format="yuv420p"))
            )
        container.mux(video.encode(None))
    return path


def test_faces_are_followed_as_in_one_run(tmp_path: Path) -> None:
    """A scene is divided where no face is followed; later searches happen at the same times."""
    places = [250.0] * 12 + [None] * 28 + [180.0 + 2.5 * number for number in range(16)]
    film = segmented(film_with_faces(tmp_path / "a.mkv", places), SETTLED | {"height": 720})
    plan = planned(film)
    assert len(plan.cuts) == 1 and len(plan.segments) >= 2
    assert all(12 < each.first <= 42 and each.search_time for each in plan.segments[1:])
    make(film, *(each.name for each in plan.segments))
    whole = in_one_run(film)
    assert joined(film) == whole
    plain = segmented(film.source, SETTLED | {"height": 720, "focus": 0.0})
    changed = [one != other for one, other in zip(whole, in_one_run(plain), strict=True)]
    assert changed[0] and changed[-1]
