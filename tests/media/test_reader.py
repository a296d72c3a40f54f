"""The reader: every frame, upright, with its own timestamp, along with the packets of other streams."""

from __future__ import annotations

import io
import sys
from fractions import Fraction
from pathlib import Path

import av
import media
import numpy as np
import pytest

from vidstyle.core.picture import Encoding
from vidstyle.errors import InputError, UsageError
from vidstyle.media.frame import Frame, frame_from_picture, picture_from_frame
from vidstyle.media.options import RawVideo
from vidstyle.media.read.reader import ReadOptions, open_reader


def read(path: object, **options: object) -> tuple[list[Frame], list[av.Packet]]:
    """All frames and all packets."""
    with open_reader(path, ReadOptions(**options)) as reader:
        items = list(reader)
    frames = [item for item in items if isinstance(item, Frame)]
    return frames, [item for item in items if not isinstance(item, Frame)]


def seconds(frames: list[Frame]) -> list[Fraction]:
    return [frame.time for frame in frames]


def shown(frame: Frame) -> np.ndarray:
    """As a player shows it: H x W x 3, 0..255."""
    return media.rgb_from_frame(frame_from_picture(frame.picture))


def test_plain_frames_are_the_decoders_own(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=9, audio_tracks=1)
    frames, packets = read(path)
    plain = media.read_all(path)
    assert [(frame.pts, frame.time_base) for frame in frames] == [(one.pts, one.time_base) for one in plain]
    assert all(frame.native is not None for frame in frames) and frames[0].key
    assert all(
        (frame.picture.luma == shown_luma(one)).all() for frame, one in zip(frames, plain, strict=True)
    )
    with av.open(str(path)) as container:
        assert [packet.pts for packet in packets] == [one.pts for one in container.demux(audio=0) if one.size]


def test_info(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=12, rate=24, size=(322, 180), full_range=True)
    with open_reader(path) as reader:
        info = reader.info
    assert (info.width, info.height, info.frames, info.rate) == (322, 180, 12, 24)
    assert info.duration == Fraction(1, 2) and not (info.still or info.alpha or info.is_rgb)
    assert info.encoding == Encoding("bt709", full_range=True)
    assert (info.color_tags.matrix, info.color_tags.range) == (1, 2)


def test_a_copied_stream_for_everything_else(tmp_path):
    path = media.make_clip(
        tmp_path / "rich.mkv",
        audio_tracks=2,
        subtitles=["eng", "deu"],
        chapters=2,
        title="Rich",
        attachment=b"font",
    )
    with open_reader(path) as reader:
        kinds = [(stream.type, stream.language) for stream in reader.copied_streams]
        packets = [item for item in reader if not isinstance(item, Frame)]
        assert len(reader.container.chapters()) == 2 and reader.container.metadata["title"] == "Rich"
    wanted = [
        ("audio", "eng"),
        ("audio", "deu"),
        ("subtitle", "eng"),
        ("subtitle", "deu"),
        ("attachment", None),
    ]
    assert kinds == wanted
    assert {packet.stream_index for packet in packets} == {1, 2, 3, 4}
    assert sum(packet.stream_index == 3 for packet in packets) == 2


def test_variable_rate_keeps_every_stamp(tmp_path):
    times = [Fraction(number, 30) for number in range(8)] + [
        Fraction(2),
        Fraction(2) + Fraction(38, 1000),
        Fraction(4),
    ]
    frames, _ = read(media.make_clip(tmp_path / "gaps.mp4", times=times))
    assert seconds(frames) == [round(time * 90000) * Fraction(1, 90000) for time in times]


def test_broadcast_clocks_are_shifted_to_zero_all_alike(tmp_path):
    path = _at_a_time(media.make_clip(tmp_path / "clip.ts", audio_tracks=1), 65_946)
    with av.open(str(path)) as container:
        start = Fraction(container.start_time, av.time_base)
        stamps = [packet.pts * packet.time_base for packet in container.demux(audio=0) if packet.size]
    frames, packets = read(path)
    assert start > 60_000 and min(seconds(frames)[0], packets[0].pts * packets[0].time_base) == 0
    assert packets[0].pts * packets[0].time_base == pytest.approx(stamps[0] - start, abs=2e-6)
    plain = media.read_all(path)
    assert len(frames) == len(plain)
    assert (
        seconds(frames)[-1] - seconds(frames)[0]
        == plain[-1].pts * plain[-1].time_base - plain[0].pts * plain[0].time_base
    )


