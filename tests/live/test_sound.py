"""Sound of live sources: synchronous, across gaps and loops."""

from __future__ import annotations

import io
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from live import Receiver, session

from vidstyle.core.picture import Encoding, Picture
from vidstyle.live.target import LiveFrame
from vidstyle.live.targets import StreamSink, TargetOptions, target_maker
from vidstyle.media.audio import LIVE_SAMPLE_RATE, AudioChunk, AudioEncoder
from vidstyle.media.capture.sources import FileSource
from vidstyle.media.write.stream import Stream, StreamOptions, open_stream

BEEP = 0.7
"""When the film flashes and beeps, in seconds."""
IN_STEP = 0.05
"""Seconds by which sound and picture may differ: a picture, and a bit."""


@pytest.fixture(scope="module")
def clapper(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A second and a half: dark and silent, but for a flash with a beep of a fifth of a second."""
    path = tmp_path_factory.mktemp("sound") / "clapper.mkv"
    with av.open(str(path), "w") as container:
        screen = container.add_stream("ffv1", rate=30)
        screen.width, screen.height, screen.pix_fmt = 64, 48, "yuv420p"
        speaker = container.add_stream("pcm_s16le", rate=44100, layout="mono")
        for number in range(45):
            loud = BEEP <= number / 30 < BEEP + 0.2
            frame = av.VideoFrame(64, 48, "yuv420p")
            for place, plane in enumerate(frame.planes):
                plane.update(bytes([(230 if loud else 20) if place == 0 else 128]) * plane.buffer_size)
            frame.pts, frame.time_base = number, Fraction(1, 30)
            container.mux(screen.encode(frame))
            moments = np.arange(number * 1470, (number + 1) * 1470)
            tone = (np.sin(moments * 0.2) * 12000 * loud).astype(np.int16)[None]
            sound = av.AudioFrame.from_ndarray(tone, "s16", "mono")
            sound.sample_rate, sound.pts, sound.time_base = 44100, number * 1470, Fraction(1, 44100)
            container.mux(speaker.encode(sound))
        container.mux(screen.encode(None))
        container.mux(speaker.encode(None))
    return path


def flash_and_beep(film: object) -> tuple[float, float]:
    """When the picture turns bright, and when the sound turns loud."""
    flashes: list[float] = []
    beeps: list[float] = []
    with av.open(film) as container:  # type: ignore[call-overload]
        for frame in container.decode(video=0, audio=0):
            if isinstance(frame, av.VideoFrame):
                if frame.to_ndarray(format="gray").mean() > 120:
                    flashes.append(float(frame.pts * frame.time_base))
            else:
                loud = np.flatnonzero(np.abs(frame.to_ndarray().astype(float)).max(axis=0) > 0.05)
                if len(loud):
                    beeps.append(float(frame.pts * frame.time_base) + loud[0] / frame.sample_rate)
    return min(flashes), min(beeps)


@pytest.mark.parametrize("name", ["film.mp4", "film.webm"])
def test_a_file_has_its_sound_in_step(clapper: Path, tmp_path: Path, name: str):
    film = tmp_path / name
    with session(FileSource(str(clapper)), target_maker(str(film), TargetOptions())) as running:
        running.wait()
    flash, beep = flash_and_beep(str(film))
    assert abs(flash - beep) < IN_STEP


def test_a_stream_has_its_sound_in_step(clapper: Path):
    receiver = Receiver()
    maker = target_maker(f"tcp://127.0.0.1:{receiver.port}", TargetOptions())
    with session(FileSource(str(clapper)), maker) as running:
        running.wait()
    receiver.finish()
    receiver.hang_up()
    flash, beep = flash_and_beep(io.BytesIO(bytes(receiver.content)))
    assert abs(flash - beep) < IN_STEP


def test_sound_can_be_left_out(clapper: Path, tmp_path: Path):
    film = tmp_path / "film.mp4"
    with session(
        FileSource(str(clapper)), target_maker(str(film), TargetOptions()), sound=False, frames=5
    ) as running:
        running.wait()
    with av.open(str(film)) as container:
        assert not container.streams.audio


def test_sound_goes_on_over_the_seam_of_a_loop(clapper: Path, tmp_path: Path):
    film = tmp_path / "film.mkv"
    with session(
        FileSource(str(clapper), loop=True), target_maker(str(film), TargetOptions()), seconds=2.9
    ) as running:
        running.wait()
    with av.open(str(film)) as container:
        sounds = list(container.decode(audio=0))
    loud = [float(each.pts * each.time_base) for each in sounds if np.abs(each.to_ndarray()).max() > 1000]
    assert max(loud) - min(loud) == pytest.approx(1.7, abs=0.3), "the second beep comes a film later"


def test_a_long_gap_is_left_and_not_filled(tmp_path: Path):
    path = tmp_path / "voice.mkv"
    tone = np.full((2, LIVE_SAMPLE_RATE // 2), 0.5, np.float32)
    with av.open(str(path), "w") as container:
        voice = AudioEncoder(container, "aac")
        assert sum(len(bytes(packet)) > 0 for packet in voice.packets(tone, 0.0)) > 5
        packets = voice.packets(tone, 4000.0)
        assert len(packets) < 50, "an hour of silence was made"
        assert float(packets[-1].pts * packets[-1].time_base) > 3990
        container.mux(packets + voice.flush())


def test_gaps_are_silent_and_overlaps_are_left_out(tmp_path: Path):
    path = tmp_path / "voice.mkv"
    tone = np.full((2, LIVE_SAMPLE_RATE // 10), 0.5, np.float32)
    with av.open(str(path), "w") as container:
        voice = AudioEncoder(container, "pcm_s16le")
        for seconds in (0.0, 0.1, 0.105, 1.0, 0.9):
            container.mux(voice.packets(tone, seconds))
        container.mux(voice.flush())
    with av.open(str(path)) as container:
        samples = np.concatenate([each.to_ndarray()[0, ::2] for each in container.decode(audio=0)])
    assert len(samples) == pytest.approx(1.1 * LIVE_SAMPLE_RATE, abs=2000)
    assert np.abs(samples[int(0.35 * LIVE_SAMPLE_RATE) : int(0.95 * LIVE_SAMPLE_RATE)]).max() == 0
    assert (
        np.abs(samples[: int(0.15 * LIVE_SAMPLE_RATE)]).min() > 1000
        and samples[int(1.05 * LIVE_SAMPLE_RATE)] > 1000
    )


@pytest.mark.parametrize(
    ("gap", "drift"), [(0.05, 0.0), (0.09, 0.0), (-0.05, 0.0), (0.0, 0.01), (0.0, -0.01)]
)
def test_small_gaps_and_a_clock_that_drifts_do_not_add_up(tmp_path: Path, gap: float, drift: float):
    """Pieces of 0.02 s whose stamps leap once, or are of a clock that runs faster or slower than theirs."""
    path = tmp_path / "voice.mka"
    seconds, loud = 0.0, 0.0
    with av.open(str(path), "w") as container:
        voice = AudioEncoder(container, "pcm_s16le")
        for number in range(300):
            seconds += 0.02 * (1 + drift) + (gap if number == 20 else 0.0)
            loud = loud or (seconds if number == 250 else 0.0)
            tone = np.full((2, LIVE_SAMPLE_RATE // 50), 0.5 * (number >= 250), np.float32)
            container.mux(voice.packets(tone, seconds))
        container.mux(voice.flush())
    with av.open(str(path)) as container:
        samples = np.concatenate([each.to_ndarray()[0, ::2] for each in container.decode(audio=0)])
    assert np.flatnonzero(samples > 6000)[0] / LIVE_SAMPLE_RATE == pytest.approx(loud, abs=0.022)


def test_sound_stays_in_step_while_a_picture_is_repeated(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """Sound continues with the time, like repeated pictures."""
    placed = []
    monkeypatch.setattr(Stream, "push_audio", lambda self, chunk, seconds: placed.append(seconds))
    gray = [np.full(shape, 128, np.uint8) for shape in ((48, 64), (24, 32), (24, 32))]
    held = LiveFrame(Picture(Encoding(), luma=gray[0], chroma=(gray[1], gray[2])), 1000.0, 0)
    options = StreamOptions(sound=True)
    sink = StreamSink(open_stream(str(tmp_path / "live.m3u8"), options, held.video))
    for number in range(31):
        sink.write(held, number)
        sink.push_audio(AudioChunk(np.zeros((2, 1600), np.float32), 1000.0 + number / 30))
    sink.close()
    assert placed == pytest.approx([number / 30 for number in range(31)])
