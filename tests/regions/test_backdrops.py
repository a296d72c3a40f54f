"""Backgrounds of people: a colour, a blur, a style, a picture or a film."""

import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from face_network import gray_and_red
from media import make_clip

from vidstyle.cli import main
from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError, UsageError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import open_reader
from vidstyle.regions.backdrop import Backdrop
from vidstyle.regions.chosen_files import BACKDROP_VARIABLE, MODEL_VARIABLE
from vidstyle.regions.frame_masks import FrameMasks
from vidstyle.renderer import stylize
from vidstyle.style import load_style
from vidstyle.style.behind import style_behind


@pytest.mark.parametrize("device", ["cpu", "gpu"])
def test_a_picture_stands_behind_people(
    device: str, red_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its middle fills the picture; people stand before it."""
    wide = np.zeros((50, 200, 3), np.uint8)
    wide[:, 75:125] = 10, 200, 30  # blue, green, red of OpenCV
    assert cv2.imwrite(str(tmp_path / "wide.png"), wide)
    monkeypatch.setenv(BACKDROP_VARIABLE, str(tmp_path / "wide.png"))
    color = np.full((144, 144, 3), 120, np.uint8)
    color[40:100, 60:120] = 250, 10, 10
    style = replace(load_style("plain"), behind=style_behind("backdrop"))
    result = stylize(color, style, device)
    assert (result[:30, 20:-20] == (30, 200, 10)).all()
    assert np.abs(result[50:90, 70:110].astype(int) - color[50:90, 70:110]).max() <= 1


def test_a_film_behind_people_repeats(tmp_path: Path) -> None:
    """Frames are shown at their times; after the last one, and after a jump back, the film begins again."""
    film = make_clip(tmp_path / "film.mkv", size=(64, 36), rate=10, frames=5, codec="ffv1")
    own = [to_rgb(each.picture) for each in open_reader(film) if isinstance(each, Frame)]
    with Backdrop(film) as backdrop:
        for time, number in [
            (0, 0),
            (0.11, 1),
            (0.19, 1),
            (0.45, 4),
            (0.5, 0),
            (0.85, 3),
            (3.25, 2),
            (0.1, 1),
        ]:
            assert np.array_equal(backdrop.at(time, (36, 64)), own[number]), time
        assert np.array_equal(backdrop.at(None, (36, 64)), own[0])
        assert backdrop.at(0.0, (90, 31)).shape == (90, 31, 3)


def test_a_backdrop_is_a_picture_or_a_film(
    red_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    style = load_style({"format": 1, "behind": {"background": [{"from": "backdrop"}]}})
    monkeypatch.delenv(BACKDROP_VARIABLE, raising=False)
    with pytest.raises(UsageError, match="give a picture or a film as --background"):
        FrameMasks(style)
    (tmp_path / "noise.mp4").write_bytes(bytes(range(256)))
    monkeypatch.setenv(BACKDROP_VARIABLE, str(tmp_path / "noise.mp4"))
    with pytest.raises(InputError, match="noise.mp4"):
        FrameMasks(style)


@pytest.mark.parametrize("background", ["blur", "#102030", "poster", "beach.png"])
def test_render_takes_a_background(
    background: str, red_model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And a model and regions by options; the environment is as before."""
    monkeypatch.delenv(MODEL_VARIABLE)
    monkeypatch.chdir(tmp_path)
    assert cv2.imwrite("beach.png", np.full((9, 16, 3), 77, np.uint8))
    assert cv2.imwrite("in.png", gray_and_red()[..., ::-1])
    options = ["--style", "plain", "--background", background, "--model", str(red_model), "--device", "cpu"]
    assert main(["render", "in.png", "out.png", *options]) == 0
    result = cv2.imread("out.png")
    assert np.abs(result[:, 170:].astype(int) - (10, 10, 250)).max() <= 1
    assert np.abs(result[:, :80].astype(int) - gray_and_red()[:, :80]).mean() > 5
    assert BACKDROP_VARIABLE not in os.environ and MODEL_VARIABLE not in os.environ
    assert main(["render", "in.png", "kept.png", "--style", "poster", "--keep", "screen"]) == 2
