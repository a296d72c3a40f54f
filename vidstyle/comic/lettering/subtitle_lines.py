"""Dialogue lines of a film, from its subtitles or a subtitle file: plain text and speaker."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from vidstyle.comic.lettering.fonts import NOTES
from vidstyle.errors import InputError, log
from vidstyle.media.read.subtitles import SubtitleEvent, parse_subtitles, read_subtitles

# Possessive, and never beyond the next mark, so that their time is linear in the length of the text.
_TAG = re.compile(r"</?[a-zA-Z][^<>]*+>|<\d[\d:.]*+>|\{\\[^{}]*+\}")
_ITALIC = re.compile(
    r"<i(?:\.[^<>]*+)?>.*?(?:</i>|$)|\{(?>[^{}]*?\\i1)[^{}]*+\}.*?(?:\{(?>[^{}]*?\\i0)[^{}]*+\}|$)",
    re.S | re.I,
)
_DRAWING = re.compile(r"\{[^{}]*\\p[1-9]")
_DASH = re.compile(r"^\s*[-‐‑–—]+\s*(?=\S)")
_BRACKETS = re.compile(r"^[\[(][^\])]*[\])]$")


@dataclass(frozen=True)
class Line:
    """A line of dialogue by one speaker.

    Attributes:
        start, end: in seconds.
        text: plain text without line breaks.
        narrated: whether it is not spoken in the picture: narration, lyrics or a sound description.
        speaker: name, or number within the subtitle; empty if unknown.
    """

    start: float
    end: float
    text: str
    narrated: bool = False
    speaker: str = ""


def lines_of_film(source: str | os.PathLike[str]) -> list[Line]:
    """The lines of the film's own subtitles, in chronological order; empty if it has none.

    Raises:
        InputError: the film cannot be read.
    """
    return _lines(read_subtitles(source))


def lines_of_file(path: Path) -> list[Line]:
    """The lines of a subtitle file: .srt, .vtt, or another file with a text subtitle track.

    Raises:
        InputError: it cannot be read, or holds no subtitles.
    """
    is_text = path.suffix.lower() in (".srt", ".vtt")
    lines = _lines(parse_subtitles(_text_of(path)) if is_text else read_subtitles(path))
    if not lines:
        raise InputError(path, "holds no subtitles")
    return lines


def _text_of(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from error
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        log.warning("%s is not UTF-8 text: read as Windows-1252; save it as UTF-8 if letters are wrong", path)
        return content.decode("cp1252", "replace")


def _lines(events: Iterable[SubtitleEvent]) -> list[Line]:
    """The lines of all events in chronological order, without duplicates."""
    found = {line: None for event in events for line in _lines_of(event)}
    return sorted(found, key=lambda line: line.start)


def _lines_of(event: SubtitleEvent) -> Iterator[Line]:
    if _DRAWING.search(event.text):
        return
    marked = event.text.replace("\\N", "\n").replace("\\n", "\n").replace("\\h", " ")
    italic = not _plain(_ITALIC.sub("", marked)).strip()
    voices = _voices(html.unescape(_TAG.sub("", marked)).split("\n"))
    for number, voice in enumerate(voices):
        text = _plain(voice)
        narrated = italic or text[:1] in tuple(NOTES) or bool(_BRACKETS.match(text))
        if text.strip(NOTES + " "):
            speaker = event.speaker or (str(number + 1) if len(voices) > 1 else "")
            yield Line(event.start, event.end, text, narrated, speaker)


def _plain(text: str) -> str:
    """The text without tags, line breaks and invisible characters."""
    shown = "".join(
        each if each.isprintable() else " " for each in _TAG.sub("", text) if each not in "\u200b\u200e\u200f"
    )
    return " ".join(shown.split())


def _voices(rows: list[str]) -> list[str]:
    """The text of each speaker: a dash marks a change of speaker.

    >>> _voices(["- Hello.", "- Who", "is there?"]), _voices(["- Yes."]), _voices(["One", "two"])
    (['Hello.', 'Who is there?'], ['Yes.'], ['One two'])
    """
    voices: list[str] = []
    for row in rows:
        if _DASH.match(row) or not voices:
            voices.append(_DASH.sub("", row))
        else:
            voices[-1] += f" {row}"
    return [voice for voice in voices if voice.strip()]
