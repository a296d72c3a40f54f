"""Dialogue lines of a film, from its subtitles or a subtitle file: plain text and speaker."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vidstyle.comic.lettering.fonts import NOTES
from vidstyle.errors import InputError, log
from vidstyle.media.read.subtitles import SubtitleEvent, parse_subtitles, read_subtitles

Manner = Literal["said", "shouted", "whispered", "thought", "sound"]

# Possessive, and never beyond the next mark, so that their time is linear in the length of the text.
_TAG = re.compile(r"</?[a-zA-Z][^<>]*+>|<\d[\d:.]*+>|\{\\[^{}]*+\}")
_ITALIC = re.compile(
    r"<i(?:\.[^<>]*+)?>.*?(?:</i>|$)|\{(?>[^{}]*?\\i1)[^{}]*+\}.*?(?:\{(?>[^{}]*?\\i0)[^{}]*+\}|$)",
    re.S | re.I,
)
_LETTERS = r"[^\W\d_\u2e80-\uffef]++"
_WORD = re.compile(rf"(?<![*\w]){_LETTERS}(?:['’-]{_LETTERS})*+(?![*\w])")
"""A word of letters that lines do not break between."""
_DRAWING = re.compile(r"\{[^{}]*\\p[1-9]")
_DASH = re.compile(r"^\s*[-‐‑–—]+\s*(?=\S)")
_BRACKETS = re.compile(r"^[\[(][^\])]*[\])]$")
_SPEAKER = re.compile(r"^([^\W\d_][\w .'’&#-]{0,23}?)(?:\s*\([^()]*\))?\s?:\s+(?=\S)")
"""A name before what is said; it counts if it is in capitals."""
_NARRATORS = "NAR", "NARRATOR", "NARRATION", "VO", "V.O.", "VOICE OVER", "VOICEOVER", "CAPTION"
_HOW = re.compile(r"^[\[(]\s*([^\W\d_]+)[^\])]*[\])]\s*(?=\S)")
_MANNERS: dict[str, Manner] = {
    **dict.fromkeys(("whisper", "whispers", "whispering", "softly", "quietly", "sotto"), "whispered"),
    **dict.fromkeys(("thinking", "thinks", "thought", "thoughts"), "thought"),
    **dict.fromkeys(("shout", "shouts", "shouting", "yells", "yelling", "screams", "screaming"), "shouted"),
}
"""The first word of a remark in brackets before what is said in that manner."""


@dataclass(frozen=True)
class Line:
    """A line of dialogue by one speaker.

    Attributes:
        start, end: in seconds.
        text: without line breaks; asterisks stand around words that are stressed.
        narrated: whether it is not spoken in the picture: narration, lyrics or a sound description.
        speaker: name, or number within the subtitle; empty if unknown.
        manner: how it is said; "sound" for a sound that is described.
    """

    start: float
    end: float
    text: str
    narrated: bool = False
    speaker: str = ""
    manner: Manner = "said"


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
    marked = marked if italic else _ITALIC.sub(_in_italics, marked)
    voices = _voices(html.unescape(_TAG.sub("", marked)).split("\n"))
    for number, voice in enumerate(voices):
        name, text = _named(_plain(voice))
        manner, text = _manner(text)
        if not text.strip(NOTES + " "):
            continue
        is_narrator = name.upper() in _NARRATORS
        narrated = italic or is_narrator or manner == "sound" or text[0] in NOTES
        speaker = "" if is_narrator else event.speaker or name
        yield Line(
            event.start,
            event.end,
            _stressed(text),
            narrated,
            speaker or (str(number + 1) if len(voices) > 1 else ""),
            manner,
        )


def _in_italics(found: re.Match[str]) -> str:
    """A few words in italics as stressed ones; a name before what is said is only a name."""
    text = _TAG.sub("", found[0])
    return text if text.rstrip().endswith(":") else _WORD.sub(r"*\g<0>*", text)


def _stressed(text: str) -> str:
    """The text with asterisks around words in capitals, unless all are.

    >>> _stressed("I said NOW, Al."), _stressed("I SAID NOW.")
    ('I said *NOW*, Al.', 'I SAID NOW.')
    """
    if not any(each.islower() for each in text):
        return text
    return _WORD.sub(lambda word: f"*{word[0]}*" if word[0].isupper() and len(word[0]) > 1 else word[0], text)


def _named(text: str) -> tuple[str, str]:
    """The name before what is said, or nothing, and what is said.

    >>> _named("ANNA: Hello."), _named("Remember: run!"), _named("NAR: Long ago")
    (('ANNA', 'Hello.'), ('', 'Remember: run!'), ('NAR', 'Long ago'))
    """
    found = _SPEAKER.match(text)
    if found is None or not (found[1].isupper() or found[1].upper() in _NARRATORS):
        return "", text
    return found[1], text[found.end() :]


def _manner(text: str) -> tuple[Manner, str]:
    """How something is said, and the text without a remark about that.

    >>> _manner("(whispering) Come."), _manner("[thunder]"), _manner("RUN, ALL OF YOU!"), _manner("No!")
    (('whispered', 'Come.'), ('sound', 'thunder'), ('shouted', 'RUN, ALL OF YOU!'), ('said', 'No!'))
    """
    if _BRACKETS.match(text):
        inner = text[1:-1].strip()
        # Music is heard all the time: its notes are a caption.
        return ("said", inner) if inner[:1] in tuple(NOTES) else ("sound", inner)
    found = _HOW.match(text)
    manner = _MANNERS.get(found[1].lower()) if found else None
    if found and manner:
        return manner, text[found.end() :]
    letters = [each for each in text if each.isalpha()]
    is_shouted = "!" in text[-3:] and (("!!" in text or "?!" in text) or _is_loud(letters))
    return ("shouted" if is_shouted else "said"), text


def _is_loud(letters: list[str]) -> bool:
    """Whether a text of several letters is in capitals, in a script that has them."""
    return len(letters) > 3 and all(each.isupper() for each in letters)


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
