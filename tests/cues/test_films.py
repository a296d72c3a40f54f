"""Films in several styles: the commands, scenes, and interrupted runs."""

from __future__ import annotations

import threading
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from media import make_clip, read_all
from stories import RATE, story

from vidstyle import cli
from vidstyle.core.convert import convert
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cues.cue_list import Cue, CueList
from vidstyle.cues.style_change import StyleChange, in_turn
from vidstyle.errors import UsageError
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.write.memory import write_film
from vidstyle.pipeline.progress import Progress
from vidstyle.pipeline.render import render
from vidstyle.pipeline.scenes import find_scenes
from vidstyle.style import Style, load_style

SHOT, SHOTS = 20, 4
DARK, BRIGHT = (
    load_style({"format": 1, "name": name, "background": [{"block": "brightness", "factor": factor}]})
    for name, factor in (("dark", 0.3), ("bright", 1.8))
)
STEADY = load_style("poster")


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    pictures = (convert(Picture.from_array(rgb), Encoding()) for rgb in story(SHOTS, SHOT))
    write_film(path, pictures, Fraction(RATE), np.zeros(48000 * SHOTS * SHOT // RATE, np.float32))
    return path


def lumas(path: Path) -> list[np.ndarray]:
    return [frame.to_ndarray()[: frame.height] for frame in read_all(path)]


def test_scenes_are_found_with_a_picture_of_each(film: Path) -> None:
    scenes, rate = find_scenes(film)
    assert rate == RATE
    assert [each.start for each in scenes] == [Fraction(SHOT * number, RATE) for number in range(SHOTS)]
    assert scenes[-1].end == Fraction(SHOT * SHOTS, RATE)
    stills = [each.still for each in scenes]
    assert len({still.tobytes() for still in stills}) == SHOTS and stills[0].dtype == np.uint8
    with pytest.raises(UsageError, match="cannot be read twice"):
        find_scenes("-")


@pytest.mark.parametrize("threads", ["1", "3"])
def test_styles_change_at_cuts(film: Path, tmp_path: Path, threads: str) -> None:
    words = ["-s", "noir,plain", "--by", "shot:2", "--codec", "ffv1", "--threads", threads, "--progress=none"]
    assert cli.main(["render", str(film), str(tmp_path / "out.mkv"), *words]) == 0
    made, source = lumas(tmp_path / "out.mkv"), lumas(film)
    changed = [not np.array_equal(one, other) for one, other in zip(made, source, strict=True)]
    assert changed == [True] * 2 * SHOT + [False] * 2 * SHOT


def test_a_part_of_a_film_has_the_cues_of_the_whole(film: Path, tmp_path: Path) -> None:
    cues = CueList((Cue(Fraction(0), DARK), Cue(Fraction(SHOT, RATE), BRIGHT)))
    lossless = WriteOptions(codec="ffv1")
    render(film, tmp_path / "whole.mkv", cues, write=lossless)
    start = Fraction(SHOT - 5, RATE)
    render(film, tmp_path / "part.mkv", cues, write=lossless, read=ReadOptions(start=start))
    whole, part = lumas(tmp_path / "whole.mkv"), lumas(tmp_path / "part.mkv")
    assert all(np.array_equal(one, other) for one, other in zip(whole[SHOT - 5 :], part, strict=True))


def test_an_interrupted_film_continues_with_its_cues(film: Path, tmp_path: Path) -> None:
    fade = Cue(Fraction(30, RATE), STEADY, "fade", Fraction(40, RATE))
    cues, lossless = CueList((Cue(Fraction(0), DARK), fade)), WriteOptions(codec="ffv1")
    render(film, tmp_path / "whole.mkv", cues, write=lossless)
    stop = threading.Event()

    def watch(progress: Progress) -> None:
        if progress.frames > 35:
            stop.set()

    target = tmp_path / "out.mkv"
    summary = render(film, target, cues, write=lossless, on_progress=watch, stop=stop)
    resumed = render(film, target, cues, write=lossless, resume=True) if summary.stopped else summary
    assert resumed.frames == SHOT * SHOTS
    made, right = lumas(target), lumas(tmp_path / "whole.mkv")
    assert all(np.array_equal(one, other) for one, other in zip(made, right, strict=True))
    other = CueList((Cue(Fraction(0), BRIGHT), fade))
    if summary.stopped:
        assert render(film, target, other, write=lossless, resume=True).frames == 0, "it is finished"


def test_the_command_writes_a_file_that_render_follows(
    film: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    file, out = str(tmp_path / "cues.toml"), str(tmp_path / "out.mkv")
    assert cli.main(["cues", str(film), file, "-s", "plain,noir"]) == 0
    assert f"{SHOTS} scenes; choose styles in {tmp_path / 'cues.html'}" in capfd.readouterr().err
    assert cli.main(["cues", str(film), file]) == 2 and "exists" in capfd.readouterr().err
    written = Path(file).read_text()
    assert (
        cli.main(["cues", str(film), file, "--cues", file, "-y"]) == 0 and Path(file).read_text() == written
    )
    assert cli.main(["cues", str(film), file, "--cues", file, "-y", "-s", "ink"]) == 2
    assert "--style cannot be used with --cues" in capfd.readouterr().err
    assert cli.main(["render", str(film), out, "--cues", file, "--codec", "ffv1", "--progress=none"]) == 0
    made, source = lumas(Path(out)), lumas(film)
    same = [np.array_equal(one, other) for one, other in zip(made, source, strict=True)]
    assert same == ([True] * SHOT + [False] * SHOT) * 2


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-s", "ink,noir"], "--style has several styles; say when to change"),
        (["-s", "ink", "--seed", "3"], "--seed needs --by"),
        (["-s", "ink,", "--by", "scene"], "--style has a comma without a name"),
        (["-s", "ink", "--by", "never"], "'never' is not 'scene', 'shot:3', '30s' or 'like'"),
        (["-s", "ink", "--by", "0s"], "'0s' is not 'scene'"),
        (["-s", "ink,noir", "--by", "0.0001s"], "would make 32000 parts"),
        (["--cues", "none.toml"], "none.toml cannot be read"),
        (["--cues", "none.toml", "-s", "ink"], "--style cannot be used with --cues"),
        (["--cues", "none.toml", "--steady", "1"], "--steady cannot be used with --cues"),
    ],
)
def test_wrong_options_are_refused_in_one_line(
    film: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    assert cli.main(["render", str(film), str(tmp_path / "out.mkv"), *words]) in (2, 3)
    assert message in capfd.readouterr().err and not (tmp_path / "out.mkv").exists()


def test_a_seed_chooses_styles_at_random_but_never_twice_in_a_row() -> None:
    styles = [Style(name) for name in "abcd"]
    chosen = in_turn(styles, 200, 7)
    assert all(one is not other for one, other in zip(chosen, chosen[1:], strict=False))
    assert chosen == in_turn(styles, 200, 7) != in_turn(styles, 200, 8) and len(set(map(id, chosen))) == 4
    assert [style.name for style in in_turn(styles, 6, None)] == list("abcdab")
    assert in_turn(styles[:1], 3, 1) == styles[:1] * 3


def test_a_style_is_chosen_that_suits_each_scene(tmp_path: Path) -> None:
    make_clip(tmp_path / "clip.mp4", frames=40, scene_frames=20)
    words = ["-s", "noir,crayon,plain", "--by", "like"]
    assert cli.main(["cues", str(tmp_path / "clip.mp4"), str(tmp_path / "cues.toml"), *words]) == 0
    text = (tmp_path / "cues.toml").read_text()
    first, second = [line for line in text.splitlines() if line.startswith("style")]
    assert first == 'style = "plain"' != second, "the nearest look, and then another"


def test_parts_of_equal_time() -> None:
    assert StyleChange.parse("2.5s").starts(Fraction(6)) == [Fraction(0), Fraction(5, 2), Fraction(5)]
    assert StyleChange.parse("1:00s").step == 60
