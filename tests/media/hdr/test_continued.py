"""Segments and continued runs of HDR films give the same pictures as one run, with the same metadata."""

from __future__ import annotations

import threading
from fractions import Fraction
from pathlib import Path

import media
import pytest

from vidstyle.media.hdr_encoding import CHECKED_METADATA, hdr_options
from vidstyle.media.hdr_metadata import first_metadata
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.write.film_writer import FilmWriter
from vidstyle.pipeline.render import render
from vidstyle.pipeline.segments import SegmentedFilm
from vidstyle.style import load_style

KEEP = ReadOptions(hdr="keep")
WRITE = WriteOptions(preset="superfast")
STYLE = load_style({"format": 1, "name": "soft", "steady": 0.5, "background": [{"block": "equalize"}]})
FRAMES, SCENE_FRAMES = 90, 30
"""Long enough that the encoder begins a group of pictures at cuts."""


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A PQ film of three scenes with metadata."""
    parameters = hdr_options("libx265", CHECKED_METADATA)["x265-params"]
    return media.make_clip(
        tmp_path_factory.mktemp("hdr") / "film.mp4",
        frames=FRAMES,
        scene_frames=SCENE_FRAMES,
        codec="libx265",
        pix_fmt="yuv420p10le",
        matrix="bt2020",
        transfer="pq",
        options={"x265-params": f"log-level=none:{parameters}"},
    )


def pictures(path: Path) -> list[bytes]:
    return [frame.to_ndarray().tobytes() for frame in media.read_all(path)]


def test_segments_join_to_an_hdr_film(film, tmp_path):
    folder, target = tmp_path / "segments", tmp_path / "joined.mp4"
    folder.mkdir()
    segmented = SegmentedFilm(
        film, target, folder, STYLE, KEEP, device="cpu", compare=None, write=WRITE, parts={"hdr": "keep"}
    )
    stop = threading.Event()
    plan = segmented.plan(Fraction(1, 5), lambda progress: None, stop)
    assert len(plan.segments) > 1
    for segment in plan.segments:
        segmented.render(segment.name, lambda progress: None, stop)
    segmented.join(False, stop)
    assert len(pictures(target)) == FRAMES
    assert first_metadata(str(target), 0)[0] == first_metadata(str(film), 0)[0]


def test_a_continued_hdr_film_keeps_tags_and_metadata(film, tmp_path, monkeypatch):
    target, written = tmp_path / "out.mp4", iter(range(80))

    def failing(self, item, original=FilmWriter.write):
        if next(written, None) is None:
            raise KeyboardInterrupt
        original(self, item)

    with monkeypatch.context() as patched:
        patched.setattr(FilmWriter, "write", failing)
        with pytest.raises(KeyboardInterrupt):
            render(film, target, STYLE, read=KEEP, write=WRITE, device="cpu")
    summary = render(film, target, STYLE, read=KEEP, write=WRITE, device="cpu", resume=True)
    assert summary.kept > 0 and len(pictures(target)) == FRAMES
    assert first_metadata(str(target), 0)[0] == first_metadata(str(film), 0)[0]
