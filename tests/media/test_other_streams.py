"""Sound and subtitles that are late, missing or damaged: pictures are kept, in sync."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from media import make_clip

from vidstyle.media.frame import Frame
from vidstyle.media.read.reader import ReadOptions, open_reader
from vidstyle.media.write import film_writer
from vidstyle.media.write.resume_source import count_frames
from vidstyle.media.write.writer import WriteOptions, open_writer
from vidstyle.pipeline.progress import Summary
from vidstyle.pipeline.render import render

FRAME_RATE, RATE = 25, 48000
ENDINGS = ".mp4 .mov .mkv .webm .avi .ts .ogv .flv .wmv .nut".split()
CODECS = "aac ac3 eac3 flac libopus libmp3lame mp2 vorbis alac wavpack pcm_s16le pcm_s16be pcm_f32le".split()
Spoil = Callable[[int, bytes], bytes]
"""Gives the content of a packet of sound, from its number and what it was; empty: it is left out."""


def film(
    path: Path,
    *codecs: str,
    begin: float = 0.0,
    seconds: float = 2.0,
    spoil: Spoil | None = None,
    astray: int = 0,
) -> Path:
    """A film with a beep in its last 0.2 s, in a track for each codec, from `begin` on, and spoilt.

    The last packet of each track is `astray` hours late.
    """
    with av.open(str(path), "w") as container:
        screen = container.add_stream("mpeg4", rate=FRAME_RATE)
        screen.width, screen.height, screen.pix_fmt = 64, 48, "yuv420p"
        speakers = [_speaker(container, codec) for codec in codecs]
        container.start_encoding()
        packets = []
        for number in range(round(seconds * FRAME_RATE)):
            frame = av.VideoFrame(64, 48, "yuv420p")
            for plane in frame.planes:
                plane.update(bytes([(5 * number) % 256]) * plane.buffer_size)
            frame.pts, frame.time_base = number, Fraction(1, FRAME_RATE)
            packets += screen.encode(frame)
        packets += screen.encode(None)
        for speaker in speakers:
            heard = _beep(speaker, begin, seconds)
            if spoil:
                contents = [spoil(number, bytes(packet)) for number, packet in enumerate(heard)]
                heard = [spoilt(*each) for each in zip(heard, contents, strict=True) if each[1]]
            heard[-1].pts = heard[-1].dts = heard[-1].dts + int(astray * 3600 / heard[-1].time_base)
            packets += heard
        for packet in sorted(packets, key=lambda packet: packet.dts * packet.time_base):
            container.mux(packet)
    return path


def _speaker(container: av.container.OutputContainer, codec: str) -> av.audio.stream.AudioStream:
    speaker = container.add_stream(codec, rate=RATE)
    speaker.layout = "stereo"
    speaker.format = av.Codec(codec, "w").audio_formats[0]
    speaker.codec_context.options = {"strict": "-2"}
    speaker.codec_context.open()
    return speaker


def _beep(speaker: av.audio.stream.AudioStream, begin: float, seconds: float) -> list[av.Packet]:
    moments = np.arange(round(begin * RATE), round(seconds * RATE))
    tone = np.sin(moments * 0.2) * 12000 * (moments > (seconds - 0.2) * RATE)
    sound = av.AudioFrame.from_ndarray(np.repeat(tone, 2).astype(np.int16)[None], "s16", "stereo")
    sound.sample_rate, sound.pts, sound.time_base = RATE, round(begin * RATE), Fraction(1, RATE)
    size = speaker.codec_context.frame_size
    size = size if 0 < size < 10000 else 1024
    resampler = av.AudioResampler(speaker.format, "stereo", RATE, frame_size=size)
    parts = [*resampler.resample(sound), *resampler.resample(None), None]
    return [packet for part in parts for packet in speaker.encode(part)]


def spoilt(packet: av.Packet, content: bytes) -> av.Packet:
    """A packet like another, with other content."""
    made = av.Packet(content)
    made.pts, made.dts, made.duration, made.time_base = (
        *(packet.pts, packet.dts, packet.duration),
        packet.time_base,
    )
    made.stream, made.is_keyframe = packet.stream, packet.is_keyframe
    return made


def rendered(source: Path, target: Path, end: Fraction | None = None, audio: str = "copy") -> Summary:
    """Render, check that all pictures are written, and return the messages."""
    write = WriteOptions(overwrite=True, audio=audio)
    summary = render(source, target, "plain", read=ReadOptions(end=end), write=write, device="cpu")
    with av.open(str(source)) as container:
        count = sum(packet.size > 0 for packet in container.demux(video=0))
    if end is not None:
        count = min(count, -(-end * FRAME_RATE // 1))
    assert count_frames(target) == summary.frames == count
    assert not list(target.parent.glob("*.partial*"))
    return summary


def beep(path: Path) -> float:
    """When the first sound begins, in seconds."""
    with av.open(str(path)) as container:
        for frame in container.decode(audio=0):
            samples = frame.to_ndarray().astype(float)
            full = 1 if frame.format.name.startswith("flt") else 32768
            if np.abs(samples).max() > 0.1 * full:
                return float(frame.time)
    raise AssertionError("the sound is silent")


@pytest.mark.parametrize(
    ("codec", "ending"), [("ac3", ".mp4"), ("eac3", ".mp4"), ("ac3", ".mov"), ("aac", ".mp4")]
)
def test_a_cut_without_sound_keeps_its_pictures(tmp_path, caplog, codec, ending):
    late = film(tmp_path / "late.mkv", codec, begin=1.0)
    summary = rendered(late, tmp_path / f"out{ending}", end=Fraction(1, 2))
    assert summary.exit_code == 0
    assert ("is dropped, because it has no packet" in caplog.text) == (codec != "aac" and ending == ".mp4")


def test_late_sound_is_copied_and_else_encoded_anew(tmp_path, caplog, monkeypatch):
    late, target = film(tmp_path / "late.mkv", "ac3", begin=1.5), tmp_path / "out.mp4"
    for wait, codec in ((Fraction(30), "ac3"), (Fraction(1), "aac")):
        monkeypatch.setattr(film_writer, "MAX_NEEDED_WAIT_SECONDS", wait)
        rendered(late, target)
        with av.open(str(target)) as container:
            assert container.streams.audio[0].codec_context.codec.canonical_name == codec
        assert beep(target) == pytest.approx(1.8, abs=0.03)
    assert "re-encoded as aac, because .mp4 files need a valid early packet of it" in caplog.text


@pytest.mark.parametrize(
    ("codec", "ending", "begin"), [("ac3", ".avi", 0.5), ("pcm_s16le", ".avi", 6.5), ("flac", ".ogv", 1.0)]
)
def test_late_sound_is_late_where_the_container_holds_no_times(tmp_path, caplog, codec, ending, begin):
    late, target = (
        film(tmp_path / "late.mkv", codec, begin=begin, seconds=begin + 1),
        tmp_path / f"out{ending}",
    )
    rendered(late, target)
    assert beep(target) == pytest.approx(begin + 0.8, abs=0.03)
    assert f"because it starts late, which {ending} files do not support" in caplog.text


def test_gaps_in_sound_that_a_container_closes_are_told(tmp_path, caplog):
    source = film(tmp_path / "in.mkv", "ac3", spoil=lambda number, content: content * (not 10 <= number < 20))
    rendered(source, tmp_path / "out.mkv")
    assert "gaps" not in caplog.text
    rendered(source, tmp_path / "out.avi")
    reason = "because .avi files store no timestamps of sound"
    assert f"0.3 s of gaps in the sound are closed, {reason}" in caplog.text


@pytest.mark.parametrize("ending", [".mp4", ".mov"])
def test_a_film_is_on_the_disk_while_its_sound_has_not_begun(tmp_path, ending):
    late = film(tmp_path / "late.mkv", "aac", begin=2.9, seconds=3.0)
    with open_reader(late) as reader:
        writer = open_writer(tmp_path / f"out{ending}", reader.info, WriteOptions(preset="ultrafast"), reader)
        for item in reader:
            if isinstance(item, Frame) and item.time >= Fraction(5, 2):
                break
            writer.write(item)
        assert writer.partial and count_frames(writer.partial, whole=False) > 25
        writer.abandon()


def zeros(number: int, content: bytes) -> bytes:
    """Every seventh packet is zeros."""
    return bytes(len(content)) if number % 7 == 3 else content


def torn(number: int, content: bytes) -> bytes:
    """Every packet lacks its header."""
    return b"\x55" * min(8, len(content)) + content[8:]


@pytest.mark.parametrize(
    ("codec", "ending", "audio"),
    [
        ("ac3", ".mp4", "copy"),
        ("ac3", ".webm", "copy"),
        ("aac", ".mkv", "libopus"),
        ("flac", ".webm", "copy"),
    ],
)
def test_damaged_packets_of_sound_cost_their_own_time(tmp_path, codec, ending, audio):
    source = film(tmp_path / "in.mkv", codec, spoil=zeros)
    summary = rendered(source, tmp_path / f"out{ending}", audio=audio)
    assert summary.exit_code == 4 and "stream 1 (audio) lost" in summary.damage
    assert beep(tmp_path / f"out{ending}") == pytest.approx(1.8, abs=0.05)


@pytest.mark.parametrize("ending", [".mp4", ".mov", ".webm"])
def test_sound_of_which_nothing_can_be_used_is_no_reason_to_fail(tmp_path, ending):
    summary = rendered(film(tmp_path / "in.mkv", "ac3", spoil=torn), tmp_path / f"out{ending}")
    assert summary.exit_code == (0 if ending == ".mov" else 4)


@pytest.mark.parametrize(("codec", "ending"), [("pcm_s16le", ".avi"), ("aac", ".mp4"), ("ac3", ".mkv")])
def test_sound_with_a_time_hours_away_makes_the_film_no_longer(tmp_path, codec, ending):
    summary = rendered(film(tmp_path / "in.mkv", codec, astray=5), tmp_path / f"out{ending}")
    assert summary.exit_code == 4 and summary.damage.endswith("its clock jumps once (bridged)")
    with av.open(str(tmp_path / f"out{ending}")) as container:
        assert container.duration < 3 * av.time_base


@pytest.mark.parametrize("ending", [".mov", ".ts"])
def test_aac_that_has_lost_its_headers_is_counted_once(tmp_path, ending):
    """It is first tested in a separate file, whose losses do not count."""
    source = make_clip(tmp_path / "in.flv", codec="flv", size=(64, 48), frames=10, audio_tracks=1)
    headers, packet = b"\xaf\x00", b"\xaf\x01"
    source.write_bytes(source.read_bytes().replace(headers, packet, 1))
    with av.open(str(source)) as container:
        count = sum(packet.size > 0 for packet in container.demux(audio=0))
    summary = rendered(source, tmp_path / f"out{ending}")
    assert summary.damage == f"the input is damaged: {count} packets of stream 0 (audio) lost"
    assert summary.exit_code == 4


def test_samples_that_are_no_numbers_become_silence(tmp_path):
    def spoil(number: int, content: bytes) -> bytes:
        return b"\xff" * len(content) if number == 20 else content

    summary = rendered(film(tmp_path / "in.mkv", "pcm_f32le", spoil=spoil), tmp_path / "out.mp4")
    assert summary.exit_code == 4 and " 0.02 s of stream 1 (audio) lost" in summary.damage
    assert beep(tmp_path / "out.mp4") == pytest.approx(1.8, abs=0.03)


def test_damaged_subtitles_are_told(tmp_path):
    path = tmp_path / "in.mp4"
    with av.open(str(path), "w") as container:
        screen = container.add_stream("mpeg4", rate=FRAME_RATE)
        screen.width, screen.height, screen.pix_fmt = 64, 48, "yuv420p"
        words = container.add_mux_stream("mov_text")
        words.time_base = Fraction(1, 1000)
        for number, content in enumerate((b"\x00\x05Hello", b"\x00\x05\xff\xfe\xfd\xfc\xfb")):
            packet = av.Packet(content)
            packet.stream, packet.time_base, packet.is_keyframe = words, Fraction(1, 1000), True
            packet.pts = packet.dts = 400 * number
            packet.duration = 300
            container.mux(packet)
        for number in range(25):
            frame = av.VideoFrame(64, 48, "yuv420p")
            frame.pts, frame.time_base = number, Fraction(1, FRAME_RATE)
            container.mux(screen.encode(frame))
        container.mux(screen.encode(None))
    summary = rendered(path, tmp_path / "out.mkv")
    assert summary.damage == "the input is damaged: 1 packet (0.30 s) of stream 1 (subtitle) lost"
    assert summary.exit_code == 4


@pytest.fixture(scope="module")
def spoilt_films(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Films with a track of every codec: late, with damaged packets, and with broken headers."""
    folder = tmp_path_factory.mktemp("spoilt")
    # Matroska's muxer looks into packets of WavPack, so that no broken ones can be made.
    breakable = [codec for codec in CODECS if codec != "wavpack"]
    return [
        film(folder / "late.mkv", *CODECS, begin=0.3, seconds=0.4),
        film(folder / "zeros.mkv", *breakable, seconds=0.4, spoil=zeros),
        film(folder / "torn.mkv", *breakable, seconds=0.4, spoil=torn),
    ]


@pytest.mark.thorough
@pytest.mark.parametrize("ending", ENDINGS)
def test_no_sound_costs_the_film_in_any_container(spoilt_films, tmp_path, ending):
    """Cut before the sound begins, after its first packet, and not at all."""
    for source in spoilt_films:
        for end in (Fraction(1, 50), Fraction(31, 100), None)[0 if source.stem == "late" else 2 :]:
            assert rendered(source, tmp_path / f"out{ending}", end).exit_code in (0, 4)
