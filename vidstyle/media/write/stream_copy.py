"""Carries over the other streams of a source: audio, subtitles, attachments, covers, chapters, tags."""

from __future__ import annotations

import logging
from collections.abc import Iterable

import av
from av.audio.stream import AudioStream
from av.bitstream import BitStreamFilterContext
from av.stream import AttachmentStream, Disposition, Stream
from av.subtitles.stream import SubtitleStream

from vidstyle.errors import UsageError
from vidstyle.media.write.containers import ContainerKind
from vidstyle.media.write.transcode import TEXT_CODECS, AudioTranscoder, CopiedStream, SubtitleTranscoder

FILE_TAGS = "encoder major_brand minor_version compatible_brands rotate duration vendor_id".split()
"""Tags that are true of the source's file only."""
FILE_TAG_STARTS = ("_statistics", "bps", "number_of_", "duration-")
_CODES = (
    "deu ger fra fre nld dut zho chi ces cze ell gre fas per ron rum slk slo sqi alb "
    "hye arm mya bur kat geo isl ice mkd mac msa may bod tib"
).split()
BIBLIOGRAPHIC_CODES = dict(zip(_CODES[::2], _CODES[1::2], strict=True))
"""Languages with two names (ISO 639-2), the terminological one first."""
COVER_CODECS = ("mjpeg", "png", "bmp")

_log = logging.getLogger("vidstyle")


class PlainCopy(CopiedStream):
    """Stream copy: packets pass unchanged."""

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """The packet itself, as one of the new stream."""
        if packet.dts is None and self.stream.disposition & Disposition.attached_pic:
            packet.pts = packet.dts = 0
        packet.stream = self.stream
        return [packet]


class AdtsCopy(CopiedStream):
    """AAC with ADTS headers, which are removed as MP4 and Matroska require (aac_adtstoasc)."""

    def __init__(self, stream: Stream, template: Stream) -> None:
        super().__init__(stream)
        self._filter = BitStreamFilterContext("aac_adtstoasc", in_stream=template)

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """The packet without its header, or nothing if it is torn."""
        time_base = packet.time_base
        try:
            bare = self._filter.filter(packet)
        except av.FFmpegError:
            self.lost += 1
            return []
        for made in bare:
            made.stream, made.time_base = self.stream, time_base
        return bare


