"""Pictures and films that are kept on the way, when somebody asks for one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from fractions import Fraction
from pathlib import Path

from vidstyle.errors import VidstyleError
from vidstyle.live.control import Controls
from vidstyle.live.meter import Meter
from vidstyle.live.sinks import FileSink, FileTarget
from vidstyle.live.target import LiveFrame
from vidstyle.live.target_thread import CLOSE_SECONDS
from vidstyle.media.audio import AudioChunk
from vidstyle.media.write.writer import WriteOptions


class Recorder:
    """Snapshots and recordings, in the present folder, named by the time.

    Attributes:
        sound: whether recordings get sound.
    """

    def __init__(self, tell: Callable[[str], None]) -> None:
        """`tell`: is told where they are, or why they could not be kept."""
        self._tell = tell
        self.sound = False
        self._film: FileTarget | None = None
        self._writing: threading.Thread | None = None

    @property
    def recording(self) -> bool:
        """Whether a film is being written."""
        return self._film is not None

    def offer(self, frame: LiveFrame, controls: Controls, rate: Fraction) -> None:
        """Look at what is wished for, and keep the frame if it is to be kept."""
        if controls.take_snapshot():
            # A large PNG takes longer than a frame may.
            name = "vidstyle snapshot"
            self._writing = threading.Thread(target=self._keep, args=(frame, rate), name=name, daemon=True)
            self._writing.start()
        if controls.recording != self.recording and not self._set(controls.recording, frame, rate):
            controls.record(False)
        if self._film is not None:
            self._film.offer(frame)
            if self._film.error is not None:
                controls.record(False)

    def push_audio(self, chunk: AudioChunk) -> None:
        """Sound for the recording, if there is one; from any thread."""
        film = self._film
        if film is not None:
            film.push_audio(chunk)

    def close(self) -> None:
        """End the recording, and see the last snapshot written."""
        if self._writing is not None:
            self._writing.join(CLOSE_SECONDS)
        self._stop_recording()

    def _stop_recording(self) -> None:
        if self._film is not None:
            film, self._film = self._film, None
            film.close()
            self._tell(str(film.error) if film.error else f"{film.name}: {film.delivered} frames")

    def _set(self, on: bool, frame: LiveFrame, rate: Fraction) -> bool:
        if not on:
            self._stop_recording()
            return True
        film = FileTarget(_free_name(".mp4"), Meter(), rate, WriteOptions(new_sound=self.sound))
        try:
            film.start(frame)
        except VidstyleError as error:
            self._tell(str(error))
            return False
        self._film = film
        self._tell(f"{film.name}: recording")
        return True

    def _keep(self, frame: LiveFrame, rate: Fraction) -> None:
        path = _free_name(".png")
        try:
            sink = FileSink(path, frame, rate, WriteOptions(), still=True)
            sink.write(frame, 0)
            sink.close()
            self._tell(f"{path}: kept")
        except VidstyleError as error:
            self._tell(str(error))


def _free_name(ending: str) -> Path:
    """A name by the time that no file has yet."""
    stem = f"vidstyle-{datetime.now():%Y%m%d-%H%M%S}"
    names = (Path(f"{stem}{mark}{ending}") for mark in ("", *(f"-{number}" for number in range(2, 1000))))
    return next(path for path in names if not path.exists())
