"""Damaged films: what decodes is delivered, what does not is counted."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import av
import cv2
import media
import numpy as np
import pytest
from faults import cut, remux

from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.reader import open_reader
from vidstyle.media.read.sampler import FilmSampler


def read(path: Path) -> tuple[list[Frame], DecodeReport]:
    with open_reader(path) as reader:
        return [item for item in reader if isinstance(item, Frame)], reader.damage


def spoiled(path: Path, numbers: set[int], keep: int = 0) -> Path:
    """The film with the content of some video packets overwritten, their first bytes kept."""
    with av.open(str(path)) as container:
        places = [(packet.pos, packet.size) for packet in container.demux(video=0) if packet.size]
    content = bytearray(path.read_bytes())
    for number in numbers:
        start, size = places[number]
        content[start + keep : start + size] = random.Random(number).randbytes(size - keep)
    target = path.with_stem("spoiled")
    target.write_bytes(content)
    return target


@pytest.mark.parametrize("codec", ["libx264", "mpeg4"])
def test_a_bad_packet_costs_one_frame(tmp_path, codec):
    path = media.make_clip(tmp_path / "clip.mp4", frames=60, codec=codec)
    frames, damage = read(spoiled(path, {20}))
    assert len(frames) == 60 and damage.is_significant
    assert damage.repeated + damage.concealed >= 1 and damage.repeated <= 1
    assert [frame.time for frame in frames] == [Fraction(number, 30) for number in range(60)]


def test_a_lost_frame_is_held_in_its_own_slot(tmp_path):
    path = media.make_clip(tmp_path / "clip.mkv", frames=12, codec="ffv1", options={"slicecrc": "1"})
    with open_reader(path) as reader:
        reader._source._decoder._context = Stumbling(reader._source._decoder._context, {5, 6})
        frames = [item for item in reader if isinstance(item, Frame)]
        assert (reader.damage.decoded, reader.damage.repeated, reader.damage.lost) == (10, 2, 0)
    assert [frame.pts for frame in frames] == [frame.pts for frame in read(path)[0]]
    assert (frames[5].picture.luma == frames[4].picture.luma).all()
    assert (frames[6].picture.luma == frames[4].picture.luma).all()
    assert (frames[7].picture.luma != frames[4].picture.luma).any()


def test_many_failures_in_a_row_cost_no_good_frame(tmp_path):
    """Twenty frames are held where twenty packets fail, and all behind them come, key frame or not."""
    path = media.make_clip(tmp_path / "clip.mp4", frames=60)
    with open_reader(path) as reader:
        reader._source._decoder._context = Stumbling(reader._source._decoder._context, set(range(31, 51)))
        frames = [item for item in reader if isinstance(item, Frame)]
        assert (reader.damage.decoded, reader.damage.repeated, reader.damage.lost) == (40, 20, 0)
    assert [frame.time for frame in frames] == [Fraction(number, 30) for number in range(60)]


class Stumbling:
    """A decoder that refuses the packets of some frames, by their number at 30 a second."""

    def __init__(self, context: av.VideoCodecContext, refused: set[int]) -> None:
        self._context, self._refused = context, refused
        self.failed, self.name = 0, context.name

    def decode(self, packet: av.Packet | None) -> list[av.VideoFrame]:
        if packet is not None and round(packet.pts * packet.time_base * 30) in self._refused:
            self.failed += 1
            raise av.InvalidDataError(1094995529, "refused")
        return self._context.decode(packet)


def test_a_truncated_mp4_knows_what_is_missing(tmp_path):
    path = media.make_clip(tmp_path / "clip.mov", frames=90)
    front = _index_first(path)
    front.write_bytes(front.read_bytes()[: front.stat().st_size * 3 // 5])
    frames, damage = read(front)
    assert 30 < len(frames) < 70 and damage.missing_frames == 90 - len(frames) and damage.is_significant
    assert damage.report() == f"the input is damaged: {90 - len(frames)} frames missing of 90"


def test_a_truncated_matroska_knows_its_length(tmp_path):
    path = media.make_clip(tmp_path / "clip.mkv", frames=150, size=(160, 90))
    whole, damage = read(path)
    assert len(whole) == 150 and not damage.is_significant and damage.report() == ""
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    frames, damage = read(path)
    assert 40 < len(frames) < 120 and damage.is_significant
    assert float(damage.missing_seconds) == pytest.approx(5 - len(frames) / 30, abs=0.1)
    assert "before the 5.0 s in its header" in damage.report()


SMALL = (160, 90)
QUICK = {"deadline": "realtime", "cpu-used": "8"}


def holed(path: Path, start: float, end: float) -> Path:
    """The film with zeros in a part of its file, between two shares of its length."""
    content = bytearray(path.read_bytes())
    first, last = int(len(content) * start), int(len(content) * end)
    content[first:last] = bytes(last - first)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("ending", ["mkv", "webm", "flv", "nut"])
def test_frames_missing_in_a_hole_are_counted(tmp_path, ending):
    codec = "libvpx" if ending == "webm" else "libx264"
    options = {"g": "15"} | (QUICK if ending == "webm" else {})
    path = media.make_clip(tmp_path / f"clip.{ending}", frames=90, codec=codec, size=SMALL, options=options)
    frames, damage = read(holed(path, 0.4, 0.6))
    assert len(frames) < 80 and abs(len(frames) + damage.missing_frames - 90) <= 2
    assert damage.is_significant and f"{damage.missing_frames} frames missing of" in damage.report()


def test_frames_missing_from_a_broadcast_are_counted(tmp_path):
    """Its packets bear numbers of four bits."""
    path = media.make_clip(tmp_path / "clip.ts", frames=90, size=SMALL, options={"g": "15"})
    content = path.read_bytes()
    packets = [content[start : start + 188] for start in range(0, len(content), 188)]
    video = [number for number, packet in enumerate(packets) if packet[1:3] in (b"\x41\x00", b"\x01\x00")]
    del packets[video[len(video) // 2] : video[len(video) // 2 + 16 * 20 + 8]]
    path.write_bytes(b"".join(packets))
    frames, damage = read(path)
    assert len(frames) < 85 and abs(len(frames) + damage.missing_frames - 90) <= 2


@pytest.mark.parametrize("ending", ["mkv", "nut", "ts", "mp4"])
def test_gaps_between_frames_alone_are_no_damage(tmp_path, ending):
    """A screen recording: frames come when something moves, and the last one is held long."""
    times = [Fraction(number, 10) for number in (0, 1, 2, 31, 32, 70, 71, 72, 73, 110)]
    path = media.make_clip(tmp_path / f"clip.{ending}", times=times, size=SMALL, audio_tracks=1)
    frames, damage = read(path)
    assert len(frames) == 10 and not damage.is_significant and damage.report() == ""


@pytest.mark.parametrize(("reordered", "seconds"), [(0, 1.25), (2, 1.0)])
def test_recordings_that_were_joined_are_no_damage(tmp_path, reordered, seconds):
    """The counters of the second film restart; its pictures wait for the end of the first one's sound."""
    options = {"bf": str(reordered)}
    clip = media.make_clip(tmp_path / "clip.mkv", frames=50, size=SMALL, audio_tracks=1, options=options)
    path = tmp_path / "clip.ts"
    with av.open(str(clip)) as source, av.open(str(path), "w") as out:
        streams = [out.add_stream_from_template(stream) for stream in source.streams]
        for packet in source.demux():
            if packet.size and (packet.stream_index or packet.pts * packet.time_base < seconds):
                packet.stream = streams[packet.stream_index]
                out.mux(packet)
    path.write_bytes(path.read_bytes() * 2)
    frames, damage = read(path)
    assert len(frames) >= 60 and not damage.is_significant


