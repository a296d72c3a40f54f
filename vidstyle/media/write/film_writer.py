"""Writes a film: video is encoded, other streams are copied; the file plays even if it is cut short."""

from __future__ import annotations

import hashlib
import math
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import partial
from pathlib import Path

import av

from vidstyle.errors import OutputError, UsageError, error_reason, log
from vidstyle.media.audio import AudioChunk, AudioEncoder
from vidstyle.media.frame import Frame
from vidstyle.media.write.atomic import PartialFile, is_regular_file
from vidstyle.media.write.base import StandardOutput, Writer, write_error
from vidstyle.media.write.encoder import VideoEncoder
from vidstyle.media.write.faststart import move_index_first
from vidstyle.media.write.interleaver import MAX_QUEUED_BYTES, OUTPUT_ERRORS, Interleaver
from vidstyle.media.write.resume_source import ResumeSource, frames_in, video_format
from vidstyle.media.write.run_record import START_ANEW, Checkpoints, Fingerprint, earlier_run, unknown_file
from vidstyle.media.write.stream_copy import CopiedStreams, copy_chapters, portable_tags

WAIT_SECONDS = Fraction(1)
"""How much of the film may wait for streams that have not begun, before the header is written."""
MAX_WAIT_SECONDS = Fraction(30)
"""The same where the muxer needs a packet of the stream for its header."""
FLUSH_SECONDS = 1.0
"""How long flushing an abandoned encoder may take."""
INDEXED = ("mp4", "mov")
"""Containers whose index is moved to the front (faststart)."""
MAX_TICKS = 2**31 - 1
"""The longest time that their index holds between two packets."""
LOOK_FRAMES = 50
"""Frames after which it is checked again whether a continued film is as long as the earlier one."""


