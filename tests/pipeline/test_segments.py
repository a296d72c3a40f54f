"""Segments of a film, restyled separately, have the same pictures as the film in one run."""

from __future__ import annotations

import logging
import threading
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import faults
import media
import numpy as np
import pytest
from face_network import red_people

from vidstyle.errors import InputError, OutputError, UsageError
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.write.segment_file import read_index
from vidstyle.pipeline.render import render
from vidstyle.pipeline.segment_plan import SegmentPlan
from vidstyle.pipeline.segments import PLAN_NAME, SegmentedFilm, segment_path
from vidstyle.regions.chosen_files import MODEL_VARIABLE
from vidstyle.style import load_style

FRAMES, SCENE_FRAMES = 40, 10
LOSSLESS = WriteOptions(codec="ffv1")
B_FRAMES = {"bf": "3", "g": "250", "sc_threshold": "0"}
UNEVEN = [Fraction(number, 30) + Fraction(number % 3, 100) for number in range(FRAMES)]
PALETTE = {"format": 1, "name": "own", "background": [{"block": "palette", "colors": "film-8"}]}


PEOPLE = {"format": 1, "name": "own", "only": "people", "background": [{"block": "posterize"}]}


@pytest.fixture(autouse=True)
def red_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Everything red is people."""
    path = tmp_path / "red.onnx"
    path.write_bytes(red_people())
    monkeypatch.setenv(MODEL_VARIABLE, str(path))


def segmented(source: Path, style: object, read: ReadOptions | None = None, **more: Any) -> SegmentedFilm:
    """A film in Matroska, without loss."""
    folder = source.with_suffix(".segments")
    folder.mkdir(exist_ok=True)
    values = {"device": "cpu", "compare": None, "write": LOSSLESS, "parts": {"crf": "0"}, **more}
    style = load_style(style)  # type: ignore[arg-type]
    return SegmentedFilm(
        source, source.with_suffix(".joined.mkv"), folder, style, read or ReadOptions(), **values
    )


def planned(film: SegmentedFilm, seconds: Fraction = Fraction(1, 3)) -> SegmentPlan:
    return film.plan(seconds, lambda progress: None, threading.Event())


def make(film: SegmentedFilm, plan: SegmentPlan, backwards: bool = False) -> Path:
    for segment in plan.segments[:: -1 if backwards else 1]:
        assert film.render(segment.name, lambda progress: None, threading.Event()).frames == segment.frames
    assert film.join(False, threading.Event()).frames == sum(each.frames for each in plan.segments)
    return film.target


def pictures(path: Path) -> list[tuple[float, bytes]]:
    frames = faults.video(path)
    return [(float(frame.pts * frame.time_base), frame.to_ndarray().tobytes()) for frame in frames]


def in_one_run(film: SegmentedFilm) -> Path:
    target = film.source.with_suffix(".whole.mkv")
    render(film.source, target, film.style, read=film.read, write=film.write, device="cpu")
    return target


@pytest.mark.parametrize(
    ("name", "clip", "style", "read"),
    [
        ("steady.mp4", {"options": B_FRAMES}, "comic", ReadOptions()),
        ("redrawn.mkv", {"times": UNEVEN}, "vhs", ReadOptions()),
        ("palette.mov", {"options": B_FRAMES}, PALETTE, ReadOptions()),
        ("people.mov", {"options": B_FRAMES}, PEOPLE, ReadOptions()),
        ("measured.ts", {}, "poster", ReadOptions()),
        ("hevc.mkv", {"codec": "libx265"}, "plain", ReadOptions()),
        ("trimmed.mp4", {}, "sketch", ReadOptions(start=Fraction(1, 7), end=Fraction(1))),
        ("rate.mp4", {"times": UNEVEN}, "ink", ReadOptions(fps=Fraction(20), size=(80, -2))),
        ("fields.mp4", {"interlaced": True, "codec": "mpeg2video"}, "sketch", ReadOptions()),
    ],
)
def test_segments_have_the_pictures_and_times_of_one_run(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, name: str, clip: dict, style: object, read: ReadOptions
) -> None:
    caplog.set_level(logging.INFO, "vidstyle")
    source = media.make_clip(
        tmp_path / name, size=(96, 54), frames=FRAMES, scene_frames=SCENE_FRAMES, audio_tracks=1, **clip
    )
    film = segmented(source, style, read)
    plan = planned(film)
    assert len(plan.segments) >= 2 and not plan.undivided
    joined = make(film, plan, backwards=True)
    whole = in_one_run(film)
    assert pictures(joined) == pictures(whole)
    assert faults.packets(joined, "audio") == faults.packets(whole, "audio")
    assert "is decoded from the start" not in caplog.text


def test_other_streams_are_copied_once(tmp_path: Path) -> None:
    source = media.make_clip(
        tmp_path / "a.mkv", size=(64, 36), frames=FRAMES, scene_frames=SCENE_FRAMES, audio_tracks=2,
        subtitles=("eng", "ger"), chapters=3, title="A title", attachment=b"font",
    )  # fmt: skip
    film = segmented(source, "plain")
    joined, whole = make(film, planned(film)), in_one_run(film)
    for kind in ("audio", "subtitles"):
        for number in range(2):
            assert faults.packets(joined, kind, number) == faults.packets(whole, kind, number)
    assert described(joined) == described(whole)


def described(path: Path) -> tuple[object, ...]:
    import av

    with av.open(str(path)) as container:
        streams = [(stream.type, stream.metadata.get("language")) for stream in container.streams]
        return streams, container.chapters(), container.metadata.get("title"), container.duration


def test_a_scene_is_one_segment_if_the_style_remembers(tmp_path: Path) -> None:
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), frames=FRAMES)
    for style in ("comic", PEOPLE):
        assert [each.name for each in planned(segmented(source, style)).segments] == [f"0:{FRAMES}"]
    film = segmented(source, "plain")
    plan = planned(film)
    assert [each.name for each in plan.segments] == ["0:10", "10:20", "20:30", "30:40"]
    assert pictures(make(film, plan)) == pictures(in_one_run(film))


@pytest.mark.parametrize("target", ["b.mp4", "b.webm", "b.ts", "b.avi"])
def test_packets_fit_every_container(tmp_path: Path, target: str) -> None:
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), frames=FRAMES, scene_frames=SCENE_FRAMES)
    film = replace(segmented(source, "plain"), target=tmp_path / target, write=WriteOptions())
    frames = faults.video(make(film, planned(film)))
    assert len(frames) == FRAMES
    expected = media.read_all(source)
    for frame, wanted in zip(frames, expected, strict=True):
        assert media.rms_error(media.rgb_from_frame(frame), media.rgb_from_frame(wanted)) < 12
    steps = np.diff([float(frame.pts * frame.time_base) for frame in frames])
    assert np.allclose(steps, 1 / 30, atol=2e-3)


def test_a_film_that_is_entered_wrongly_is_read_from_its_start(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As where a decoder gives other pictures after a jump: here, it enters the film too late."""
    from vidstyle.media.read.film_source import FilmSource

    caplog.set_level(logging.INFO, "vidstyle")
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), frames=FRAMES, scene_frames=SCENE_FRAMES)
    film = segmented(source, "plain")
    plan, seek = planned(film), FilmSource.seek
    monkeypatch.setattr(FilmSource, "seek", lambda self, time: seek(self, time + 2))
    assert pictures(make(film, plan)) == pictures(in_one_run(film))
    assert "is decoded from the start" in caplog.text


