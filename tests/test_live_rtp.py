"""RTP on this machine: a stream can be joined at any time."""

from __future__ import annotations

import socket
import threading
import time

import av
from live import LONG, Kept, eventually, generated, session

from vidstyle.live.targets import TargetOptions, target_maker
from vidstyle.media.capture.microphone import Microphone

JOIN_SECONDS = 6.0
"""How soon who joins has a picture: a key frame comes every second, and FFmpeg looks at the stream first."""
LOW_LATENCY_OPTIONS = {"fflags": "nobuffer", "analyzeduration": "500000"}


def free_port() -> int:
    """A port for UDP that is even, as those of RTP are, with a free one after it."""
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
    """Somebody who plays a stream until some pictures have come.

    Attributes:
        sizes: width and height of each picture.
        sounds: how many pieces of sound there were.
        seconds: from the beginning to the first picture.
    """

    def __init__(self, url: str, pictures: int) -> None:
        self.sizes: list[tuple[int, int]] = []
        self.sounds = 0
        self.seconds = 0.0
        self._thread = threading.Thread(target=self._play, args=(url, pictures), daemon=True)
        self._thread.start()

    def _play(self, url: str, pictures: int) -> None:
        begin = time.monotonic()
        with av.open(url, options=LOW_LATENCY_OPTIONS, timeout=LONG) as container:
            for frame in container.decode(video=0, audio=0):
                if isinstance(frame, av.VideoFrame):
                    self.seconds = self.seconds or time.monotonic() - begin
                    self.sizes.append((frame.width, frame.height))
                else:
                    self.sounds += 1
                if len(self.sizes) == pictures:
                    return

    def played(self) -> Receiver:
        self._thread.join(LONG)
        assert not self._thread.is_alive(), f"{len(self.sizes)} pictures came"
        return self


def test_whoever_joins_gets_a_stream_that_plays():
    url, kept = f"rtp://127.0.0.1:{free_port()}", Kept()
    early = Receiver(url, 20)
    time.sleep(0.5)
    maker = target_maker(url, TargetOptions())
    with session(generated(), kept, maker, microphone=Microphone("test")) as running:
        assert set(early.played().sizes) == {(160, 90)} and early.sounds
        eventually(lambda: len(kept.numbers) > 40)
        late = Receiver(url, 5).played()
        again = Receiver(url, 20).played()
        assert (url, "running") in running.controls.status().targets
        running.end()
    for each in (late, again):
        assert set(each.sizes) == {(160, 90)} and each.seconds < JOIN_SECONDS
    assert again.sounds
