"""RTP on this machine: a stream can be joined at any time, and no sound ends it."""

from __future__ import annotations

import socket
import threading
from contextlib import suppress
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from live import Kept, generated, session
from waiting import LONG, eventually, guard

from vidstyle.live.targets import TargetOptions, target_maker
from vidstyle.media.audio import AudioChunk
from vidstyle.media.capture.microphone import Microphone
from vidstyle.media.capture.monotonic import MONOTONIC
from vidstyle.media.write.stream import StreamOptions, open_stream

SOCKETS = Path("/proc/net/udp")
"""Return the UDP ports with a listener."""
JOIN_SECONDS = 3.0
"""How much of the stream passes before who joins has a picture: key frames come every second."""
LOW_LATENCY_OPTIONS = {"fflags": "nobuffer", "analyzeduration": "500000"}


def free_port() -> int:
    """Return an even UDP port, as for RTP, followed by a free port."""
    while True:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first:
            first.bind(("127.0.0.1", 0))
            port = int(first.getsockname()[1])
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second:
            try:
                second.bind(("127.0.0.1", port + 1))
            except OSError:
                continue
        if port % 2 == 0:
            return port


class Receiver:
    """A client that plays a stream until some pictures have arrived.

    Attributes:
        sizes: width and height of each picture.
        sounds: how many pieces of sound there were.
        missed: seconds of the stream before the first picture.
        error: what ended it, or None.
    """

    def __init__(self, url: str, pictures: int) -> None:
        self.sizes: list[tuple[int, int]] = []
        self.sounds = 0
        self.missed = 0.0
        self.error: av.FFmpegError | None = None
        self._thread = threading.Thread(target=self._play, args=(url, pictures), daemon=True)
        self._thread.start()

    def _play(self, url: str, pictures: int) -> None:
        try:
            while len(self.sizes) < pictures:
                # On a busy machine FFmpeg gives up after 10 s, or no sound comes while it looks for streams.
                with suppress(TimeoutError, IndexError):
                    self._receive(url, pictures)
        except av.FFmpegError as error:
            self.error = error

    def _receive(self, url: str, pictures: int) -> None:
        with av.open(url, options=LOW_LATENCY_OPTIONS, timeout=LONG) as container:
            begin = None
            for packet in container.demux(video=0, audio=0):
                begin = packet.pts * packet.time_base if begin is None and packet.pts is not None else begin
                with suppress(av.InvalidDataError):  # like a player, which continues after a lost packet
                    for frame in packet.decode():
                        self._take(frame, begin)
                if len(self.sizes) >= pictures:
                    return

    def _take(self, frame: av.VideoFrame | av.AudioFrame, begin: Fraction | None) -> None:
        if isinstance(frame, av.AudioFrame):
            self.sounds += 1
            return
        if not self.sizes and begin is not None:
            self.missed = float(frame.pts * frame.time_base - begin)
        self.sizes.append((frame.width, frame.height))

    def played(self) -> Receiver:
        self._thread.join(2 * LONG)
        came = f"{len(self.sizes)} pictures and {self.sounds} pieces of sound came"
        assert self.error is None and not self._thread.is_alive(), f"{came}: {self.error}"
        return self


def joined(url: str, pictures: int) -> Receiver:
    """A receiver that soon saw a picture. A busy machine loses packets: then the next one may."""
    left = guard("no receiver saw a picture soon")
    while (receiver := Receiver(url, pictures).played()).missed >= JOIN_SECONDS:
        left()
    return receiver


@pytest.mark.parametrize("first", [0, 20], ids=["ahead of its pictures", "behind them"])
def test_sound_that_does_not_keep_up_with_the_pictures_ends_no_stream(first: int, caplog):
    """As on a machine that is busy: a second of sound comes at once, before its pictures or after them."""
    picture, silence = av.VideoFrame(160, 90, "yuv420p"), np.zeros((2, 48000), np.float32)
    stream = open_stream(f"rtp://127.0.0.1:{free_port()}", StreamOptions(sound=True), picture)
    for number in range(35):
        stream.write(picture, number)
        if number == first:
            stream.push_audio(AudioChunk(silence, 0), 0.0)
    stream.close()
    assert ("too late is dropped" in caplog.text) == (first > 0)


@pytest.mark.skipif(not SOCKETS.exists(), reason="only Linux tells who listens")
def test_whoever_joins_gets_a_stream_that_plays():
    port, kept = free_port(), Kept()
    url = f"rtp://127.0.0.1:{port}"
    early = Receiver(url, 20)
    eventually(lambda: f":{port:04X} " in SOCKETS.read_text())
    maker = target_maker(url, TargetOptions())
    with session(generated(), kept, maker, clock=MONOTONIC, microphone=Microphone("test")) as running:
        assert set(early.played().sizes) == {(160, 90)} and early.sounds
        eventually(lambda: len(kept.numbers) > 40)
        late, again = joined(url, 5), joined(url, 20)
        assert (url, "running") in running.controls.status().targets
        running.end()
    assert set(late.sizes) == set(again.sizes) == {(160, 90)}
    assert again.sounds