def test_a_film_that_changed_since_is_refused(tmp_path: Path) -> None:
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), frames=FRAMES, scene_frames=SCENE_FRAMES)
    film = segmented(source, "plain")
    plan = planned(film)
    media.make_clip(source, size=(64, 36), frames=FRAMES, photograph_name="rocket")
    with pytest.raises(InputError, match="was changed, or is decoded differently, in frames 10:20"):
        film.render(plan.segments[1].name, lambda progress: None, threading.Event())
    assert [path.name for path in film.folder.iterdir()] == [PLAN_NAME]


def test_segments_of_other_settings_or_with_damage_are_not_joined(tmp_path: Path) -> None:
    source = media.make_clip(tmp_path / "a.mp4", size=(64, 36), frames=20, scene_frames=SCENE_FRAMES)
    film = segmented(source, "plain", write=WriteOptions(codec="libx264"))
    plan = planned(film)
    make(film, plan)
    path = segment_path(film.folder, plan.segments[1])
    content = path.read_bytes()
    for damaged in (content[:-1], content[: len(content) // 2], b"", content[:9] + b"?" + content[10:]):
        path.write_bytes(damaged)
        with pytest.raises(InputError):
            read_index(path)
        with pytest.raises(InputError):
            film.join(True, threading.Event())
    path.write_bytes(content)
    with pytest.raises(OutputError, match="appeared during the run"):
        film.join(False, threading.Event())
    with pytest.raises(UsageError, match="was made with another crf"):
        replace(film, parts={"crf": "1"}).join(True, threading.Event())
    other = replace(film, write=WriteOptions(codec="libx264", preset="slow"))
    with pytest.raises(OutputError, match="different encoder settings"):
        other.join(True, threading.Event())
    other.render(plan.segments[1].name, lambda progress: None, threading.Event())
    with pytest.raises(InputError, match="settings that differ from the first"):
        film.join(True, threading.Event())
    with pytest.raises(UsageError, match="0:3 is not a segment of this film; the segments are 0:10, 10:20"):
        film.render("0:3", lambda progress: None, threading.Event())


def test_what_cannot_be_entered_in_the_middle_is_not_divided(tmp_path: Path) -> None:
    cut = media.make_clip(tmp_path / "a.mkv", size=(64, 36), frames=FRAMES, scene_frames=SCENE_FRAMES)
    cut.write_bytes(cut.read_bytes()[: cut.stat().st_size * 2 // 3])
    assert planned(segmented(cut, "plain")).undivided == "is damaged"
    still = media.make_picture(tmp_path / "b.png")
    assert planned(segmented(still, "plain")).undivided == "is a picture"
    pattern = tmp_path / "%d.png"
    for number in range(3):
        media.make_picture(tmp_path / f"{number}.png")
    assert planned(segmented(pattern, "plain")).undivided == "is not seekable"
