"""Dialogue lines of a film, from its subtitles or a subtitle file: plain text and speaker."""

from __future__ import annotations

import html
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vidstyle.comic.lettering.fonts import MUSIC_NOTES
from vidstyle.errors import InputError, log
from vidstyle.media.read.subtitles import SubtitleEvent, parse_subtitles, read_subtitles

Manner = Literal["said", "shouted", "whispered", "thought", "sound"]

# Possessive quantifiers that stop at the next mark keep the time linear in the length of the text.
_TAG_PATTERN = re.compile(r"</?[a-zA-Z][^<>]*+>|<\d[\d:.]*+>|\{\\[^{}]*+\}")
_ITALIC_PATTERN = re.compile(
    r"<i(?:\.[^<>]*+)?>.*?(?:</i>|$)|\{(?>[^{}]*?\\i1)[^{}]*+\}.*?(?:\{(?>[^{}]*?\\i0)[^{}]*+\}|$)",
    re.S | re.I,
)
_LETTERS_PATTERN = r"[^\W\d_\u2e80-\uffef]++"
_WORD_PATTERN = re.compile(rf"(?<![*\w]){_LETTERS_PATTERN}(?:['’-]{_LETTERS_PATTERN})*+(?![*\w])")
"""A word of letters, within which lines do not break."""
_DRAWING_PATTERN = re.compile(r"\{[^{}]*\\p[1-9]")
_DASH_PATTERN = re.compile(r"^\s*[-‐‑–—]+\s*(?=\S)")
_BRACKETS_PATTERN = re.compile(r"^[\[(][^\])]*[\])]$")
_SPEAKER_PATTERN = re.compile(r"^([^\W\d_][\w .'’&#-]{0,23}?)(?:\s*\([^()]*\))?\s?:\s+(?=\S)")
"""A name before speech; it counts only if it is in capitals."""
_NARRATOR_NAMES = "NAR", "NARRATOR", "NARRATION", "VO", "V.O.", "VOICE OVER", "VOICEOVER", "CAPTION"
_MANNER_PATTERN = re.compile(r"^[\[(]\s*([^\W\d_]+)[^\])]*[\])]\s*(?=\S)")
_MANNERS_BY_WORD: dict[str, Manner] = {
    **dict.fromkeys(("whisper", "whispers", "whispering", "softly", "quietly", "sotto"), "whispered"),
    **dict.fromkeys(("thinking", "thinks", "thought", "thoughts"), "thought"),
    **dict.fromkeys(("shout", "shouts", "shouting", "yells", "yelling", "screams", "screaming"), "shouted"),
}
"""Manner of speech by the first word of a remark in brackets before it."""


@dataclass(frozen=True)
class Line:
    """A line of dialogue by one speaker.

    Attributes:
        start, end: in seconds.
        text: without line breaks; stressed words are surrounded by asterisks.
        narrated: whether it is not spoken in the picture: narration, lyrics or a sound description.
        speaker: name, or number within the subtitle; empty if unknown.
        manner: the manner of speech; "sound" for the description of a sound.
        continued: start times in seconds of the further subtitles that continue it.
    """

    start: float
    end: float
    text: str
    narrated: bool = False
    speaker: str = ""
    manner: Manner = "said"
    continued: tuple[float, ...] = ()

    @property
    def times(self) -> tuple[float, ...]:
        """Start times in seconds of all its subtitles."""
        return self.start, *self.continued


def read_lines_of_film(source: str | os.PathLike[str]) -> list[Line]:
    """Read the lines of the subtitles in a film, in chronological order; empty if it has none.

    Raises:
        InputError: the film cannot be read.
    """
    return _parse_events(read_subtitles(source))


def read_lines_of_file(path: Path) -> list[Line]:
    """Read the lines of a subtitle file: .srt, .vtt, or another file with a text subtitle track.

    Raises:
        InputError: it cannot be read, or contains no subtitles.
    """
    is_text = path.suffix.lower() in (".srt", ".vtt")
    lines = _parse_events(parse_subtitles(_read_text(path)) if is_text else read_subtitles(path))
    if not lines:
        raise InputError(path, "holds no subtitles")
    return lines


def _read_text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(path, f"cannot be read: {error.strerror}") from error
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", "replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        log.warning(
            "%s is not UTF-8 and was read as Windows-1252; save it as UTF-8 if letters are wrong", path
        )
        return content.decode("cp1252", "replace")


def _parse_events(events: Iterable[SubtitleEvent]) -> list[Line]:
    """Return the lines of all events in chronological order, without duplicates."""
    found = {line: None for event in events for line in _parse_event(event)}
    return sorted(found, key=lambda line: line.start)


