"""Writes a film: video is encoded, other streams are copied; an interrupted file is playable."""

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
from vidstyle.media.write.resume_source import ResumeSource, count_frames, video_format
from vidstyle.media.write.run_record import (
    RESTART_REMEDY,
    Checkpoints,
    Fingerprint,
    earlier_run_error,
    unknown_file_error,
)
from vidstyle.media.write.segment_file import JoinedSegments
from vidstyle.media.write.stream_copy import CopiedStreams, copy_chapters, portable_tags

MAX_STREAM_WAIT_SECONDS = Fraction(1)
"""Duration of film that is queued for streams without packets before the header is written."""
MAX_NEEDED_WAIT_SECONDS = Fraction(30)
"""Duration of film that is queued if the muxer needs a packet of the stream for its header."""
MAX_FLUSH_SECONDS = 1.0
"""Time limit for flushing an abandoned encoder."""
MAX_GAP_TICKS = 2**31 - 1
"""Maximum time between two packets in an index."""
CHECK_INTERVAL_FRAMES = 50
"""Interval between checks whether a resumed film is as long as the earlier one."""


class FilmWriter(Writer):
    """Writes one container with video and the other streams of the source."""

    partial_ending: str | None = None

    def _open(self) -> None:
        kind, piped = self._kind, self.name == "standard output" or not is_regular_file(self.target)
        if piped and not kind.piped:
            raise UsageError(self.name, f"{kind.endings[0]} cannot be written to a pipe", "use nut or mkv")
        self._closed = self._is_complete = False
        self._earlier: ResumeSource | None = None
        self._checkpoints: Checkpoints | None = None
        self._file = None if piped else self._open_file()
        self.partial = (self._file.leftover or self._file.path) if self._file else None
        try:
            self._open_streams()
            self._continue()
        except BaseException:
            self._discard()
            raise

    def _open_file(self) -> PartialFile:
        file = PartialFile(self.target, self._source_path, self._options.overwrite, self.partial_ending)
        if file.has_leftover:
            try:
                self._use_leftover(file)
            except BaseException:
                file.release()
                raise
        return file

    def _use_leftover(self, file: PartialFile) -> None:
        """Continue, keep or replace the leftover of an earlier run; refuse any other file."""
        verified = file.record.verified_bytes(file.path)
        earlier = ResumeSource(file.path, verified or 0)
        is_known = verified is not None and (verified or not earlier.stored)
        if not is_known and file.path.stat().st_size:
            raise unknown_file_error(file.path)
        if earlier.stored and self._fingerprint and self._fingerprint.resume:
            self._earlier, self._next_check = earlier, earlier.stored
            file.continue_separately()
        elif self._options.overwrite or not (earlier.stored or verified):
            file.restart()
        elif earlier.stored:
            raise earlier_run_error(file.path, f"the first {earlier.seconds:.1f} s", file.record)
        else:
            raise UsageError(file.path, "cannot be resumed: it cannot be read", RESTART_REMEDY)

    def _continue(self) -> None:
        """Use the pictures of an earlier run with the same fingerprint, or record this run's fingerprint."""
        if self._file is None:
            return
        if self._earlier is None or self._fingerprint is None:
            self._file.record.begin(self._with_headers().parts if self._fingerprint else {})
        else:
            self._resume(self._earlier, self._file)
        self._checkpoints = Checkpoints(self._file.record, self._file.path)
        # Compiling kernels may take long before the first frame: a run killed then can be resumed, too.
        self._checkpoints.update()

    def _with_headers(self) -> Fingerprint:
        """Add the encoder headers, which depend on the options, to the fingerprint."""
        assert self._fingerprint is not None
        digest = hashlib.sha256(self._headers).hexdigest()
        return replace(self._fingerprint, parts={**self._fingerprint.parts, "encoder headers": digest})

    @property
    def _headers(self) -> bytes:
        return bytes(self._video.stream.codec_context.extradata or b"")

    def _resume(self, earlier: ResumeSource, file: PartialFile) -> None:
        assert file.leftover is not None
        self._with_headers().check(file.record, file.leftover)
        if earlier.format != video_format(self._video.stream):
            raise unknown_file_error(file.leftover)
        self._video.resume(earlier.packets(start_codes=self._headers[:1] != b"\x01"), earlier.tick)
        self.kept = earlier.kept
        log.info(
            "%s is resumed after %.1f s: %d of %d frames are kept",
            *(file.leftover, earlier.kept_seconds, self.kept, earlier.stored),
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
        # At the end of a subtitle, the MP4 muxer may end a fragment within a packet of sound and misplace it.
        indexed = self._kind.indexed
        self._interleaver = Interleaver(
            self._container, indexed, self._copied.count_refused, MAX_GAP_TICKS if indexed else math.inf
        )
        self._first: Fraction | None = None
        self._begun, self._has_audio, self._early_bytes = False, self._audio is None, 0
        self._begin_when_ready()

    def use_segments(self, segments: JoinedSegments) -> None:
        """Write the packets of segments instead of encoding frames, of which only the times are used.

        Raises:
            OutputError: the segments were encoded with other settings.
        """
        if segments.headers != self._headers:
            raise OutputError(self.name, "cannot be joined: its segments have different encoder settings")
        self._video.resume(segments.packets(), segments.tick)

    def _begin_when_ready(self, item: Frame | av.Packet | None = None) -> None:
        """Write the header when all streams that the muxer needs have started, or after a time limit."""
        if isinstance(item, Frame):
            self._first = item.time if self._first is None else self._first
            late = item.time - self._first >= (
                MAX_NEEDED_WAIT_SECONDS if self._copied.needed else MAX_STREAM_WAIT_SECONDS
            )
        else:
            self._early_bytes += item.size if item else 0
            late = self._early_bytes > MAX_QUEUED_BYTES
        waits = self._kind.late_options or self._kind.untimed
        if late or not waits or (self._has_audio and not self._copied.awaited):
            self._begin()

    def _begin(self, over: bool = False) -> None:
        """Write the header and the queued packets; `over`: no more packets follow."""
        if self._begun:
            return
        self._begun = True
        early = self._copied.begin(over)
        if self._file and not over and (self._copied.awaited or not self._has_audio):
            self._container.container_options.update(self._kind.late_options)
        try:
            self._container.start_encoding()
        except (av.FFmpegError, OSError) as error:
            raise OutputError(self.name, f"{self._kind.muxer} refuses these settings: {error}") from error
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
                self._begin_when_ready(item)
            if self._checkpoints:
                self._checkpoints.update()
            if self._file and self._file.check():
                self._replace_leftover(self._file)
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def _replace_leftover(self, file: PartialFile) -> None:
        """Replace the leftover of the earlier run as soon as this run has stored equally many frames."""
        if self._earlier is not None and self.frames > self._next_check:
            self._next_check = self.frames + CHECK_INTERVAL_FRAMES
            if count_frames(file.path) >= self._earlier.stored:
                with suppress(
                    PermissionError
                ):  # Windows cannot rename an open file; it is renamed at the end
                    file.replace_leftover()
                    self._earlier = None

    def push_audio(self, chunk: AudioChunk, seconds: float) -> None:
        """See Writer."""
        if self._audio is None:
            return
        try:
            for packet in self._audio.packets(chunk.samples, seconds):
                self._has_audio = True
                self._interleaver.push(packet)
        except (av.FFmpegError, OSError) as error:
            raise self._failure(error) from error

    def finish(self) -> None:
        """See Writer."""
        try:
            self._begin(over=True)
            self._drain(None, self._sound_end())
            self._close()
            self._is_complete = True
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
                self._drain(MAX_FLUSH_SECONDS, self._video.end)
            except (av.FFmpegError, OSError) as error:
                log.debug("%s: %s", self.name, error)
            self._close_quietly()
        least = self._earlier.stored if self._earlier else 1
        if self._file is None or not self._file.exists or count_frames(self._file.path) < least:
            self._discard()
            return self.partial
        return self._file.keep()

    def _drain(self, seconds: float | None, end: Fraction | None) -> None:
        for packet in self._video.flush(seconds):
            self._interleaver.push_video(packet)
        for packet in [*self._copied.flush(), *(self._audio.flush() if self._audio else [])]:
            self._interleaver.push(packet)
        self._interleaver.finish(end)

    def _sound_end(self) -> Fraction | None:
        """Return the end of the video, where sound of damaged sources is cut; None: sound is not cut."""
        damaged = self._source is not None and self._source.damage.is_significant
        return self._video.end if damaged and self.frames else None

    def _close(self) -> None:
        self._closed = True
        try:
            self._container.close()
        except av.FFmpegError as error:
            # The muxer may have refused the end of another stream; the rest is written.
            if error.errno in OUTPUT_ERRORS or not self._file:
                raise
            self._interleaver.refused += 1
            log.warning("%s: the muxer refused the last packets: %s", self.name, error_reason(error))
        finally:
            if self._checkpoints:
                self._checkpoints.close()
        if self._interleaver.refused and self._file and count_frames(self._file.path) < self.frames:
            raise OutputError(self.name, "the muxer refused video packets")

    def _close_quietly(self) -> None:
        """Close a container that may be broken; its fragments on disk are playable."""
        try:
            self._close()
        except (av.FFmpegError, OSError) as error:
            log.debug("%s: %s", self.name, error)

    def _put_in_place(self, file: PartialFile) -> None:
        """Rename the finished file, after moving its index to the front if the disk has space for a copy."""
        if self._kind.indexed and file.exists and file.free_bytes > file.path.stat().st_size:
            try:
                file.rewrite(partial(move_index_first, surplus=self._video.surplus))
            except OSError as error:
                log.info("%s: the index stays at the end (%s)", self.name, error)
        file.finish()

    def _failure(self, error: Exception) -> OutputError:
        """Close the file after writing has failed; return an error that describes its content."""
        if isinstance(error, OutputError) and self._file is None:
            return error
        # After our own errors the file can still be closed. On a full disk, some muxers close without error
        # although the end is missing.
        whole = isinstance(error, OutputError)
        if not whole:
            self._close_quietly()
        left = self.abandon()
        kept = "nothing is kept"
        if left and self._is_complete:
            kept = f"the complete film is {left}: rename it"
        elif left:
            kept = f"the first {count_frames(left, whole)} frames are kept in {left}"
        return write_error(self.name, error, kept)

    def _discard(self) -> None:
        self._closed = True
        self.partial = self._file.leftover if self._file else None
        if self._checkpoints:
            self._checkpoints.close()
        if self._file:
            self._file.remove()

    def _report(self) -> None:
        """Log notices about packets that were changed or dropped."""
        notices = {
            "frames with duplicate timestamps were shifted by one tick": self._video.shifted,
            "packets with decreasing timestamps were shifted": self._interleaver.shifted,
            "packets were dropped: duplicate, without a timestamp, or refused": self._interleaver.dropped,
            "packets after the last picture were dropped: the source is damaged": self._interleaver.cut,
        }
        for text, count in notices.items():
            if count:
                log.warning("%s: %d %s", self.name, count, text)
        if self._kind.strict_rate and (gaps := self._interleaver.gaps):
            reason = f"{self._kind.endings[0]} files store no timestamps of sound"
            log.warning("%s: %.1f s of gaps in the sound are closed, because %s", self.name, gaps, reason)