def test_a_small_start_is_kept(tmp_path):
    path = media.make_clip(
        tmp_path / "late.mkv", times=[Fraction(3, 1000) + Fraction(n, 25) for n in range(5)]
    )
    assert seconds(read(path)[0]) == [Fraction(3 + 40 * number, 1000) for number in range(5)]


@pytest.mark.parametrize("container", ["mp4", "mkv", "ts"])
@pytest.mark.parametrize("start", [Fraction(1, 2), Fraction(3, 2), Fraction(37, 10)])
def test_start_and_end(tmp_path, container, start):
    """Frame 15, 45 or 111 of a film with a key frame each second comes first, at zero."""
    path = media.make_clip(tmp_path / f"clip.{container}", frames=150, audio_tracks=1, size=(160, 90))
    whole, _ = read(path)
    frames, packets = read(path, start=start, end=start + Fraction(1, 2))
    first = max(number for number, frame in enumerate(whole) if frame.time <= start + Fraction(1, 1000))
    # In the transport stream the sound's priming comes first, so that frames lie between the cuts.
    assert len(frames) == (16 if container == "ts" else 15)
    assert frames[0].time < Fraction(1, 1000)
    assert abs(frames[1].time - (whole[first + 1].time - start)) < Fraction(1, 1000)
    assert (frames[0].picture.luma == whole[first].picture.luma).all()
    times = [packet.pts * packet.time_base for packet in packets]
    assert times and 0 <= times[0] < 0.03 and times[-1] < 0.5


def test_start_between_two_frames_shows_the_first_of_them(tmp_path):
    path = media.make_clip(tmp_path / "slow.mp4", times=[Fraction(n) for n in range(5)], size=(160, 90))
    frames, _ = read(path, start=Fraction(8, 5), end=Fraction(16, 5))
    whole, _ = read(path)
    assert seconds(frames) == [0, Fraction(2, 5), Fraction(7, 5)]
    assert (frames[0].picture.luma == whole[1].picture.luma).all()


def test_a_start_in_a_raw_stream_and_in_a_pipe(tmp_path, monkeypatch):
    raw = media.make_clip(tmp_path / "clip.h264", frames=60, size=(160, 90))
    assert len(read(raw, start=Fraction(1))[0]) == 60 - 25, "25 frames a second are assumed"
    film = media.make_clip(tmp_path / "clip.mkv", frames=60, size=(160, 90))
    monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": _Pipe(film.read_bytes())}))
    assert len(read("-", start=Fraction(1))[0]) == 30


def test_subtitles_that_are_on_the_screen_at_the_start_stay(tmp_path):
    path = media.make_clip(tmp_path / "lines.mkv", frames=60, subtitles=["eng"], size=(160, 90))
    _, packets = read(path, start=Fraction(1, 2))
    assert [(packet.pts, packet.duration) for packet in packets] == [(0, 300), (500, 800)]


def test_times_that_make_no_sense(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=5)
    with pytest.raises(InputError, match="no frame between"):
        open_reader(path, ReadOptions(start=Fraction(100)))
    with pytest.raises(UsageError):
        open_reader(path, ReadOptions(start=Fraction(2), end=Fraction(1)))


@pytest.mark.parametrize(
    ("fps", "count"), [(Fraction(15), 15), (Fraction(60), 60), (Fraction(24000, 1001), 24)]
)
def test_another_rate_takes_the_nearest_frame(tmp_path, fps, count):
    path = media.make_clip(tmp_path / "clip.mp4", frames=30, size=(160, 90))
    whole, _ = read(path)
    frames, _ = read(path, fps=fps)
    assert len(frames) == count and seconds(frames) == [number / fps for number in range(count)]
    for frame in frames:
        nearest = min(whole, key=lambda one: (abs(one.time - frame.time), one.time))
        distance = min(abs(one.time - frame.time) for one in whole)
        matches = [one for one in whole if abs(one.time - frame.time) == distance]
        assert any((one.picture.luma == frame.picture.luma).all() for one in [nearest, *matches])