def _parse_event(event: SubtitleEvent) -> Iterator[Line]:
    if _DRAWING_PATTERN.search(event.text):
        return
    marked = event.text.replace("\\N", "\n").replace("\\n", "\n").replace("\\h", " ")
    italic = not _remove_tags(_ITALIC_PATTERN.sub("", marked)).strip()
    marked = marked if italic else _ITALIC_PATTERN.sub(_stress_italics, marked)
    voices = _split_voices(html.unescape(_TAG_PATTERN.sub("", marked)).split("\n"))
    for number, voice in enumerate(voices):
        name, text = _split_speaker(_remove_tags(voice))
        manner, text = _split_manner(text)
        if not text.strip(MUSIC_NOTES + " "):
            continue
        is_narrator = name.upper() in _NARRATOR_NAMES
        narrated = italic or is_narrator or manner == "sound" or text[0] in MUSIC_NOTES
        speaker = "" if is_narrator else event.speaker or name
        yield Line(
            event.start,
            event.end,
            _stress_capitals(text),
            narrated,
            speaker or (str(number + 1) if len(voices) > 1 else ""),
            manner,
        )


def _stress_italics(found: re.Match[str]) -> str:
    """Mark a few words in italics as stressed; a speaker's name in italics stays unmarked."""
    text = _TAG_PATTERN.sub("", found[0])
    return text if text.rstrip().endswith(":") else _WORD_PATTERN.sub(r"*\g<0>*", text)


def _stress_capitals(text: str) -> str:
    """Mark words in capitals as stressed, unless all words are in capitals.

    >>> _stress_capitals("I said NOW, Al."), _stress_capitals("I SAID NOW.")
    ('I said *NOW*, Al.', 'I SAID NOW.')
    """
    if not any(each.islower() for each in text):
        return text
    return _WORD_PATTERN.sub(
        lambda word: f"*{word[0]}*" if word[0].isupper() and len(word[0]) > 1 else word[0], text
    )


def _split_speaker(text: str) -> tuple[str, str]:
    """Split a text into the speaker's name, or an empty text, and the speech.

    >>> _split_speaker("ANNA: Hello."), _split_speaker("Remember: run!"), _split_speaker("NAR: Long ago")
    (('ANNA', 'Hello.'), ('', 'Remember: run!'), ('NAR', 'Long ago'))
    """
    found = _SPEAKER_PATTERN.match(text)
    if found is None or not (found[1].isupper() or found[1].upper() in _NARRATOR_NAMES):
        return "", text
    return found[1], text[found.end() :]


def _split_manner(text: str) -> tuple[Manner, str]:
    """Return the manner of speech, and the text without a remark about it.

    >>> _split_manner("(whispering) Come."), _split_manner("[thunder]"), _split_manner("No!")
    (('whispered', 'Come.'), ('sound', 'thunder'), ('said', 'No!'))
    >>> _split_manner("RUN, ALL OF YOU!")
    ('shouted', 'RUN, ALL OF YOU!')
    """
    if _BRACKETS_PATTERN.match(text):
        inner = text[1:-1].strip()
        # Music continues for a while, so its notes are a caption.
        return ("said", inner) if inner[:1] in tuple(MUSIC_NOTES) else ("sound", inner)
    found = _MANNER_PATTERN.match(text)
    manner = _MANNERS_BY_WORD.get(found[1].lower()) if found else None
    if found and manner:
        return manner, text[found.end() :]
    letters = [each for each in text if each.isalpha()]
    is_shouted = "!" in text[-3:] and (("!!" in text or "?!" in text) or _is_loud(letters))
    return ("shouted" if is_shouted else "said"), text


def _is_loud(letters: list[str]) -> bool:
    """Whether a text of several letters is in capitals, in a script that has them."""
    return len(letters) > 3 and all(each.isupper() for each in letters)


def _remove_tags(text: str) -> str:
    """Return the text without tags, line breaks and invisible characters."""
    shown = "".join(
        each if each.isprintable() else " "
        for each in _TAG_PATTERN.sub("", text)
        if each not in "\u200b\u200e\u200f"
    )
    return " ".join(shown.split())


def _split_voices(rows: list[str]) -> list[str]:
    """Return the text of each speaker: a dash marks a change of speaker.

    >>> _split_voices(["- Hello.", "- Who", "is there?"]), _split_voices(["- Yes."])
    (['Hello.', 'Who is there?'], ['Yes.'])
    >>> _split_voices(["One", "two"])
    ['One two']
    """
    voices: list[str] = []
    for row in rows:
        if _DASH_PATTERN.match(row) or not voices:
            voices.append(_DASH_PATTERN.sub("", row))
        else:
            voices[-1] += f" {row}"
    return [voice for voice in voices if voice.strip()]
