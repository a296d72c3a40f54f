"""Damaged films: what decodes is delivered, what does not is counted."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path

import av
import media
import numpy as np
import pytest

from vidstyle.errors import InputError
from vidstyle.media.frame import Frame
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.reader import open_reader


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
    assert "before the 5.0 s that its header says" in damage.report()


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
        "the input is damaged: 1 frame damaged, the last good one held, 2 frames left out that could not be "
        "decoded, 5 frames patched by the decoder"
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
