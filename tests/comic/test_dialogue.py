"""Subtitles: parsing of lenient files, and assignment of lines to panels."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.lettering.dialogue import (
    EASY_PANEL_LETTERS,
    MAX_DISTANCE_SECONDS,
    MAX_PANEL_LETTERS,
    MAX_PANEL_LINES,
    assign_lines,
    count_panels,
)
from vidstyle.comic.lettering.omitted import list_omitted
from vidstyle.comic.lettering.subtitle_lines import Line, read_lines_of_file
from vidstyle.errors import InputError
from vidstyle.regions.boxes import Box


def key_frame(time: float, scene: int = 0, faces: tuple[Box, ...] = (Box(10, 10, 30, 30),)) -> KeyFrame:
    return KeyFrame(time, (90, 160), 0.5, Box(0, 0, 160, 90), faces, scene)


def read(tmp_path: Path, text: str | bytes, name: str = "words.srt") -> list[Line]:
    path = tmp_path / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return read_lines_of_file(path)


def texts(lines: Iterable[Line]) -> list[str]:
    return [line.text for line in lines]


SRT = "1\n00:00:01,000 --> 00:00:02,000\nOne.\n\n2\n00:00:03,000 --> 00:00:04,000\nTwo\nrows.\n"


@pytest.mark.parametrize(
    "text",
    [
        SRT.encode(),
        SRT.replace("\n", "\r\n").encode(),
        SRT.replace("\n", "\r").encode(),
        ("\ufeff" + SRT).encode(),
        SRT.encode("utf-16"),
        SRT.replace(",", ".").encode(),
        SRT.replace("00:00:0", "0:0:").encode(),
        SRT.replace("1\n00", "00", 1).replace("2\n00", "00").encode(),
        SRT.replace(" --> ", "-->").encode(),
        SRT.replace("Two\n", "Two\n\n").encode(),
        SRT.replace("\n\n2", "\n2").replace("2\n00", "\n2\n00").encode(),
        SRT.replace("4,000", "4,000  X1:100 X2:600 Y1:50 Y2:60").encode(),
    ],
)
def test_variants_of_subrip_are_read(text: bytes, tmp_path: Path) -> None:
    lines = read(tmp_path, text)
    assert [(line.start, line.text) for line in lines] == [(1.0, "One."), (3.0, "Two rows.")]
    assert [line.end for line in lines] == [2.0, 4.0]


def test_text_that_is_not_utf_8_is_read_as_windows_1252(tmp_path: Path) -> None:
    assert texts(read(tmp_path, SRT.replace("One", "Ça va, café").encode("cp1252"))) == [
        "Ça va, café.",
        "Two rows.",
    ]


def test_webvtt_blocks_without_speech_are_skipped(tmp_path: Path) -> None:
    lines = read(
        tmp_path,
        "WEBVTT - with a title\nKind: captions\n\nSTYLE\n::cue { color: red }\n\nNOTE\nnot said\n\n"
        "intro\n00:01.500 --> 00:02.500 line:0 align:start\n<v.loud Anna>Hello <c.red>there</c> &amp; "
        "<b>you</b>\n\nNOTE not said\neither\n\n01:00:00.000 --> 01:00:01.000\n<00:00:01.000>3 &lt; 4 <3\n",
        "words.vtt",
    )
    assert [(line.start, line.text, line.speaker) for line in lines] == [
        (1.5, "Hello there & you", "Anna"),
        (3600.0, "3 < 4 <3", ""),
    ]


@pytest.mark.parametrize(
    ("text", "plain", "narrated"),
    [
        ("<i>Long ago.</i>", "Long ago.", True),
        ("<i>Long</i>\n<i>ago.</i>", "Long ago.", True),
        (r"{\an8}{\i1}Long ago.{\i0}", "Long ago.", True),
        ("She <i>is</i> here.", "She *is* here.", False),
        ("I did NOT <b>ask</b>.", "I did *NOT* ask.", False),
        ("I did <i>NOT. Ask</i> it.", "I did *NOT*. *Ask* it.", False),
        ("<i>ANNA:</i> I AM.", "I AM.", False),
        ("[John] Hello (yes)", "[John] Hello (yes)", False),
        ("♪ La la ♪", "♪ La la ♪", True),
        ("[♪ Slow music]", "♪ Slow music", True),
        *((text, "thunder", True) for text in ("[thunder]", "(thunder)")),
        ("NAR: Long ago.", "Long ago.", True),
        ("Narrator: Long ago.", "Long ago.", True),
        (r"One\Ntwo\hthree", "One two three", False),
        ('<font color="#ff0000">Red</font>', "Red", False),
        ("- Alone.", "Alone.", False),
        ("a\u200b\x07b\tc", "a b c", False),
    ],
)
def test_markup_is_removed_and_marks_narrators(text: str, plain: str, narrated: bool, tmp_path: Path) -> None:
    (line,) = read(tmp_path, SRT.partition("\n\n2")[0].replace("One.", text))
    assert (line.text, line.narrated) == (plain, narrated)


@pytest.mark.parametrize(
    ("text", "plain", "speaker", "manner"),
    [
        ("ANNA: Hello.", "Hello.", "ANNA", "said"),
        ("MR. O’NEIL (on the phone): Hello.", "Hello.", "MR. O’NEIL", "said"),
        ("Remember: run!", "Remember: run!", "", "said"),
        ("(whispering) Come here.", "Come here.", "", "whispered"),
        ("TOM: [thinking] Oh.", "Oh.", "TOM", "thought"),
        ("(sighs) Well.", "(sighs) Well.", "", "said"),
        ("GET OUT!", "GET OUT!", "", "shouted"),
        ("What?!", "What?!", "", "shouted"),
        ("No!", "No!", "", "said"),
        ("[door slams]", "door slams", "", "sound"),
    ],
)
def test_speakers_and_manners_are_recognized(
    text: str, plain: str, speaker: str, manner: str, tmp_path: Path
) -> None:
    (line,) = read(tmp_path, SRT.partition("\n\n2")[0].replace("One.", text))
    assert (line.text, line.speaker, line.manner) == (plain, speaker, manner)


def test_a_sentence_continues_in_cues_without_a_speaker() -> None:
    """A narrator's sentence is one caption, however the cues split it; another speaker ends it."""
    first = Line(1, 2, "It was the year when the machines", narrated=True)
    rest = Line(2.1, 4, "came back to the city of canals, and nobody at all was ready for them.")
    ((line,),), _ = assign_lines([first, rest], [key_frame(1)])
    assert line.narrated and line.text == f"{first.text} {rest.text}"
    for other in (Line(2.1, 4, "came back.", speaker="ANNA"), Line(2.1, 4, "Came back?")):
        assert len(assign_lines([first, other], [key_frame(1)])[0][0]) == 2


