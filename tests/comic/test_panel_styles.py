"""Which style each panel of a comic has."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import cv2
import pytest
from stories import story, write_film

from vidstyle import cli
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.panel_styles import PanelStyles
from vidstyle.cues.cue_list import Cue, CueList
from vidstyle.cues.style_change import StyleChange
from vidstyle.regions.boxes import Box
from vidstyle.style import Style

A, B, C = (Style(name) for name in "abc")
PANELS = [(0, 0.5), (0, 2.0), (1, 3.0), (4, 7.0), (4, 9.0), (5, 12.0)]
"""Scene and time of each panel."""


def key_frames() -> list[KeyFrame]:
    return [KeyFrame(time, (9, 16), 1, Box(0, 0, 16, 9), (), scene) for scene, time in PANELS]


@pytest.mark.parametrize(
    ("change", "names"),
    [(None, "abcabc"), ("scene", "aabcca"), ("shot:2", "aaabbb"), ("5s", "aaabbc")],
)
def test_styles_follow_one_another(change: str | None, names: str) -> None:
    styles = PanelStyles([A, B, C], change and StyleChange.parse(change))
    assert "".join(style.name for style in styles.of(key_frames())) == names


def test_a_cue_list_decides_by_time() -> None:
    cues = CueList((Cue(Fraction(1), A), Cue(Fraction(6), B, "fade", Fraction(3)), Cue(Fraction(10), C)))
    names = [style.name for style in PanelStyles([], cues=cues).of(key_frames())]
    assert names == ["plain", "a", "a", "a", "b", "c"], "the style that is seen more"


def test_the_command_takes_styles_over_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_film(Path("film.mp4"), story(3, 20))
    comic = ["comic", "film.mp4", "--panels", "3", "--size", "300x400", "--subtitles", "none"]
    Path("cues.toml").write_text('format = 1\n[[cue]]\ntime = 0.9\nstyle = "dither"\n')
    assert cli.main([*comic, "cues.png", "--cues", "cues.toml"]) == 0
    assert cli.main([*comic, "by.png", "-s", "plain,dither", "--by", "shot:2", "--save", "by.toml"]) == 0
    assert 'styles = ["plain", "plain", "dither"]' in Path("by.toml").read_text()
    assert cli.main(["comic", "by.toml", "again.png"]) == 0
    cues, by, again = (cv2.imread(name) for name in ("cues.png", "by.png", "again.png"))
    assert (by == again).all() and not (cues == by).all()
    capfd.readouterr()
    for words, message in (
        (["--cues", "cues.toml", "-s", "ink"], "--style cannot be used with --cues"),
        (["--cues", "cues.toml", "--save", "a.toml"], "--save needs styles given by name"),
        (["--by", "scene"], "--by needs several styles"),
        (["-s", "ink,noir", "--by", "like"], "'like' is for films"),
    ):
        assert cli.main([*comic, "wrong.png", *words]) == 2
        assert message in capfd.readouterr().err
