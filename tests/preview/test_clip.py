"""The clip of a page: frames of films, photographs, folders and live sources by number."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import make_clip, make_picture, rms_error

from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import open_reader
from vidstyle.preview.clip import FilmClip, open_clip
from vidstyle.preview.encode import encode
from vidstyle.preview.plans import PlanSender
from vidstyle.preview.representative import representative_frame
from vidstyle.style import load_style, set_values


def all_frames(path: Path) -> list[np.ndarray]:
    with open_reader(path) as reader:
        return [to_rgb(item.picture) for item in reader if isinstance(item, Frame)]


@pytest.mark.parametrize(
    ("name", "rate", "options"),
    [
        ("film.mp4", 25, {}),
        ("turned.mp4", Fraction(30000, 1001), {"rotation": 90}),
        ("groups.mp4", 60, {"options": {"g": "7", "bf": "2"}}),
        ("milliseconds.mkv", Fraction(30000, 1001), {}),
    ],
)
def test_a_number_stands_for_its_frame_in_whatever_order(
    tmp_path: Path, name: str, rate: Fraction, options: dict
) -> None:
    path = make_clip(tmp_path / name, size=(64, 48), rate=rate, frames=40, **options)
    frames = all_frames(path)
    clip = open_clip(path)
    assert clip.count == len(frames) == 40 and clip.fps == pytest.approx(float(rate))
    assert clip.size == frames[0].shape[1::-1] and not clip.live and clip.file() == str(path)
    numbers = [0, 1, 2, 39, 38, 20, 21, 0, *random.sample(range(40), 12)]
    for number in numbers:
        assert (clip.frame(number) == frames[number]).all(), number
    assert (clip.frame(1000) == frames[39]).all()
    assert not clip.frame(3).flags.writeable
    clip.close()
    with pytest.raises(InputError, match="is closed"):
        clip.frame(17, 20)


@pytest.mark.parametrize("options", [{}, {"rotation": 90}])
def test_a_glance_needs_no_kernel(tmp_path: Path, options: dict, monkeypatch: pytest.MonkeyPatch) -> None:
    path = make_clip(tmp_path / "film.mp4", size=(96, 54), frames=8, **options)
    exact = open_clip(path).frame(5, 27)
    clip = open_clip(path)

    def refuse(*arguments: object) -> None:
        raise AssertionError("a kernel was called")

    with monkeypatch.context() as patched:
        patched.setattr("vidstyle.core.kernels.declare.Compiled.__call__", refuse)
        glance = clip.glance(5, 27)
        assert representative_frame(clip) == 0
        with pytest.raises(AssertionError, match="a kernel was called"):
            clip.frame(5, 27)
    assert glance.shape == exact.shape and rms_error(glance, exact) < 6


def test_a_frame_is_reduced_to_its_shorter_side(tmp_path: Path) -> None:
    clip = open_clip(make_clip(tmp_path / "film.mp4", size=(96, 54), frames=3))
    assert clip.frame(1, 27).shape == (27, 48, 3)
    assert clip.frame(1, 500).shape == (54, 96, 3)
    small = cv2.resize(clip.frame(1), (48, 27), interpolation=cv2.INTER_AREA)
    assert rms_error(clip.frame(1, 27), small) < 6
    clip.close()


def test_a_photograph_is_one_frame(tmp_path: Path) -> None:
    clip = open_clip(make_picture(tmp_path / "photo.png", size=(40, 30)))
    assert (clip.count, clip.size) == (1, (40, 30))
    assert (clip.frame(0) == clip.frame(5)).all()
    clip.close()


def test_a_folder_is_its_pictures_at_the_size_of_the_first(tmp_path: Path) -> None:
    for number, size in enumerate([(40, 30), (20, 40), (80, 60)]):
        make_picture(tmp_path / f"{number}.png", size=size)
    (tmp_path / "notes.txt").write_text("no picture")
    clip = open_clip(tmp_path)
    assert clip.count == 3 and clip.name == str(tmp_path) and str(clip.file()).endswith("*.png")
    assert [clip.frame(number).shape for number in (2, 0, 1)] == [(30, 40, 3)] * 3
    assert (clip.frame(1)[:, 0] == 0).all()  # bars beside a picture that is higher
    clip.close()
    with pytest.raises(InputError, match="folder without pictures"):
        open_clip(make_folder(tmp_path / "empty"))


def make_folder(path: Path) -> Path:
    path.mkdir()
    return path


def test_the_demo_film_and_a_live_source_give_frames() -> None:
    demo = open_clip(None)
    assert demo.frame(3, 90).shape == (90, 160, 3) and demo.count == 100
    assert (demo.frame(3) != demo.frame(4)).any()
    demo.close()
    live = open_clip("test")
    assert live.live and live.size == (640, 360) and live.file() is None
    assert live.frame(0, 90).shape == (90, 160, 3)
    live.close()


@pytest.mark.parametrize("name", ["missing.mp4", "text.mp4"])
def test_what_is_no_clip_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "text.mp4").write_text("no film")
    with pytest.raises(InputError):
        FilmClip(tmp_path / name)


def test_a_png_is_exact_and_a_jpeg_near() -> None:
    clip = open_clip(None)
    frame = clip.frame(0, 90)
    for format, most in (("png", 0), ("jpeg", 4)):
        data = np.frombuffer(encode(frame, format), np.uint8)  # type: ignore[arg-type]
        decoded = cv2.imdecode(data, cv2.IMREAD_COLOR)
        assert decoded is not None and rms_error(decoded[..., ::-1], frame) <= most


def test_a_plan_is_sent_once_and_values_alone_afterwards() -> None:
    sender, style = PlanSender(), load_style("comic")
    first = sender.message(style, 640, 360)
    second = sender.message(set_values(style, {"halftone.cell": 9}), 640, 360)
    assert first["plan"]["values"] == first["values"] != second["values"]
    assert second["key"] == first["key"] and "plan" not in second
    assert sender.message(style, 80, 60)["key"] != first["key"]
    assert sender.message(load_style("ink"), 640, 360)["key"] != first["key"]
