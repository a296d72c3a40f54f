"""Subtitle files with odd times, words and lines."""

from __future__ import annotations

from random import Random

from tools.fuzzing.damage import WORDS, edit_text

ASS_HEADER = (
    *("[Script Info]", "ScriptType: v4.00+", "[Events]"),
    "Format: Layer, Start, End, Style, Name, MarginL, MarginR, MarginV, Effect, Text",
)
STORY = [
    (1.0, 2.5, "Good morning."),
    (3.0, 4.0, "- Is it?\n- <i>It is.</i>"),
    (4.2, 5.0, "A longer line of a narrator who has much to say about the weather."),
    (5.5, 6.0, "[door slams]"),
]


def subtitle_case(random: Random) -> tuple[str, bytes]:
    """Return a subtitle file with odd times, words and lines."""
    suffix = random.choice((".srt", ".vtt", ".ass"))
    story = list(STORY)
    for _ in range(random.choice((0, 1, 4))):
        start = random.choice((0, 2, random.uniform(0, 9), 1e9, 10**40))
        word = random.choice((random.choice(WORDS), "mop", chr(random.randrange(0xD800)))) * random.choice(
            (1, 30, 2000)
        )
        story.insert(random.randrange(len(story)), (start, start + random.choice((0, 1, -3, 1e6)), word))
    return suffix, edit_text(random, _subtitle_text(suffix, story * random.choice((1, 1, 1, 100))))


def _subtitle_text(suffix: str, story: list[tuple[float, float, str]]) -> str:
    if suffix == ".ass":
        lines = [
            f"Dialogue: 0,{_clock(start)},{_clock(end)},Default,Ann,0,0,0,,{text}"
            for start, end, text in story
        ]
        return "\n".join([*ASS_HEADER, *lines])
    blocks = [
        f"{number}\n{_clock(start)} --> {_clock(end)}\n{text}\n"
        for number, (start, end, text) in enumerate(story, 1)
    ]
    return ("WEBVTT\n\n" if suffix == ".vtt" else "") + "\n".join(blocks)


def _clock(seconds: float) -> str:
    minutes, seconds = divmod(seconds, 60)
    return f"{int(minutes // 60):02d}:{int(minutes % 60):02d}:{seconds:06.3f}"
