"""Frames that a decoder or demuxer loses without an error: shown, or counted as missing."""

from __future__ import annotations

from pathlib import Path

import av
import pytest
from media import make_clip

from vidstyle.media.frame import Frame
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.reader import open_reader

FRAMES = 10
SMALL = (64, 48)


def read(path: Path) -> tuple[int, DecodeReport]:
    with open_reader(path) as reader:
        return sum(isinstance(item, Frame) for item in reader), reader.damage


def packets(path: Path, kind: str = "video") -> list[tuple[int, int]]:
    """Return offsets and sizes of the packets of a stream."""
    with av.open(str(path)) as container:
        return [(packet.pos, packet.size) for packet in container.demux(**{kind: 0}) if packet.size]


def overwrite(path: Path, offset: int, content: bytes) -> Path:
    with path.open("r+b") as file:
        file.seek(offset)
        file.write(content)
    return path


def test_frames_behind_a_damaged_first_one_are_shown(tmp_path):
    """Threads of a decoder that are flushed stop at the first error."""
    path = make_clip(tmp_path / "film.mov", frames=3, size=SMALL, codec="prores_ks", pix_fmt="yuv422p10le")
    start, size = packets(path)[0]
    frames, damage = read(overwrite(path, start, bytes(size)))
    assert (frames, damage.lost) == (2, 1)


def test_a_last_frame_that_a_threaded_decoder_drops_is_counted(tmp_path):
    svt = {"svtav1-params": "lp=1"}
    path = make_clip(tmp_path / "film.mkv", frames=FRAMES, size=SMALL, codec="libsvtav1", options=svt)
    start, size = packets(path)[-1]
    frames, damage = read(overwrite(path, start + 4, b"\xff" * (size - 4)))
    assert frames + damage.lost == FRAMES and damage.lost == 1


class Forgetful:
    """A decoder that returns nothing for some frames of a Matroska film of 30 a second, and no error."""

    def __init__(self, context: av.VideoCodecContext, dropped: set[int]) -> None:
        self._context, self._dropped = context, dropped

    def decode(self, packet: av.Packet | None) -> list[av.VideoFrame]:
        frames = self._context.decode(packet)
        return [frame for frame in frames if round(frame.pts * 30 / 1000) not in self._dropped]


@pytest.mark.parametrize(("codec", "lost"), [("libx265", 1), ("libvpx", 0)])
def test_a_frame_that_a_decoder_drops_is_counted_where_every_packet_shows_one(tmp_path, codec, lost):
    """Packets of VP8 may show nothing."""
    path = make_clip(tmp_path / "film.mkv", frames=60, size=SMALL, codec=codec)
    with open_reader(path) as reader:
        reader._source._decoder._context = Forgetful(reader._source._decoder._context, {45})
        assert sum(isinstance(item, Frame) for item in reader) == 59
        assert reader.damage.lost == lost and reader.damage.is_significant == bool(lost)


def test_a_film_without_key_frames_is_shown_as_far_as_it_decodes(tmp_path):
    whole = make_clip(tmp_path / "whole.mkv", frames=FRAMES, size=SMALL, options={"bf": "0"})
    path = tmp_path / "film.mkv"
    with av.open(str(whole)) as given, av.open(str(path), "w") as made:
        stream = made.add_stream_from_template(given.streams.video[0])
        for packet in given.demux(video=0):
            if packet.size and not packet.is_keyframe:
                packet.stream = stream
                made.mux(packet)
    frames, damage = read(path)
    assert frames > 5 and damage.concealed == frames and damage.is_significant


@pytest.mark.parametrize("damaged", [2, 4])
def test_frames_behind_damaged_sound_in_matroska_are_counted(tmp_path, damaged):
    path = make_clip(tmp_path / "film.mkv", frames=FRAMES, size=SMALL, audio_tracks=1)
    start, _ = packets(path, "audio")[damaged]
    overwrite(path, start + 3, b"\x06\xff")  # a block of 256 packets, with sizes that make no sense
    frames, damage = read(path)
    assert frames < FRAMES and frames + damage.missing_frames == FRAMES
    assert f"{damage.missing_frames} frames missing of {FRAMES}" in damage.report()


def test_a_whole_matroska_film_lacks_nothing_at_its_end(tmp_path):
    path = make_clip(tmp_path / "film.mkv", frames=FRAMES, size=SMALL, audio_tracks=1, subtitles=["eng"])
    content = path.read_bytes()
    assert read(path)[1].report() == ""
    path.write_bytes(content + bytes(2**20))
    assert read(path)[1].report() == "", "no element begins with a zero"
    path.write_bytes(content + b"\xec\x01" + b"\xff" * 7)  # longer than any file
    assert read(path)[1].report() == ""


def test_a_packet_of_another_codec_in_flv_is_counted(tmp_path):
    path = make_clip(tmp_path / "film.flv", frames=FRAMES, size=SMALL, codec="flv")
    start, _ = packets(path)[5]
    tag = path.read_bytes().index(b"\x22", start)  # an inter frame of Sorenson H.263
    frames, damage = read(overwrite(path, tag, b"\x24"))  # of VP6
    assert (frames, damage.unmatched_packets) == (FRAMES - 1, 1)
    assert "1 packet without a matching stream" in damage.report()


def test_damage_in_the_second_of_two_joined_gifs_is_reported(tmp_path):
    path = make_clip(tmp_path / "film.gif", frames=3, size=SMALL, codec="gif", pix_fmt="rgb8")
    one = path.read_bytes()
    path.write_bytes(one + one)
    assert read(path)[1].report() == ""
    start = packets(path)[4][0]
    assert read(overwrite(path, start, b"\x7f"))[1].cut_off
    path.write_bytes(one + b"not a GIF")
    assert read(path)[1].report() == "", "data after the end is not part of the film"