def without_first(path: Path, target: Path, count: int) -> Path:
    """The film without its first packets."""
    with av.open(str(path)) as source, av.open(str(target), "w") as out:
        stream = out.add_stream_from_template(source.streams.video[0])
        for packet in [packet for packet in source.demux(video=0) if packet.size][count:]:
            packet.stream = stream
            out.mux(packet)
    return target


@pytest.mark.parametrize("ending", ["mkv", "ts", "mp4"])
@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_a_film_that_begins_between_key_frames(tmp_path, codec, ending):
    options = {"g": "20", "bf": "0", "x265-params": "log-level=0:keyint=20:bframes=0"}
    path = media.make_clip(tmp_path / "clip.mp4", frames=40, codec=codec, size=SMALL, options=options)
    cut = without_first(path, tmp_path / f"cut.{ending}", 5)
    frames, damage = read(cut)
    assert (len(frames), damage.decoded, damage.lost) == (20, 20, 15) and damage.is_significant
    assert damage.report() == "the input is damaged: 15 frames could not be decoded"
    with FilmSampler(cut) as sampler:
        assert [len(list(sampler.frames())) for _ in range(2)] == [20, 20], "it can be gone back in"


CUT_OFF = {
    "clip.avi": ("mpeg4", "before the 2.0 s"),
    "clip.gif": ("gif", "the file is cut off"),
    "clip.ogv": ("libvpx", "the file is cut off"),
    "clip.nut": ("libx264", "the file is cut off"),
    "clip.flv": ("libx264", "before the 2.0 s"),
    "fragments.mp4": ("libx264", "the file is cut off"),
}


@pytest.mark.parametrize("name", CUT_OFF)
def test_a_file_that_is_cut_off_is_told_from_a_whole_one(tmp_path, name):
    codec, words = CUT_OFF[name]
    pix_fmt = "rgb8" if codec == "gif" else "yuv420p"
    # Not in real time, in which libvpx looks at the clock.
    options = {"deadline": "good", "cpu-used": "5"} if codec == "libvpx" else None
    path = media.make_clip(
        tmp_path / name, frames=60, codec=codec, size=SMALL, pix_fmt=pix_fmt, options=options
    )
    if name.endswith("mp4"):
        path = remux(path, tmp_path / "clip.mp4", movflags="frag_keyframe+empty_moov")
    whole, damage = read(path)
    assert len(whole) == 60 and not damage.is_significant and damage.report() == ""
    frames, damage = read(cut(path, 0.5))
    assert 0 < len(frames) < 45 and damage.is_significant and words in damage.report()


