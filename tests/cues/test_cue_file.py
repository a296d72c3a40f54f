"""Cue files: what they say, and one line for each mistake."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import pytest
from covering import DAY

from vidstyle.cues.cue_file import cue_file_text, read_cue_file, scene_cues
from vidstyle.cues.cue_list import CueList
from vidstyle.errors import InputError, VidstyleError
from vidstyle.style import load_style

HEAD = "format = 1\nrate = 24\nscenes = [0, 2.5, 7]\n"


def read(folder: Path, text: str, head: str = HEAD) -> CueList:
    (folder / "cues.toml").write_text(head + text, encoding="utf-8")
    return read_cue_file(folder / "cues.toml")


def test_what_the_command_writes_is_read(tmp_path: Path) -> None:
    starts = [Fraction(0), Fraction(1001, 24000), Fraction(9)]
    cues = read(
        tmp_path, cue_file_text(starts, Fraction(24000, 1001), scene_cues(["ink", None, "noir:gray"])), ""
    )
    assert [(cue.time, cue.style.name) for cue in cues.cues][1][0] == 9 and len(cues.cues) == 2
    assert cues.cues[0].style == load_style("ink")


def test_the_example_of_the_guide_is_valid(tmp_path: Path) -> None:
    guide = (Path(__file__).parents[2] / "docs" / "cues.md").read_text(encoding="utf-8")
    cues = read(tmp_path, guide.partition("```toml\n")[2].partition("```")[0], "").cues
    assert [cue.style.name for cue in cues] == ["ink", "ink", "poster", "comic"]


@pytest.mark.parametrize(
    ("time", "seconds"),
    [("1.5", 1.5), ('"1:02.5"', 62.5), ('"1:00:00"', 3600), ('"00:00:02:12"', 2.5), ("12", 12)],
)
def test_times(tmp_path: Path, time: str, seconds: float) -> None:
    assert read(tmp_path, f'[[cue]]\ntime = {time}\nstyle = "ink"').cues[0].time == Fraction(seconds)


def test_a_cue_without_a_style_sets_values_of_the_style_before(tmp_path: Path) -> None:
    text = '[[cue]]\nscene = 1\nstyle = "poster"\nvalues = { strength = 0.5 }\n'
    text += "[[cue]]\nscene = 2\nvalues = { steady = 0.1 }\n[[cue]]\nscene = 3\nseconds = 1"
    first, second, third = read(tmp_path, text).cues
    assert (first.style.strength, second.style.strength, second.style.steady) == (0.5, 0.5, 0.1)
    assert second.time == Fraction(5, 2) and third.transition == "fade" and third.style == second.style


def test_styles_are_found_next_to_the_cue_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.toml").write_text('format = 1\nname = "mine"\nink = "#123456"')
    monkeypatch.chdir("/")
    assert read(tmp_path, '[[cue]]\ntime = 0\nstyle = "mine.toml"').cues[0].style.ink == "#123456"


@pytest.mark.parametrize(
    ("text", "mistake"),
    [
        ("", "has no cues"),
        ("[[cue]]\ntime = 0", "cue 1: needs a style"),
        ('[[cue]]\nstyle = "ink"', "cue 1: needs time or scene"),
        ('[[cue]]\ntime = 0\nscene = 1\nstyle = "ink"', "cue 1: needs time or scene, and not both"),
        ('[[cue]]\nscene = 4\nstyle = "ink"', "cue 1: there is no scene 4; the list of scenes has 3"),
        ('[[cue]]\nscene = true\nstyle = "ink"', "cue 1: there is no scene True"),
        ('[[cue]]\ntime = -1\nstyle = "ink"', "cue 1: time = -1 is not a number from 0"),
        ('[[cue]]\ntime = nan\nstyle = "ink"', "cue 1: time = nan is not a number"),
        ('[[cue]]\ntime = "00:00:00:24"\nstyle = "ink"', "has frame 24 of a second with 24 frames"),
        ('[[cue]]\ntime = "soon"\nstyle = "ink"', "'soon' is not a time"),
        ('[[cue]]\ntime = 0\nstyle = "inc"', "there is no style 'inc'; did you mean 'ink'"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\ncolour = 1', "cue 1: there is no key 'colour'"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\ncurve = "bend"', "'bend' is not one of hold, linear, ease"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\ntransition = "fade"', "a fade needs seconds"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\ntransition = "cut"\nseconds = 1', "a cut takes no seconds"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\nvalues = { strength = 3 }', "3 is outside 0 to 1"),
        ('[[cue]]\ntime = 0\nstyle = "ink"\nvalues = { blur = 3 }', "blur"),
        ('[[cue]]\ntime = 2\nstyle = "ink"\n[[cue]]\ntime = 1', "cue 2 begins at 1 s, not after cue 1"),
        ("cue = 5", "has no cues"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line(tmp_path: Path, text: str, mistake: str) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path, text)
    assert mistake in str(caught.value) and "\n" not in str(caught.value)


def test_another_format_and_unreadable_files_are_refused(tmp_path: Path) -> None:
    for text in ("format = 2", "format = ", "\0", "x" * (2 << 20)):
        with pytest.raises(InputError):
            read(tmp_path, text, "")
    with pytest.raises(InputError, match="cannot be read"):
        read_cue_file(tmp_path / "none.toml")


LINES = {
    "time": ["0", "1.5", "7", "1e9", "-2", "'0:3'", "'00:00:04:02'", "'x'", "[]"],
    "scene": ["1", "2", "3", "4", "0", "true"],
    "style": ['"ink"', '"noir"', '"plain"', '"poster"', '"nothing"', '"/dev/zero.toml"', "7"],
    "values": [
        "{ strength = 0.5 }",
        "{}",
        "{ ink = 'red' }",
        "{ strength = 2 }",
        "{ sobel = { x = 1 } }",
        "3",
    ],
    "seconds": ["0.5", "1", "0", "100", "-1", "inf", "'1'"],
    "transition": ['"fade"', '"wipe"', '"cut"', '"melt"', "1"],
    "curve": ['"linear"', '"ease"', '"hold"', "[]"],
}
"""Values of the keys of a cue, the likeliest ones first."""


def random_file(draw: random.Random) -> Iterator[str]:
    """Yield the lines of a file of which some parts are wrong."""

    def line(key: str, values: list[str]) -> str:
        return f"{key} = {values[min(int(draw.expovariate(0.7)), len(values) - 1)]}"

    yield line("format", ["1", "1", "1", "2", "'1'"])
    yield line("scenes", ["[0, 1, 2.5]", "[0, 3, 5]", "[]", "7", "[nan]"])
    yield line("rate", ["25", "29.97", "0", "1e400"])
    for number in range(draw.randint(1, 4)):
        yield "[[cue]]"
        place = draw.choice(["time", "scene"])
        yield f"{place} = {number + 1}" if draw.random() < 0.7 else line(place, LINES[place])
        for key, values in list(LINES.items())[2:]:
            if draw.random() < (0.7 if key == "style" else 0.25):
                yield line(key, values)


def test_random_files_are_read_or_refused_in_one_line(tmp_path: Path) -> None:
    draw, used = random.Random(DAY), 0
    for _ in range(1000):
        try:
            cues = read(tmp_path, "\n".join(random_file(draw)), "")
        except VidstyleError as error:
            assert "\n" not in str(error) and str(tmp_path) in str(error)
        else:
            used += 1
            assert all(0 <= cues.at(Fraction(time, 10)).share <= 1 for time in range(-10, 80))
    assert 20 < used < 900
