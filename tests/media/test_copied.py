"""Audio, subtitles, covers, fonts, chapters and tags: copied, or converted where the container needs it."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from media import make_clip, read_all

from vidstyle.errors import UsageError
from vidstyle.media.read.reader import open_reader
from vidstyle.media.write.interleaver import Interleaver
from vidstyle.media.write.stream_copy import portable_tags
from vidstyle.media.write.writer import WriteOptions, open_writer


def copy(source: Path, target: Path, audio: str = "copy") -> Path:
    with (
        open_reader(source) as reader,
        open_writer(target, reader.info, WriteOptions(audio=audio), reader) as writer,
    ):
        for item in reader:
            writer.write(item)
    return target


def packets(path: Path, kind: str, number: int = 0) -> list[tuple[float, bytes]]:
    with av.open(str(path)) as container:
        stream = getattr(container.streams, kind)[number]
        found = [packet for packet in container.demux(stream) if packet.size]
        return [(float(packet.pts * packet.time_base), bytes(packet)) for packet in found]


def heard(path: Path) -> tuple[np.ndarray, float]:
    """The first sound track: mono samples at 48 kHz, and when they begin."""
    resampler = av.AudioResampler("flt", "mono", 48000)
    with av.open(str(path)) as container:
        frames = [part for frame in container.decode(audio=0) for part in resampler.resample(frame)]
        frames += resampler.resample(None)
    return np.concatenate([frame.to_ndarray()[0] for frame in frames]), float(frames[0].time)


@pytest.fixture(scope="module")
def full(tmp_path_factory) -> Path:
    """A film with all that Matroska can hold."""
    path = tmp_path_factory.mktemp("full") / "full.mkv"
    return make_clip(
        path,
        frames=90,
        size=(64, 48),
        audio_tracks=2,
        subtitles=["eng", "deu"],
        chapters=2,
        title="A title",
        attachment=b"a font" * 99,
    )


@pytest.mark.parametrize("ending", [".mkv", ".mp4", ".mov"])
def test_sound_is_the_same_to_the_byte_and_the_millisecond(full, tmp_path, ending):
    target = copy(full, tmp_path / f"out{ending}")
    for number in range(2):
        before, after = packets(full, "audio", number), packets(target, "audio", number)
        assert [content for _, content in after] == [content for _, content in before]
        assert [time for time, _ in after] == pytest.approx([time for time, _ in before], abs=0.001)


@pytest.mark.parametrize("ending", [".mkv", ".mp4", ".mov", ".webm"])
def test_languages_chapters_and_the_title_stay(full, tmp_path, ending):
    with av.open(str(copy(full, tmp_path / f"out{ending}"))) as container:
        languages = ["eng", "ger" if ending == ".mov" else "deu"]
        assert [stream.language for stream in container.streams.audio] == languages
        assert [stream.language for stream in container.streams.subtitles][:2] == languages
        assert container.metadata["title"] == "A title"
        chapters = [
            (float(chapter["start"] * chapter["time_base"]), chapter["metadata"]["title"])
            for chapter in container.chapters()
        ]
        assert chapters == [(0.0, "Part 1"), (1.5, "Part 2")]


def test_fonts_stay_where_they_can(full, tmp_path, caplog):
    with av.open(str(copy(full, tmp_path / "out.mkv"))) as container:
        (font,) = container.streams.attachments
        assert (font.name, font.mimetype, font.data) == (
            *("font.ttf", "application/x-truetype-font"),
            b"a font" * 99,
        )
    assert "dropped" not in caplog.text
    copy(full, tmp_path / "out.mp4")
    assert "font.ttf" in caplog.text and "dropped" in caplog.text


@pytest.mark.parametrize(("ending", "codec"), [(".mp4", "mov_text"), (".webm", "webvtt"), (".mkv", "subrip")])
def test_subtitles_keep_their_words_and_times(full, tmp_path, ending, codec):
    target = copy(full, tmp_path / f"out{ending}")
    with av.open(str(target)) as container:
        stream = container.streams.subtitles[0]
        assert stream.codec_context.codec.canonical_name == codec
        found = []
        for packet in container.demux(stream):
            for line in stream.decode(packet) if packet.size else []:
                found.append((float(packet.pts * packet.time_base), line.dialogue.decode()))
    assert found == [(0.0, "eng line 1"), (1.5, "eng line 2")]


def test_timed_text_of_mp4_becomes_subrip(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=60, subtitles=["fra"])
    lines = packets(copy(clip, tmp_path / "out.mkv"), "subtitles")
    assert lines == [(0.0, b"fra line 1"), (1.0, b"fra line 2")]


@pytest.mark.parametrize(("ending", "codec"), [(".webm", "opus"), (".avi", "mp3"), (".ogv", "opus")])
def test_sound_that_cannot_be_held_is_encoded_anew_in_time(tmp_path, caplog, ending, codec):
    clip = make_clip(tmp_path / "clip.mp4", frames=60, audio_tracks=1, size=(64, 48))
    target = copy(clip, tmp_path / f"out{ending}")
    assert "re-encoded" in caplog.text
    with av.open(str(target)) as container:
        assert container.streams.audio[0].codec_context.codec.canonical_name == codec
        shift = float(container.streams.video[0].start_time or 0) * float(
            container.streams.video[0].time_base
        )
    (before, begins), (after, starts) = heard(clip), heard(target)
    late = round((starts - begins - shift) * 48000)
    span = slice(24000, 48000)
    # The tone repeats each 160 samples: compared within half of that, and by phase.
    moved = after[span.start - late : span.stop - late]
    quiet = np.abs(before[span] - moved).max()
    assert len(after) / 48000 == pytest.approx(2.0, abs=0.08)
    assert quiet < 0.25, "the sound is out of phase"


def test_sound_may_be_left_out_or_encoded_by_name(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", audio_tracks=1)
    with av.open(str(copy(clip, tmp_path / "silent.mp4", "none"))) as container:
        assert not container.streams.audio
    with av.open(str(copy(clip, tmp_path / "out.mp4", "libmp3lame"))) as container:
        assert container.streams.audio[0].codec_context.codec.canonical_name == "mp3"


@pytest.mark.parametrize("audio", ["nonsense", "libx264", "libopus"])
def test_an_audio_encoder_that_does_not_fit_is_refused(tmp_path, audio):
    clip = make_clip(tmp_path / "clip.mp4", audio_tracks=1)
    with pytest.raises(UsageError, match="--audio"):
        copy(clip, tmp_path / "out.mov", audio)
    assert list(tmp_path.iterdir()) == [clip]


def test_sound_of_a_film_that_was_cut_off_ends_with_the_pictures(tmp_path, caplog):
    clip = make_clip(tmp_path / "clip.mp4", frames=90, audio_tracks=1)
    whole = copy(clip, tmp_path / "whole.mp4")
    with av.open(str(whole)) as container:
        places = [packet.pos for packet in container.demux(video=0) if packet.size]
        sounds = [packet.pos for packet in container.demux(audio=0) if packet.size]
    assert places is not None and sounds is not None
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            if not hasattr(item, "picture") or item.time < 1:
                writer.write(item)
        reader.damage.lost = 60
        writer.finish()
    end = packets(tmp_path / "out.mp4", "audio")[-1][0]
    assert len(read_all(tmp_path / "out.mp4")) == 30
    assert 0.9 < end < 1.0 and "after the last picture were dropped" in caplog.text


def test_sound_longer_than_the_pictures_is_kept(tmp_path):
    clip = make_clip(tmp_path / "clip.mp4", frames=60, audio_tracks=1)
    with open_reader(clip) as reader:
        writer = open_writer(tmp_path / "out.mp4", reader.info, WriteOptions(), reader)
        for item in reader:
            if not hasattr(item, "picture") or item.time < 1:
                writer.write(item)
        writer.finish()
    assert packets(tmp_path / "out.mp4", "audio") == packets(clip, "audio")


def test_packets_out_of_order_never_reach_the_muxer(tmp_path):
    with av.open(str(tmp_path / "out.mkv"), "w") as container:
        stream = container.add_stream("pcm_s16le", rate=8000)
        interleaver = Interleaver(container)
        for dts in (0, 100, 99, 100, 5, 200, None):
            packet = av.Packet(bytes(20))
            packet.stream, packet.time_base, packet.duration = stream, Fraction(1, 1000), 2
            packet.pts = packet.dts = dts
            interleaver.push(packet)
        interleaver.finish(None)
    assert (interleaver.shifted, interleaver.dropped) == (2, 2)
    times = [round(time * 1000) for time, _ in packets(tmp_path / "out.mkv", "audio")]
    assert times == [0, 100, 101, 102, 200]


def test_tags_of_the_old_file_are_not_carried_over():
    tags = {"title": "Rain", "ENCODER": "x", "BPS-eng": "9", "_STATISTICS_TAGS": "y", "artist": "z"}
    assert portable_tags(tags) == {"title": "Rain", "artist": "z"}