class FilmWriter(Writer):
    """Writes one container with pictures, and with the other streams of the source."""

    partial_ending: str | None = None

    def _open(self) -> None:
        kind, piped = self._kind, self.name == "standard output" or not is_regular_file(self.target)
        if piped and not kind.piped:
            raise UsageError(self.name, f"{kind.endings[0]} cannot be written to a pipe", "use nut or mkv")
        self._closed = self._whole = False
        self._earlier: ResumeSource | None = None
        self._checkpoints: Checkpoints | None = None
        self._file = None if piped else self._open_file()
        self.partial = (self._file.earlier or self._file.path) if self._file else None
        try:
            self._open_streams()
            self._continue()
        except BaseException:
            self._discard()
            raise

    def _open_file(self) -> PartialFile:
        file = PartialFile(self.target, self._source_path, self._options.overwrite, self.partial_ending)
        if file.is_left:
            try:
                self._use_leftover(file)
            except BaseException:
                file.release()
                raise
        return file

    def _use_leftover(self, file: PartialFile) -> None:
        """Continue, keep or replace what an earlier run has left; refuse any other file."""
        verified = file.record.verified_bytes(file.path)
        earlier = ResumeSource(file.path, verified or 0)
        is_known = verified is not None and (verified or not earlier.stored)
        if not is_known and file.path.stat().st_size:
            raise unknown_file(file.path)
        if earlier.stored and self._fingerprint and self._fingerprint.resume:
            self._earlier, self._look_at = earlier, earlier.stored
            file.continue_beside()
        elif self._options.overwrite or not (earlier.stored or verified):
            file.start_anew()
        elif earlier.stored:
            raise earlier_run(file.path, f"the first {earlier.seconds:.1f} s", file.record)
        else:
            raise UsageError(file.path, "cannot be continued, since it cannot be read", START_ANEW)

    def _continue(self) -> None:
        """Take over the earlier run's pictures if its fingerprint is the same; else store this run's own."""
        if self._file is None:
            return
        if self._earlier is None or self._fingerprint is None:
            self._file.record.begin(self._with_headers().parts if self._fingerprint else {})
        else:
            self._resume(self._earlier, self._file)
        self._checkpoints = Checkpoints(self._file.record, self._file.path)

    def _with_headers(self) -> Fingerprint:
        """The fingerprint, with what the encoder makes of the options."""
        assert self._fingerprint is not None
        digest = hashlib.sha256(self._headers).hexdigest()
        return replace(self._fingerprint, parts={**self._fingerprint.parts, "encoder headers": digest})

    @property
    def _headers(self) -> bytes:
        return bytes(self._video.stream.codec_context.extradata or b"")

    def _resume(self, earlier: ResumeSource, file: PartialFile) -> None:
        assert file.earlier is not None
        self._with_headers().check(file.record, file.earlier)
        if earlier.format != video_format(self._video.stream):
            raise unknown_file(file.earlier)
        self._video.resume(earlier.packets(start_codes=self._headers[:1] != b"\x01"), earlier.tick)
        self.kept = earlier.kept
        log.info(
            "%s is continued after %.1f s: %d of %d frames are kept",
            *(file.earlier, earlier.kept_seconds, self.kept, earlier.stored),
        )

    def _open_streams(self) -> None:
        """Set up all streams and write the header, so that errors show before decoding."""
        if self._file:
            self._file.check()
        path = self._file.path if self._file else self.target
        muxing = self._kind.options if self._file else self._kind.piped_options
        self._container = av.open(
            StandardOutput() if self.name == "standard output" else str(path),
            "w",
            format=self._kind.muxer,
            container_options={"flush_packets": "1", "max_interleave_delta": "1"} | muxing,
        )
        self._video = VideoEncoder(self._container, self._plan)
        inputs = self._source.container if self._source else None
        streams = self._source.copied_streams if self._source and inputs else []
        self._copied = CopiedStreams(self._container, self._kind, streams, self._options.audio, self.name)
        options = self._options
        encoder = self._kind.new_audio if options.audio in ("copy", "none") else options.audio
        wanted = options.new_sound and options.audio != "none" and encoder
        self._audio = AudioEncoder(self._container, encoder) if wanted else None
        if inputs is not None:
            self._container.metadata.update(portable_tags(inputs.metadata))
            copy_chapters(inputs, self._container, self._kind)
        # Where a subtitle ends, the MP4 muxer may end a fragment amid a packet of sound, and misplace it.
        indexed = self._kind.muxer in INDEXED
        self._interleaver = Interleaver(
            self._container, indexed, self._copied.refused, MAX_TICKS if indexed else math.inf
        )
        self._first: Fraction | None = None
        self._begun, self._heard, self._early_bytes = False, self._audio is None, 0
        self._begin_when_all_have_come()

    def _begin_when_all_have_come(self, item: Frame | av.Packet | None = None) -> None:
        """Write the header once all streams have begun that the muxer would wait for, or after a while."""
        if isinstance(item, Frame):
            self._first = item.time if self._first is None else self._first
            late = item.time - self._first >= (MAX_WAIT_SECONDS if self._copied.needed else WAIT_SECONDS)
        else:
            self._early_bytes += item.size if item else 0
            late = self._early_bytes > MAX_QUEUED_BYTES
        waits = self._kind.late_options or self._kind.untimed
        if late or not waits or (self._heard and not self._copied.awaited):
            self._begin()

    def _begin(self, over: bool = False) -> None:
        """Write the header, and what has waited for it; `over`: no more packets will come."""
        if self._begun:
            return
        self._begun = True
        early = self._copied.begin(over)
        if self._file and not over and (self._copied.awaited or not self._heard):
            self._container.container_options.update(self._kind.late_options)
        try:
            self._container.start_encoding()
        except (av.FFmpegError, OSError) as error:
            raise OutputError(self.name, f"{self._kind.muxer} cannot be set up so: {error}") from error
        for packet in early:
            self._interleaver.push(packet)
        self._interleaver.start()

    def write(self, item: Frame | av.Packet) -> None:
        """See Writer."""
        try:
            if isinstance(item, Frame):
                self.frames += 1
                for packet in self._video.encode(item):
                    self._interleaver.push_video(packet)
            else:
                for packet in self._copied.packets(item):
                    self._interleaver.push(packet)
            if not self._begun:
                self._begin_when_all_have_come(item)
            if self._checkpoints:
                self._checkpoints.update()
            if self._file and self._file.check():
                self._take_over(self._file)
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def _take_over(self, file: PartialFile) -> None:
        """Drop what the earlier run has left as soon as this one has stored as much."""
        if self._earlier is not None and self.frames > self._look_at:
            self._look_at = self.frames + LOOK_FRAMES
            if frames_in(file.path) >= self._earlier.stored:
                with suppress(PermissionError):  # Windows renames no open file; it is done at the end then
                    file.take_over()
                    self._earlier = None

    def push_audio(self, chunk: AudioChunk, seconds: float) -> None:
        """See Writer."""
        if self._audio is None:
            return
        try:
            for packet in self._audio.packets(chunk.samples, seconds):
                self._heard = True
                self._interleaver.push(packet)
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def finish(self) -> None:
        """See Writer."""
        try:
            self._begin(over=True)
            self._drain(None, self._cut())
            self._close()
            self._whole = True
            if self._file:
                self._put_in_place(self._file)
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error
        self._report()

    @property
    def loss(self) -> str:
        """See Writer."""
        return self._copied.loss

    def abandon(self) -> Path | None:
        """See Writer."""
        if not self._closed:
            try:
                self._begin(over=True)
                self._drain(FLUSH_SECONDS, self._video.end)
            except (av.FFmpegError, OSError) as error:
                log.debug("%s: %s", self.name, error)
            self._close_quietly()
        least = self._earlier.stored if self._earlier else 1
        if self._file is None or not self._file.exists or frames_in(self._file.path) < least:
            self._discard()
            return self.partial
        return self._file.keep()

    def _drain(self, seconds: float | None, end: Fraction | None) -> None:
        for packet in self._video.flush(seconds):
            self._interleaver.push_video(packet)
        for packet in [*self._copied.flush(), *(self._audio.flush() if self._audio else [])]:
            self._interleaver.push(packet)
        self._interleaver.finish(end)

    def _cut(self) -> Fraction | None:
        """Where sound is to end: with the pictures if the source was cut off, else where it ends itself."""
        damaged = self._source is not None and self._source.damage.is_significant
        return self._video.end if damaged and self.frames else None

    def _close(self) -> None:
        self._closed = True
        try:
            self._container.close()
        except av.FFmpegError as error:
            # The end of another stream was refused, perhaps; the rest is written all the same.
            if error.errno in OUTPUT_ERRORS or not self._file:
                raise
            self._interleaver.refused += 1
            log.warning("%s: its end was refused by the muxer: %s", self.name, error_reason(error))
        finally:
            if self._checkpoints:
                self._checkpoints.close()
        if self._interleaver.refused and self._file and frames_in(self._file.path) < self.frames:
            raise OutputError(self.name, "pictures were refused by the muxer")

    def _close_quietly(self) -> None:
        """Close a container that may be broken already; what it has on disk plays by its fragments."""
        try:
            self._close()
        except (av.FFmpegError, OSError) as error:
            log.debug("%s: %s", self.name, error)

    def _put_in_place(self, file: PartialFile) -> None:
        """Give the finished file its name, with its index first where there is room for a copy."""
        if self._kind.muxer in INDEXED and file.exists and file.free_bytes > file.path.stat().st_size:
            try:
                file.rewrite(partial(move_index_first, surplus=self._video.surplus))
            except OSError as error:
                log.info("%s: its index stays at its end (%s)", self.name, error)
        file.finish()

    def _failure(self, error: Exception) -> OutputError:
        """What to tell after writing has failed; the file is closed, so that what is in it is known."""
        if isinstance(error, OutputError) and self._file is None:
            return error
        # Our own errors come while the file can still be closed. On a full disk some muxers close without
        # a complaint, and the end is missing all the same.
        whole = isinstance(error, OutputError)
        if not whole:
            self._close_quietly()
        left = self.abandon()
        kept = "nothing is kept"
        if left and self._whole:
            kept = f"the whole film is {left}: rename it"
        elif left:
            kept = f"the first {frames_in(left, whole)} frames are safe in {left}"
        return write_error(self.name, error, kept)

    def _discard(self) -> None:
        self._closed = True
        self.partial = self._file.earlier if self._file else None
        if self._checkpoints:
            self._checkpoints.close()
        if self._file:
            self._file.remove()

    def _report(self) -> None:
        """Say what was not carried over as it was."""
        notices = {
            "frames came at a time that was taken, and are shown a tick later": self._video.moved,
            "packets came too early for their stream, and were put right": self._interleaver.moved,
            "packets were left out, being repeated, without a time, or refused": self._interleaver.dropped,
            "packets after the last picture were cut, since the source is damaged": self._interleaver.cut,
        }
        for text, count in notices.items():
            if count:
                log.warning("%s: %d %s", self.name, count, text)
        if self._kind.strict_rate and (gaps := self._interleaver.gaps):
            reason = f"{self._kind.endings[0]} files hold no times of sound"
            log.warning("%s: %.1f s of gaps in the sound are closed, since %s", self.name, gaps, reason)