class CopiedStreams:
    """The streams of a source that are copied, or transcoded where the container does not hold them.

    Args:
        target: named in what is said about them.
        audio: "copy", "none" or the name of an encoder.

    Raises:
        UsageError: `audio` names no encoder, or one whose sound the container does not hold.
    """

    def __init__(
        self,
        container: av.container.OutputContainer,
        kind: ContainerKind,
        streams: Iterable[Stream],
        audio: str,
        target: str,
    ) -> None:
        self._container, self._kind, self._audio, self._target = container, kind, audio, target
        _check_encoder(kind, audio)
        self._streams: dict[int, CopiedStream] = {}
        for template in streams:
            copied = self._add(template)
            if copied is not None:
                copied.stream.metadata.update(_known_language(portable_tags(template.metadata), kind))
                copied.stream.disposition = template.disposition
                self._streams[template.index] = copied

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """What goes to the muxer for a packet of the source."""
        copied = self._streams.get(packet.stream_index)
        if copied is None or (packet.size == 0 and packet.dts is None):
            return []
        return copied.packets(packet)

    def flush(self) -> list[av.Packet]:
        """What the encoders still held back."""
        return [packet for copied in self._streams.values() for packet in copied.flush()]

    def report(self) -> None:
        """Log what was lost."""
        for index, copied in self._streams.items():
            if copied.lost:
                kind = copied.stream.type
                _log.warning("stream %d (%s): %d packets could not be decoded", index, kind, copied.lost)

    def _add(self, template: Stream) -> CopiedStream | None:
        name = codec_name(template)
        if isinstance(template, AttachmentStream):
            return self._attach(template)
        if isinstance(template, AudioStream):
            return self._add_sound(template, name)
        if isinstance(template, SubtitleStream):
            return self._add_subtitles(template, name)
        is_cover = bool(template.disposition & Disposition.attached_pic)
        held = name in COVER_CODECS and self._kind.covers if is_cover else name in self._kind.data
        return self._copy(template, name) if held else self._leave_out(template, name)

    def _attach(self, template: AttachmentStream) -> CopiedStream | None:
        if not self._kind.attachments:
            return self._leave_out(template, template.name or "")
        mimetype = template.mimetype or "application/octet-stream"
        return PlainCopy(
            self._container.add_attachment(template.name or "attachment", mimetype, template.data)
        )

    def _add_sound(self, template: AudioStream, name: str) -> CopiedStream | None:
        if self._audio == "none":
            return None
        if self._audio == "copy" and name in self._kind.audio:
            return self._copy(template, name)
        encoder = self._kind.new_audio if self._audio == "copy" else self._audio
        if not encoder or template.codec_context is None:
            return self._leave_out(template, name)
        if self._audio == "copy":
            _log.warning(
                "%s: stream %d (%s %s) is encoded anew as %s, since %s files do not hold it",
                *(self._target, template.index, template.type, name, encoder, self._kind.endings[0]),
            )
        try:
            return AudioTranscoder(self._container, template, encoder)
        except (av.FFmpegError, ValueError):
            return self._leave_out(template, name)

    def _add_subtitles(self, template: SubtitleStream, name: str) -> CopiedStream | None:
        if name in self._kind.subtitles:
            return self._copy(template, name)
        text = next((codec for codec in self._kind.subtitles if codec in TEXT_CODECS), None)
        if text is None or name not in TEXT_CODECS:
            return self._leave_out(template, name)
        _log.info("%s: stream %d (subtitles %s) becomes %s", self._target, template.index, name, text)
        return SubtitleTranscoder(self._container, template, text)

    def _copy(self, template: Stream, name: str) -> CopiedStream | None:
        try:
            stream = self._container.add_stream_from_template(template, opaque=True)  # type: ignore[type-var]
        except ValueError:
            return self._leave_out(template, name)
        context = template.codec_context
        framed = name == "aac" and context is not None and context.extradata is None
        return AdtsCopy(stream, template) if framed and self._kind.muxer != "mpegts" else PlainCopy(stream)

    def _leave_out(self, template: Stream, name: str) -> CopiedStream | None:
        _log.warning(
            "%s: stream %d (%s %s) is left out, since %s files do not hold it",
            *(self._target, template.index, template.type, name or "unknown", self._kind.endings[0]),
        )
        return None


def copy_chapters(
    source: av.container.InputContainer, container: av.container.OutputContainer, kind: ContainerKind
) -> None:
    """Carry over the chapters, or say that they cannot be."""
    chapters = source.chapters()
    if chapters and kind.chapters:
        container.set_chapters(chapters)
    elif chapters:
        _log.warning("%d chapters are left out, since %s files hold none", len(chapters), kind.endings[0])


def portable_tags(tags: dict[str, str]) -> dict[str, str]:
    """The tags that stay true in another file.

    >>> portable_tags({"title": "Rain", "ENCODER": "x", "DURATION": "00:00:01", "BPS-eng": "9"})
    {'title': 'Rain'}
    """
    return {
        name: value
        for name, value in tags.items()
        if name.lower() not in FILE_TAGS and not name.lower().startswith(FILE_TAG_STARTS)
    }


def _known_language(tags: dict[str, str], kind: ContainerKind) -> dict[str, str]:
    """The tags with the language by the name that the QuickTime muxer knows: "ger" for "deu"."""
    language = tags.get("language", "")
    known = BIBLIOGRAPHIC_CODES.get(language) if kind.muxer == "mov" else None
    return tags | {"language": known} if known else tags


def codec_name(stream: Stream) -> str:
    """FFmpeg's name of the codec of a stream, or "" if it has none."""
    context = stream.codec_context
    return context.codec.canonical_name if context is not None else getattr(stream, "name", None) or ""


def _check_encoder(kind: ContainerKind, audio: str) -> None:
    if audio in ("copy", "none"):
        return
    try:
        codec = av.Codec(audio, "w")
    except av.codec.codec.UnknownCodecError:
        codec = None
    if codec is None or codec.type != "audio":
        raise UsageError("--audio", f"there is no audio encoder {audio!r}", "use copy, none, aac or libopus")
    if codec.canonical_name not in kind.audio:
        remedy = f"use one of {', '.join(kind.audio)}" if kind.audio else "leave it out"
        raise UsageError("--audio", f"{kind.endings[0]} files do not hold {audio}", remedy)
