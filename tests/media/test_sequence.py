"""Single pictures, image sequences and animations; orientation from EXIF tags."""

from __future__ import annotations

import os
from fractions import Fraction
from pathlib import Path

import media
import numpy as np
import pytest
from faults import Program, cut

from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader
from vidstyle.media.read.sequence import find_sequence_files


def read(path: object, **options: object) -> list[Frame]:
    with open_reader(path, ReadOptions(**options)) as reader:
        return [item for item in reader if isinstance(item, Frame)]


@pytest.mark.parametrize("kind", ["png", "jpg", "webp", "tiff", "bmp", "gif", "ppm", "avif"])
def test_single_pictures(tmp_path, kind):
    path = media.make_picture(tmp_path / f"still.{kind}")
    with open_reader(path) as reader:
        assert reader.info.still and reader.info.frames == 1
        frames = list(reader)
    assert len(frames) == 1
    picture = frames[0].picture
    if picture.color is not None:
        limit = 30 if kind == "gif" else 0
        assert media.rms_error(picture.color, next(media.moving_frames(1))) <= limit
    else:
        assert picture.encoding.matrix == "bt601"
        assert picture.luma.std() > 20


def test_sixteen_bits_and_alpha_are_kept(tmp_path):
    deep = read(media.make_picture(tmp_path / "deep.png", mode="I;16"))[0].picture
    assert (
        deep.encoding.depth == 16
        and (deep.luma == next(media.moving_frames(1))[..., 1].astype(int) * 257).all()
    )
    clear = read(media.make_picture(tmp_path / "clear.png", mode="RGBA"))[0].picture
    assert (clear.alpha == media.alpha_ramp(180, 320)).all()
    indexed = read(media.make_picture(tmp_path / "indexed.png", mode="P"))[0].picture
    assert indexed.color is not None and indexed.alpha is None


@pytest.mark.parametrize(
    ("kind", "orientation"),
    # PyAV tells how PNG and WebP are turned, but not that they are mirrored.
    [("jpg", number) for number in range(1, 9)] + [(kind, n) for kind in ("png", "webp") for n in (3, 6, 8)],
)
def test_photographs_are_set_upright(tmp_path, kind, orientation):
    from PIL import Image, ImageOps

    exif = Image.Exif()
    exif[0x0112] = orientation
    path = tmp_path / f"photo.{kind}"
    Image.fromarray(next(media.moving_frames(1))).save(path, exif=exif, quality=95)
    with Image.open(path) as opened:
        expected = np.asarray(ImageOps.exif_transpose(opened).convert("L"))
    picture = read(path)[0].picture
    got = picture.luma if picture.luma is not None else picture.color @ np.array([0.299, 0.587, 0.114])
    assert got.shape == expected.shape
    if picture.luma is not None and not picture.encoding.full_range:
        got = (got - 16.0) * 255 / 219
    assert media.rms_error(got, expected) < 3


def test_numbered_pictures_are_a_film(tmp_path, caplog):
    for number in (7, 8, 9, 11):
        media.make_picture(tmp_path / f"frame{number:04}.png", size=(64, 48))
    (tmp_path / "frame_x.png").write_text("not one of them")
    os.mkfifo(tmp_path / "frame0010.png")  # nor is a pipe, which nobody may ever write to
    frames = read(tmp_path / "frame%04d.png", rate=Fraction(24000, 1001))
    assert [frame.time for frame in frames] == [number * Fraction(1001, 24000) for number in range(4)]
    assert "1 numbers are missing" in caplog.text or "1 number is missing" in caplog.text
    with open_reader(tmp_path / "frame%04d.png", ReadOptions(start=Fraction(2, 25))) as reader:
        assert reader.info.frames == 2 and reader.container is None
        assert len(list(reader)) == 2


def test_a_damaged_picture_among_them_is_held(tmp_path):
    for number in range(5):
        media.make_picture(tmp_path / f"{number}.png", size=(64, 48))
    (tmp_path / "3.png").write_bytes(b"nothing")
    with open_reader(tmp_path / "%d.png") as reader:
        assert len(list(reader)) == 5
        assert reader.damage.repeated == 1 and reader.damage.is_significant


def test_numbers_are_sorted_as_numbers(tmp_path):
    for name in ("9.png", "10.png", "0100.png"):
        (tmp_path / name).touch()
    assert [path.name for path in find_sequence_files(str(tmp_path / "%d.png"))] == [
        "9.png",
        "10.png",
        "0100.png",
    ]


def test_a_name_with_a_star_is_a_sequence_in_natural_order(program: Program):
    folder = program.folder / "in"
    folder.mkdir()
    for number, name in enumerate(("b10.png", "b2.png", "a.png", ".hidden.png")):
        media.make_picture(folder / name, size=(64 + 2 * number, 48))
    outcome = program(folder / "b*.png", "%d.png")
    assert outcome.exit_code == 0, outcome.said
    assert [read(program.folder / f"{number}.png")[0].picture.shape[1] for number in (1, 2)] == [66, 66]
    assert [path.name for path in find_sequence_files(str(folder / "*.png"))] == [
        "a.png",
        "b2.png",
        "b10.png",
    ]
    (folder / "film.png").write_bytes(media.make_clip(folder / "film.mp4", frames=2).read_bytes())
    program.refused(3, "film.png is not a picture; a name with", folder / "f*.png", "%d.jpg")
    program.refused(2, "is the input itself", folder / "b*.png", "in/b%d.png", "-y")


def test_no_such_pictures(tmp_path):
    with pytest.raises(InputError, match="no such files"):
        open_reader(tmp_path / "%05d.png")


@pytest.mark.parametrize(
    ("name", "codec", "pix_fmt"),
    [("a.gif", "gif", "rgb8"), ("a.apng", "apng", "rgba"), ("a.webp", "libwebp_anim", "yuva420p")],
)
def test_animations(tmp_path, name, codec, pix_fmt):
    path = media.make_clip(tmp_path / name, frames=6, rate=10, codec=codec, pix_fmt=pix_fmt, size=(160, 90))
    with open_reader(path) as reader:
        info = reader.info
        frames = list(reader)
    assert info.is_rgb and not info.still and info.alpha == (not name.endswith("gif"))
    assert len(frames) == 6 and frames[5].time == pytest.approx(0.5, abs=0.01)
    for frame, rgb in zip(frames, media.moving_frames(6, (160, 90)), strict=True):
        assert media.rms_error(frame.picture.color, rgb) < 25


def test_an_animation_that_does_not_fit_in_memory_is_refused(tmp_path):
    path: Path = media.make_clip(tmp_path / "a.webp", frames=6, codec="libwebp_anim", pix_fmt="yuva420p")
    with pytest.raises(InputError, match="do not fit in memory"):
        open_reader(path, ReadOptions(max_pixels=160 * 90))
    with pytest.raises(InputError, match="larger than the limit"):
        open_reader(path, ReadOptions(max_pixels=160 * 89))


def test_a_damaged_animation_is_refused_in_one_line(program: Program):
    path = media.make_clip(program.folder / "a.webp", frames=3, codec="libwebp_anim", pix_fmt="yuva420p")
    program.refused(3, "not a readable video", cut(path, 0.5), "out.mkv")