@pytest.mark.parametrize("rotation", [90, 180, -90])
def test_turned_films_come_upright_once(tmp_path, rotation):
    path = media.make_clip(
        tmp_path / "turned.mp4", frames=2, rotation=rotation, sample_aspect=Fraction(16, 15)
    )
    frames, _ = read(path)
    expected = np.rot90(next(media.moving_frames(1, (160, 90))), rotation // 90)
    assert frames[0].picture.shape == expected.shape[:2] and frames[0].native is None
    with open_reader(path) as reader:
        info = reader.info
    assert (info.height, info.width) == expected.shape[:2]
    assert info.sample_aspect == (Fraction(16, 15) if rotation == 180 else Fraction(15, 16))
    small = expected[::4, ::4].astype(int)
    assert media.rms_error(_raw_rgb(frames[0])[::4, ::4], small) < 12


def test_a_turn_that_is_asked_for_replaces_the_films_own(tmp_path):
    path = media.make_clip(tmp_path / "turned.mp4", frames=1, rotation=90)
    assert read(path, rotate=0)[0][0].picture.shape == (90, 160)
    with pytest.raises(UsageError):
        open_reader(path, ReadOptions(rotate=45))


def test_a_turned_film_of_4_2_2_has_its_chroma_halved_downwards(tmp_path):
    path = media.make_clip(tmp_path / "turned.mp4", frames=1, rotation=90, pix_fmt="yuv422p")
    picture = read(path)[0][0].picture
    assert picture.encoding.subsampling == (1, 2) and picture.chroma[0].shape == (80, 90)


@pytest.mark.parametrize(
    ("size", "delivered"),
    [((160, 90), (160, 90)), ((160, -1), (160, 90)), ((-2, 121), (216, 121)), ((640, 360),) * 2],
)
def test_another_size(tmp_path, size, delivered):
    path = media.make_clip(tmp_path / "clip.mp4", frames=1, size=(320, 180))
    frames, _ = read(path, size=size)
    assert frames[0].picture.shape == delivered[::-1]
    import cv2

    expected = cv2.resize(next(media.moving_frames(1)), delivered, interpolation=cv2.INTER_AREA)
    assert media.rms_error(shown(frames[0]), expected) < 6


def test_another_shape_keeps_the_display_aspect(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=1, size=(320, 180))
    with open_reader(path, ReadOptions(size=(320, 90))) as reader:
        assert reader.info.sample_aspect == Fraction(1, 2)


def test_interlaced_films_are_deinterlaced_and_said_so(tmp_path, caplog):
    path = media.make_clip(
        tmp_path / "tv.mp4", size=(320, 180), frames=12, interlaced=True, options={"x264-params": "tff=1"}
    )
    frames, _ = read(path)
    plain = media.read_all(path)
    assert [frame.pts for frame in frames] == [frame.pts for frame in plain]
    assert caplog.text.count("bwdif") == 1
    assert _combing(frames[5].picture.luma) < 0.5 * _combing(shown_luma(plain[5]))


def test_the_longer_of_two_films_is_taken(tmp_path, caplog):
    caplog.set_level("INFO")
    one = media.make_clip(tmp_path / "one.mp4", frames=3)
    two = media.make_clip(tmp_path / "two.mp4", frames=9, size=(160, 90))
    path = tmp_path / "both.mkv"
    with av.open(str(one)) as first, av.open(str(two)) as second, av.open(str(path), "w") as container:
        streams = [container.add_stream_from_template(opened.streams.video[0]) for opened in (first, second)]
        for opened, stream in zip((first, second), streams, strict=True):
            for packet in opened.demux(video=0):
                if packet.size:
                    packet.stream = stream
                    container.mux(packet)
    frames, packets = read(path)
    assert len(frames) == 9 and frames[0].picture.shape == (90, 160) and not packets
    assert "stream 1, the longest, is used" in caplog.text


def test_sizes_that_change_are_fitted_into_the_first(tmp_path, caplog):
    """Two raw H.264 streams of two sizes, one after the other, without any timestamps."""
    path = tmp_path / "both.h264"
    parts = [
        media.make_clip(tmp_path / f"{n}.h264", frames=5, size=size)
        for n, size in enumerate([(320, 180), (90, 180)])
    ]
    path.write_bytes(b"".join(part.read_bytes() for part in parts))
    frames, _ = read(path)
    assert len(frames) == 10 and {frame.picture.shape for frame in frames} == {(180, 320)}
    assert seconds(frames) == sorted(set(seconds(frames)))
    assert caplog.text.count("frame size changes") == 1
    assert caplog.text.count("no timestamps") <= 1
    last = frames[-1].picture
    assert (last.luma[:, :100] == 16).all() and (last.chroma[0][:, :50] == 128).all()
    assert last.luma[:, 120:200].std() > 10


def test_alpha_is_kept(tmp_path):
    for name, codec in (("clip.mkv", "ffv1"), ("clip.webm", "libvpx-vp9")):
        path = media.make_clip(tmp_path / name, frames=2, codec=codec, pix_fmt="yuva420p")
        with open_reader(path) as reader:
            assert reader.info.alpha
            frame = next(item for item in reader if isinstance(item, Frame))
        assert np.abs(frame.picture.alpha.astype(int) - media.alpha_ramp(90, 160)).max() < 12


def test_films_on_standard_input(tmp_path, monkeypatch):
    for name in ("clip.nut", "clip.mkv", "clip.y4m"):
        codec = "wrapped_avframe" if name.endswith("y4m") else "ffv1"
        path = tmp_path / name
        if codec == "ffv1":
            media.make_clip(path, frames=4, codec=codec)
        else:
            _write_y4m(path, 4)
        monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": _Pipe(path.read_bytes())}))
        frames, _ = read("-")
        assert len(frames) == 4 and frames[-1].time == pytest.approx(0.1, abs=1e-3)


def test_raw_video_on_standard_input(monkeypatch):
    planes = [media.planes_from_rgb(rgb / 255) for rgb in media.moving_frames(3, (64, 48))]
    content = b"".join(plane.tobytes() for frame in planes for plane in frame)
    monkeypatch.setattr(sys, "stdin", type("Stdin", (), {"buffer": _Pipe(content)}))
    frames, _ = read("-", format="rawvideo", raw=RawVideo((64, 48)), rate=Fraction(30000, 1001))
    assert (frames[2].picture.luma == planes[2][0]).all() and frames[2].time == Fraction(2002, 30000)


def _at_a_time(path: Path, start: int) -> Path:
    """Copy a film with all timestamps shifted by N seconds."""
    moved = path.with_stem("moved")
    with av.open(str(path)) as source, av.open(str(moved), "w") as target:
        streams = {stream.index: target.add_stream_from_template(stream) for stream in source.streams}
        for packet in source.demux():
            if packet.size:
                packet.pts += start * 90_000
                packet.dts += start * 90_000
                packet.stream = streams[packet.stream_index]
                target.mux(packet)
    return moved


def shown_luma(frame: av.VideoFrame) -> np.ndarray:
    return media.plane_samples(frame.planes[0], 8)


def _raw_rgb(frame: Frame) -> np.ndarray:
    """The colours with chroma repeated, wherever it is sited."""
    picture = frame.picture
    across, down = picture.encoding.subsampling
    raised = [np.repeat(np.repeat(plane, down, 0), across, 1) for plane in picture.chroma]
    height, width = picture.shape
    planes = [picture.luma] + [plane[:height, :width] for plane in raised]
    values = [(planes[0] - 16.0) / 219, (planes[1] - 128.0) / 224, (planes[2] - 128.0) / 224]
    return 255 * np.clip(np.dstack(values) @ picture.encoding.to_rgb.T, 0, 1)


def _combing(luma: np.ndarray) -> float:
    """How much rows differ from both their neighbours."""
    rows = luma.astype(int)
    return float(np.abs(2 * rows[1:-1] - rows[:-2] - rows[2:]).mean())


def _write_y4m(path: Path, frames: int) -> None:
    planes = [media.planes_from_rgb(rgb / 255) for rgb in media.moving_frames(frames, (64, 48))]
    body = b"".join(b"FRAME\n" + b"".join(plane.tobytes() for plane in frame) for frame in planes)
    path.write_bytes(b"YUV4MPEG2 W64 H48 F30:1 Ip A1:1 C420mpeg2\n" + body)


class _Pipe(io.BytesIO):
    """Standard input: it cannot go back."""

    def seekable(self) -> bool:
        return False

    def seek(self, *_: int) -> int:
        raise OSError("a pipe")


def test_the_first_frame_is_converted_once(tmp_path, monkeypatch):
    converted = []

    def count(frame, *given, **named):
        converted.append(frame)
        return picture_from_frame(frame, *given, **named)

    monkeypatch.setattr("vidstyle.media.read.frame_converter.picture_from_frame", count)
    path = media.make_clip(tmp_path / "clip.mp4", frames=5)
    with open_reader(path) as reader:
        frames = [item for item in reader if isinstance(item, Frame)]
    assert len(converted) == len(frames) == 5
