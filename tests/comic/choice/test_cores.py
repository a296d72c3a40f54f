"""Cores while a film is analysed: each frame that is measured has one."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest
from stories import story, write_film

from vidstyle.comic.analyze.film import FilmFile, open_film
from vidstyle.comic.select.key_frames import find_key_frames


def test_opencv_has_one_thread_while_frames_are_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Frames are measured side by side; OpenCV's own threads would keep their cores busy while they wait."""
    seen = set[tuple[str, int]]()
    for name in ("_survey", "around"):
        method = getattr(FilmFile, name)

        def noting(*arguments: object, name: str = name, method=method) -> object:  # type: ignore[no-untyped-def]
            seen.add((name, cv2.getNumThreads()))
            return method(*arguments)

        monkeypatch.setattr(FilmFile, name, noting)
    before = cv2.getNumThreads()
    cv2.setNumThreads(2)
    try:
        with open_film(write_film(tmp_path / "film.mp4", story(2, 30))) as film:
            find_key_frames(film)
        assert seen == {("_survey", 1), ("around", 1)}
        assert cv2.getNumThreads() == 2
    finally:
        cv2.setNumThreads(before)
