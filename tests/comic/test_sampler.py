"""Random access: a film that is opened once delivers any frame, in any order, repeatedly."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image
from stories import story, write_film

from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.core.convert import to_rgb
from vidstyle.errors import InputError
from vidstyle.media.read import reader
from vidstyle.media.read.sampler import FilmSampler


@pytest.fixture(scope="module", params=["film.mp4", "film.mkv", "film.h264"])
def film(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three shots, in containers with and without an index, and as a raw stream without timestamps."""
    folder = tmp_path_factory.mktemp("film")
    path = write_film(folder / "source.mp4", story(3, 20))
    with av.open(str(path)) as source, av.open(str(folder / request.param), "w") as target:
        stream = target.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.dts is not None:
                packet.stream = stream
                target.mux(packet)
    return folder / request.param


def small(sampler: FilmSampler, start: float = 0, end: float | None = None) -> list[tuple[Fraction, bytes]]:
    frames = sampler.frames(Fraction(start), None if end is None else Fraction(end))
    return [(each.time, to_rgb(each.picture(64)).tobytes()) for each in frames]


def test_frames_are_the_same_when_read_repeatedly(film: Path) -> None:
    with FilmSampler(film) as sampler:
        first = small(sampler)
        assert len(first) == 60
        assert small(sampler) == first
        keys = [each.time for each in sampler.key_frames(Fraction(1, 10))]
        assert keys and set(keys) <= {time for time, _ in first}
        assert small(sampler) == first


def test_a_part_is_the_same_in_a_newly_opened_film(film: Path) -> None:
    with FilmSampler(film) as sampler, FilmSampler(film) as fresh:
        small(sampler)
        assert small(sampler, 1.0, 1.5) == small(fresh, 1.0, 1.5)


def test_full_frames_can_be_read_backwards(film: Path) -> None:
    times = [2.0, 0.4, 1.2, 0.0]
    with FilmSampler(film) as sampler:
        small(sampler)
        images = [sampler.image_at(time) for time in times]
    for time, image in zip(times, images, strict=True):
        with FilmSampler(film) as fresh:
            np.testing.assert_array_equal(fresh.image_at(time), image)


def test_a_comic_opens_its_film_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened, open_media = [], reader.open_media
    monkeypatch.setattr(
        reader, "open_media", lambda *args, **options: opened.append(args) or open_media(*args, **options)
    )
    path = write_film(tmp_path / "film.mp4", story(4, 20))
    with open_film(path) as film:
        key_frames = find_key_frames(film, KeyFrameOptions(panels=4, at=(1.0,)))
        times = [each.time for each in key_frames]
        kept = list(film.frames_at(times, keep=True))
        assert all(one is other for one, other in zip(kept, film.frames_at(times), strict=True))
        for one, other in zip(kept, film.frames_at(times), strict=True):
            np.testing.assert_array_equal(one, other)
    assert len(opened) == 1


def test_a_picture_with_a_palette_is_reduced_in_true_colours(tmp_path: Path) -> None:
    stripes = np.repeat([[200, 30, 30], [30, 30, 200]], 320, axis=0).astype(np.uint8)
    picture = Image.fromarray(np.broadcast_to(stripes, (480, *stripes.shape)).copy())
    picture.quantize(2).save(tmp_path / "palette.png")
    with FilmSampler(tmp_path / "palette.png") as sampler:
        (small,) = (to_rgb(each.picture(64)) for each in sampler.frames())
    assert small.shape == (48, 64, 3)
    assert small[24, 8] == pytest.approx([200, 30, 30], abs=2)
    assert small[24, 56] == pytest.approx([30, 30, 200], abs=2)


def test_a_matrix_that_cannot_be_copied_is_named(tmp_path: Path) -> None:
    path = tmp_path / "film.mp4"
    with av.open(str(path), "w") as target:
        stream = target.add_stream("libx264", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.codec_context.colorspace = 8
        frame = av.VideoFrame(64, 48, "yuv420p")
        frame.colorspace = 8
        target.mux([*stream.encode(frame), *stream.encode()])
    with FilmSampler(path) as sampler, pytest.raises(InputError, match="YCgCo"):
        [each.stored_luma() for each in sampler.frames()]