def jpeg(name: str, size: tuple[int, int]) -> bytes:
    picture = cv2.resize(media.photograph(name), size)
    return cv2.imencode(".jpg", picture[..., ::-1])[1].tobytes()


@pytest.mark.parametrize("name", ["photo.jpg", "photo.mpo", "photo.png"])
@pytest.mark.parametrize("appended", ["gain map", "film", "zeros"])
def test_the_first_picture_of_a_photograph_is_the_picture(tmp_path, name, appended):
    """Phones append gain maps, previews and films to photographs; what a player shows is the first one."""
    path = media.make_picture(tmp_path / "one.png") if name.endswith("png") else tmp_path / "one.jpg"
    first = path.read_bytes() if name.endswith("png") else jpeg("coffee", (96, 64))
    path.write_bytes(first)
    more = {"gain map": jpeg("chelsea", (48, 32)), "zeros": bytes(9000)}
    more["film"] = media.make_clip(tmp_path / "clip.mp4", frames=5).read_bytes()
    (tmp_path / name).write_bytes(first + more[appended])
    with open_reader(path) as one, open_reader(tmp_path / name) as many:
        pictures = [[item.picture for item in reader] for reader in (one, many)]
        assert many.info.still and many.damage.report() == ""
    assert len(pictures[1]) == 1
    for plane in ("luma", "color"):
        values = [getattr(found[0], plane) for found in pictures]
        assert values[0] is values[1] is None or (values[0] == values[1]).all()


def test_pictures_one_after_another_are_a_film_where_the_name_says_so(tmp_path):
    path = tmp_path / "film.mjpeg"
    path.write_bytes(jpeg("coffee", (96, 64)) + jpeg("chelsea", (96, 64)))
    assert len(read(path)[0]) == 2


def test_a_picture_in_tiles_is_refused():
    """FFmpeg opens each tile as a separate film; one tile would be shown instead of the picture."""
    with pytest.raises(InputError, match="is a picture in 2 tiles"):
        open_reader(Path(__file__).parents[1] / "fixtures" / "tiles.avif")


def test_half_a_photograph_is_damage(tmp_path):
    path = tmp_path / "photo.jpg"
    path.write_bytes(jpeg("coffee", (96, 64)))
    assert not read(path)[1].is_significant
    frames, damage = read(cut(path, 0.7))
    assert len(frames) == 1 and damage.report() == "the input is damaged: the file is cut off"


def test_good_frames_behind_a_bad_packet_at_the_end_are_kept(tmp_path):
    """Threads that work ahead have them all in hand when the film ends, and fail with the first."""
    path = media.make_clip(tmp_path / "clip.mkv", frames=30, options={"bf": "0"}, size=SMALL)
    frames, damage = read(spoiled(path, {28}, keep=5))
    assert (len(frames), damage.decoded, damage.repeated, damage.lost) == (30, 29, 1, 0)
    assert [frame.time for frame in frames] == [frame.time for frame in read(path)[0]]


def test_when_nothing_decodes_there_is_no_film(tmp_path):
    path = media.make_clip(tmp_path / "clip.mp4", frames=30)
    with pytest.raises(InputError, match="no frame could be decoded"):
        open_reader(spoiled(path, set(range(30))))


@pytest.mark.parametrize("container", ["mp4", "mkv", "ts", "avi", "webm"])
def test_flipped_bytes_never_crash(tmp_path, container):
    """A smoke test of fixed seeds: an error of ours, or frames with growing stamps."""
    codec = "libvpx-vp9" if container == "webm" else "libx264"
    path = media.make_clip(
        tmp_path / f"clip.{container}", frames=12, codec=codec, size=(160, 90), audio_tracks=1
    )
    content = path.read_bytes()
    for seed in range(12):
        chance = random.Random(seed)
        flipped = bytearray(content)
        for _ in range(200):
            flipped[chance.randrange(len(flipped))] = chance.randrange(256)
        path.write_bytes(flipped)
        try:
            frames, _ = read(path)
        except InputError:
            continue
        assert (np.diff([frame.pts for frame in frames]) > 0).all()


def test_the_report_counts_in_plain_words():
    damage = DecodeReport(decoded=97, repeated=1, lost=2, concealed=5)
    assert damage.report() == (
        "the input is damaged: 1 frame damaged and replaced by the last good one, 2 frames could not be "
        "decoded, 5 frames with errors concealed by the decoder"
    )
    assert damage.is_significant
    assert (
        not DecodeReport(decoded=1000, concealed=10).is_significant
        and DecodeReport(decoded=1000, concealed=11).is_significant
    )


def _index_first(path: Path) -> Path:
    """The film with its index before its pictures."""
    target = path.with_suffix(".mp4")
    with av.open(str(path)) as source, av.open(str(target), "w", options={"movflags": "faststart"}) as out:
        stream = out.add_stream_from_template(source.streams.video[0])
        for packet in source.demux(video=0):
            if packet.size:
                packet.stream = stream
                out.mux(packet)
    return target
