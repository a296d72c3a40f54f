"""Snapshots and recordings that are made while a session runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from pathlib import Path

from vidstyle.errors import VidstyleError, counted
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame, TargetContext
from vidstyle.live.target_thread import FINISH_SECONDS, TargetThread
from vidstyle.live.targets import FileSink, file_target
from vidstyle.media.audio import AudioChunk
from vidstyle.media.write.writer import WriteOptions


class Recorder:
    """Writes snapshots and recordings to the working directory, named by date and time."""

    def __init__(self, notify: Callable[[str], None], finish: Callable[[Path], None]) -> None:
        """`notify`: receives messages for the user; `finish`: files of finished recordings."""
        self._notify, self._finish = notify, finish
        self._target: TargetThread | None = None
        self._snapshot: threading.Thread | None = None

    @property
    def recording(self) -> bool:
        """Whether a recording is being written."""
        return self._target is not None

    def offer(self, frame: LiveFrame, context: TargetContext) -> None:
        """Write the frame to a requested snapshot or recording; `context`: see the targets of the session."""
        controls, context = context.controls, replace(context, first=frame, meter=LatencyMeter())
        if controls.pop_snapshot():
            # Encoding a large PNG takes longer than the time between two frames.
            write = threading.Thread(target=self._write_snapshot, args=(context,), daemon=True)
            write.name = "vidstyle snapshot"
            write.start()
            self._snapshot = write
        if controls.recording and self._target is None and not self._start(context):
            controls.record(False)
        elif not controls.recording:
            self._stop()
        if self._target is not None:
            self._target.offer(frame)
            if self._target.error is not None:
                controls.record(False)

    def push_audio(self, chunk: AudioChunk) -> None:
        """Queue sound for the recording, if there is one; thread-safe."""
        target = self._target
        if target is not None:
            target.push_audio(chunk)

    def close(self) -> None:
        """Finish the recording and the last snapshot."""
        if self._snapshot is not None:
            self._snapshot.join(FINISH_SECONDS)
        self._stop()

    def _start(self, context: TargetContext) -> bool:
        try:
            self._target = file_target(_unused_name(".mp4"), context, WriteOptions())
        except VidstyleError as error:
            self._notify(str(error))
            return False
        self._notify(f"{self._target.name}: recording")
        return True

    def _stop(self) -> None:
        if self._target is not None:
            target, self._target = self._target, None
            target.close()
            frames = counted(target.delivered, "frame")
            self._notify(str(target.error or f"{target.name}: {frames}, saved in {Path.cwd()}"))
            if target.error is None:
                self._finish(Path(target.name).absolute())

    def _write_snapshot(self, context: TargetContext) -> None:
        path = _unused_name(".png")
        try:
            sink = FileSink(path, context, WriteOptions(), still=True)
            sink.write(context.first, 0)
            sink.close()
            self._notify(f"{path}: saved")
        except VidstyleError as error:
            self._notify(str(error))


def _unused_name(extension: str) -> Path:
    """A name by date and time that no file has yet."""
    stem = f"vidstyle-{datetime.now():%Y%m%d-%H%M%S}"
    suffixes = ("", *(f"-{number}" for number in range(2, 1000)))
    return next(path for suffix in suffixes if not (path := Path(f"{stem}{suffix}{extension}")).exists())