def test_two_voices_are_two_lines(tmp_path: Path) -> None:
    lines = read(tmp_path, SRT.replace("Two\nrows.", "- Who\nis it?\n– Me."))
    assert [(line.text, line.speaker) for line in lines[1:]] == [("Who is it?", "1"), ("Me.", "2")]


@pytest.mark.parametrize("said", ["", "<i></i>", "♪", r"{\p1}m 0 0 l 100 0{\p0}", "   "])
def test_cues_without_text_give_no_line(said: str, tmp_path: Path) -> None:
    assert texts(read(tmp_path, SRT.replace("One.", said))) == ["Two rows."]


def test_events_are_sorted_and_unique(tmp_path: Path) -> None:
    shuffled = "\n".join(
        f"00:00:{second:02},000 --> 00:00:{end:02},000\n{text}\n"
        for second, end, text in [(5, 6, "b"), (1, 2, "a"), (5, 6, "b"), (9, 3, "backwards")]
    )
    lines = read(tmp_path, shuffled)
    assert [(line.start, line.end, line.text) for line in lines] == [
        *[(1, 2, "a"), (5, 6, "b")],
        (9, 9, "backwards"),
    ]


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02\xff" * 50, b"only words", b"1\n2\n3\n"])
def test_a_file_without_subtitles_is_refused(content: bytes, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no subtitles"):
        read(tmp_path, content)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_lines_of_file(tmp_path / "none.srt")


def test_lines_are_assigned_to_the_nearest_panels() -> None:
    lines = [Line(start, start + 1, f"At {start}.") for start in (0, 2, 3.5, 5, 6, 7)]
    panels, lost = assign_lines(lines, [key_frame(2.5), key_frame(5.5), key_frame(7.1)])
    assert [texts(panel) for panel in panels] == [
        ["At 0.", "At 2."],
        ["At 3.5.", "At 5."],
        ["At 6.", "At 7."],
    ]
    assert lost == []


def test_distant_and_excess_lines_are_omitted_and_returned() -> None:
    lines = [Line(100 + number, 100.5 + number, f"Line {number}.") for number in range(2 * MAX_PANEL_LINES)]
    far = Line(100 - 2 * MAX_DISTANCE_SECONDS, 100 - 1.1 * MAX_DISTANCE_SECONDS, "Too soon.")
    panels, lost = assign_lines([far, *lines], [key_frame(100)])
    assert texts(panels[0]) == [f"Line {number}." for number in range(MAX_PANEL_LINES)]
    assert lost == [far, *lines[MAX_PANEL_LINES:]]
    assert assign_lines([far], [key_frame(100)])[0] == [[]]


def test_one_long_line_is_shown_whole() -> None:
    long = "x" * (MAX_PANEL_LETTERS + 50) + "."
    panels, _ = assign_lines([Line(1, 2, long), Line(3, 4, "y")], [key_frame(1)])
    assert texts(panels[0]) == [long]


def test_halves_of_a_sentence_are_joined() -> None:
    lines = [Line(1, 2, "We have to follow,"), Line(2.1, 3, "all of us."), Line(3.1, 4, "Now.")]
    assert texts(assign_lines(lines, [key_frame(1)])[0][0]) == ["We have to follow, all of us.", "Now."]
    of_two = [lines[0], Line(2.1, 3, "all of us.", speaker="2")]
    assert len(assign_lines(of_two, [key_frame(1)])[0][0]) == 2


def test_joined_subtitles_keep_their_times() -> None:
    lines = [Line(1, 2, "We have to follow,"), Line(2.1, 3, "all"), Line(3.1, 4, "of us.")]
    ((line,),), _ = assign_lines(lines, [key_frame(1)])
    assert line.times == (1, 2.1, 3.1)


def test_a_sentence_too_long_for_one_line_continues_after_an_ellipsis() -> None:
    """So that no caption ends in the middle of a sentence without a sign."""
    words = "and so we walked along the canals of the city for the whole night,"
    lines = [Line(number, number + 0.9, words) for number in range(5)] + [Line(5, 6, "until it ended.")]
    panels, lost = assign_lines(lines, [key_frame(0.5), key_frame(3), key_frame(5.5)])
    shown = [line.text for panel in panels for line in panel]
    assert lost == [] and len(shown) == 2
    assert shown[0].endswith("…") and shown[1].startswith("…") and shown[1].endswith("ended.")


def test_a_voice_over_a_first_picture_without_faces_belongs_to_a_narrator() -> None:
    lines = [Line(1, 2, "Here."), Line(10, 11, "There.")]
    panels, _ = assign_lines(lines, [key_frame(1, faces=()), key_frame(10, scene=1, faces=())])
    assert [panel[0].narrated for panel in panels] == [True, False]


def test_excess_lines_move_to_the_next_panel() -> None:
    """Six lines are spoken within a few seconds."""
    said = "These are words of some forty letters, no. %d."
    lines = [Line(number, number + 0.9, said % number) for number in range(6)]
    panels, _ = assign_lines(lines, [key_frame(0.5), key_frame(6.5), key_frame(13)])
    assert texts(line for panel in panels for line in panel) == texts(lines)
    assert [len(panel) for panel in panels] == [2, 2, 2]
    few, _ = assign_lines(lines[:2], [key_frame(0.5), key_frame(6.5)])
    assert [len(panel) for panel in few] == [2, 0]


@pytest.mark.parametrize("seeds", [range(8), pytest.param(range(8, 30), marks=pytest.mark.thorough)], ids=len)
def test_lines_are_never_out_of_order_nor_crowded(seeds: range) -> None:
    for seed in seeds:
        random = np.random.default_rng(seed)
        starts = np.sort(random.uniform(0, 60, 40))
        lines = [
            Line(start, start + 1.5, f"{number} {'word ' * int(random.integers(1, 16))}!")
            for number, start in enumerate(starts)
        ]
        key_frames = [key_frame(time) for time in np.sort(random.uniform(0, 60, int(random.integers(1, 12))))]
        panels, lost = assign_lines(lines, key_frames)
        shown = [line for panel in panels for line in panel]
        assert [line.start for line in shown] == sorted(line.start for line in shown)
        assert len(shown) + len(lost) == 40
        for panel, each in zip(panels, key_frames, strict=True):
            assert len(panel) <= MAX_PANEL_LINES
            assert len(panel) < 2 or sum(len(line.text) for line in panel) <= MAX_PANEL_LETTERS
            assert all(
                line.start - MAX_DISTANCE_SECONDS <= each.time <= line.end + MAX_DISTANCE_SECONDS
                for line in panel
            )


def test_long_dialogue_needs_many_panels() -> None:
    assert count_panels([]) == 0
    assert count_panels([Line(0, 1, "x" * EASY_PANEL_LETTERS)] * 5) == 5


SUBTITLE_HABITS = {
    "short cues": ("srt", "{text}"),
    "two rows": ("srt", "{rows}"),
    "names": ("srt", "ANNA: {text}"),
    "dots": ("srt", "...{text}..."),
    "manners": ("srt", "(whispering) {text}"),
    "italics": ("srt", "<i>{text}</i>"),
    "marks": ("srt", r"{{\an8}}<font color='#fff'>{text}</font>"),
    "voices": ("vtt", "<v Anna>{text}"),
    "dashes": ("srt", "- {text}\n- Yes."),
    "sounds": ("vtt", "[door slams]\n{rows}"),
}
"""Common ways to write subtitles: the format and a cue. The last two insert text into sentences."""
MAX_CUE_WORDS = 7
"""Number of words in a cue."""


@pytest.mark.parametrize("habit", SUBTITLE_HABITS)
def test_no_word_is_lost_and_no_sentence_cut(habit: str, tmp_path: Path) -> None:
    """Sentences of three to twenty words, split into cues after a few words, as in real subtitles."""
    (kind, pattern), random = (
        SUBTITLE_HABITS[habit],
        np.random.default_rng(list(SUBTITLE_HABITS).index(habit)),
    )
    sentences = [[f"w{number}x{word}" for word in range(int(random.integers(3, 21)))] for number in range(25)]
    parts = [
        words[at : at + MAX_CUE_WORDS] for words in sentences for at in range(0, len(words), MAX_CUE_WORDS)
    ]
    file = "WEBVTT\n\n" if kind == "vtt" else ""
    for number, part in enumerate(parts):
        ends = part[-1] in {words[-1] for words in sentences}
        start, end = (
            f"00:{second // 60:02}:{second % 60:02}.{part}"
            for second, part in ((2 * number, "000"), (2 * number + 1, "900"))
        )
        text, rows = (between.join([" ".join(part[:3]), *part[3:]]) for between in " \n")
        said = pattern.format(text=text, rows=rows)
        file += f"{start} --> {end}\n{said.replace('...', '') + '.' if ends else said}\n\n"
    lines = read(tmp_path, file, f"words.{kind}")
    key_frames = [key_frame(time) for time in np.arange(0, 2 * len(parts), 3.0)]
    panels, lost = assign_lines(lines, key_frames)
    assert lost == []
    shown = [" ".join(texts(panel)).replace("...", "") for panel in panels]
    for words in sentences:
        assert all(any(word in panel.replace(".", "").split() for panel in shown) for word in words)
        if len(" ".join(words)) < MAX_PANEL_LETTERS and habit not in list(SUBTITLE_HABITS)[-2:]:
            assert any(" ".join(words) in panel for panel in shown), words


def test_many_omitted_subtitles_are_reported_as_runs() -> None:
    lines = [Line(float(number), number + 0.9, "said") for number in range(200)]
    assert list_omitted(lines[3:5], lines) == ["0:03.0", "0:04.0"]
    lost = [*lines[:60], lines[61], *lines[100:]]
    assert list_omitted(lost, lines) == ["0:00.0 to 0:59.0 (60)", "1:01.0", "1:40.0 to 3:19.0 (100)"]
    joined = Line(0.0, 200.0, "said", continued=tuple(line.start for line in lines[1:]))
    assert list_omitted([joined], []) == ["0:00.0 to 3:19.0 (200)"]
