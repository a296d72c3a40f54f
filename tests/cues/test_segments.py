"""Films in several styles, rendered in segments: the same pictures as in one piece."""

from __future__ import annotations

import json
import shutil
import threading
from fractions import Fraction
from pathlib import Path

import media
import numpy as np
import pytest
from covering import drawn
from media import read_all
from pictures import step, style
from stories import RATE, story

from vidstyle import cli
from vidstyle.core.convert import convert
from vidstyle.core.machine.cores import use_threads
from vidstyle.core.picture import Encoding, Picture
from vidstyle.cues.cue_list import Cue, CueList
from vidstyle.cues.rotation import StyleChoice, StyleRotation, Turn
from vidstyle.cues.style_change import StyleChange
from vidstyle.media.options import ReadOptions, WriteOptions
from vidstyle.media.write.memory import write_film
from vidstyle.pipeline import segment_borders
from vidstyle.pipeline.render import render
from vidstyle.pipeline.segment_plan import SegmentPlan
from vidstyle.pipeline.segments import SegmentedFilm
from vidstyle.style import set_values

SHOT, SHOTS = 20, 4
LOSSLESS = WriteOptions(codec="ffv1")
STEADY = style(step("posterize", levels=4), steady=0.6, focus=0)
MEASURED = style(step("minimum_range", settle=0.4), focus=0)
PLAIN = style(step("brightness", factor=0.5), focus=0)


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four shots with sound."""
    path = tmp_path_factory.mktemp("film") / "film.mp4"
    pictures = (convert(Picture.from_array(rgb), Encoding()) for rgb in story(SHOTS, SHOT))
    write_film(path, pictures, Fraction(RATE), np.zeros(48000 * SHOTS * SHOT // RATE, np.float32))
    return path


def cue(frame: int, chosen: object, **fields: object) -> Cue:
    return Cue(Fraction(frame, RATE), chosen, **fields)  # type: ignore[arg-type]


def moving(frame: int, last: int) -> tuple[Cue, Cue]:
    """A style whose levels and strength move between two frames."""
    end = set_values(STEADY, {"posterize.levels": 12, "strength": 0.4})
    return cue(frame, STEADY, curve="ease"), cue(last, end)


def segmented(
    source: Path, folder: Path, look: StyleChoice, read: ReadOptions, turns: list[Turn]
) -> SegmentedFilm:
    """Render a film in segments, last one first, so that no segment has the state of the previous one."""
    film = SegmentedFilm(source, folder / "joined.mkv", folder, look, read, LOSSLESS, "cpu", None, {})
    stop = threading.Event()
    plan = film.plan(Fraction(1, 5), lambda progress: None, stop, turns)
    for each in reversed(plan.segments):
        film.render(each.name, lambda progress: None, stop)
    film.join(False, stop)
    return film


def ranges(folder: Path) -> list[str]:
    return [each.name for each in SegmentPlan.read(folder / "plan.json").segments]


def same_pictures(one: Path, other: Path) -> bool:
    first, second = (
        [(frame.pts, frame.to_ndarray().tobytes()) for frame in read_all(each)] for each in (one, other)
    )
    return first == second


FADE = {"transition": "fade", "seconds": Fraction(9, RATE)}
ACROSS_CUT = CueList(
    (*moving(0, 10), cue(15, MEASURED, **FADE), cue(50, PLAIN, transition="wipe", seconds=Fraction(1, 5)))
)
WITHOUT_CUT = CueList((cue(2, STEADY), cue(10, MEASURED), *moving(28, 36)))


@pytest.mark.parametrize("cues", [ACROSS_CUT, WITHOUT_CUT], ids=["fades", "cuts"])
@pytest.mark.parametrize("start", [None, Fraction(12, RATE)], ids=["whole", "part"])
def test_segments_have_the_pictures_of_one_piece(
    film: Path, tmp_path: Path, cues: CueList, start: Fraction | None
) -> None:
    read, threads = ReadOptions(start=start), drawn((1, 4), f"{cues} {start}")
    with use_threads(threads):
        segmented(film, tmp_path, cues, read, [])
    render(film, tmp_path / "whole.mkv", cues, read=read, write=LOSSLESS, device="cpu")
    assert same_pictures(tmp_path / "joined.mkv", tmp_path / "whole.mkv")
    assert len(ranges(tmp_path)) > 2


def test_a_style_begins_a_segment_where_no_scene_does(film: Path, tmp_path: Path) -> None:
    segmented(film, tmp_path, WITHOUT_CUT, ReadOptions(), [])
    assert {"10:20", "20:28"} <= {*ranges(tmp_path)}, "cuts to another style, and one of the film"


def test_a_scene_is_divided_outside_of_transitions(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"MIN_PART_SECONDS": 0.4, "MIN_PART_RATIO": 0, "WARM_UP_FRAMES": 60}.items():
        monkeypatch.setattr(segment_borders, name, value)
    source = media.make_clip(tmp_path / "scene.mp4", size=(96, 54), frames=80)
    rate = 30
    fade = Cue(Fraction(10, rate), STEADY, "fade", Fraction(10, rate))
    values = set_values(STEADY, {"posterize.levels": 12})
    cues = CueList(
        (
            Cue(Fraction(0), MEASURED),
            fade,
            Cue(Fraction(30, rate), STEADY, curve="linear"),
            Cue(Fraction(60, rate), values),
        )
    )
    segmented(source, tmp_path, cues, ReadOptions(), [])
    render(source, tmp_path / "whole.mkv", cues, write=LOSSLESS, device="cpu")
    assert same_pictures(tmp_path / "joined.mkv", tmp_path / "whole.mkv")
    assert ranges(tmp_path)[0] == "0:21", "the first frame after the transition and the one that ends it"


def test_turns_are_kept_in_the_plan(film: Path, tmp_path: Path) -> None:
    rotation = StyleRotation((PLAIN, MEASURED), StyleChange.parse("scene"), None)
    turns = [(Fraction(SHOT * number, RATE), number % 2) for number in range(SHOTS)]
    segmented(film, tmp_path, rotation, ReadOptions(), turns)
    render(film, tmp_path / "whole.mkv", rotation.cue_list(turns), write=LOSSLESS, device="cpu")
    assert same_pictures(tmp_path / "joined.mkv", tmp_path / "whole.mkv")


@pytest.mark.parametrize("words", [("--style=plain,noir", "--by=scene"), ("--cues={name}.toml",)])
def test_the_commands_make_one_film(
    film: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    words: tuple[str, ...],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert cli.main(["cues", str(film), "film.toml", "-s", "plain,noir"]) == 0
    more = ["--threads=1", "--codec=ffv1", "--audio=none"]
    out = ["batch", str(film), *words, *more, "--json"]
    capfd.readouterr()
    assert cli.main([*out, "-o", "whole/{name}.mkv"]) == 0
    assert cli.main([*out, "-o", "joined/{name}-{style}.mkv", "--segment=0.5", "-j2"]) == 0
    made = [Path(json.loads(line)["films"][0]["target"]) for line in capfd.readouterr().out.splitlines()]
    assert [path.name for path in made] == [
        "film.mkv",
        "film-plain-noir.mkv" if len(words) > 1 else "film-film.mkv",
    ]
    assert same_pictures(*made)
    luma = [frame.to_ndarray() for frame in read_all(made[0])]
    source = [frame.to_ndarray() for frame in read_all(film)]
    changed = [not np.array_equal(one, other) for one, other in zip(luma, source, strict=True)]
    assert changed == ([False] * SHOT + [True] * SHOT) * 2


def test_a_film_without_its_cue_file_fails_alone(
    film: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copy(film, "other.mp4")
    (tmp_path / "other.toml").write_text('format = 1\n[[cue]]\ntime = 0\nstyle = "plain"\n')
    words = ["--cues", "{name}.toml", "-o", "out/{name}.mp4", "--threads=1", "--progress=plain", "--json"]
    assert cli.main(["batch", str(film), "other.mp4", *words]) == 3
    out, err = capfd.readouterr()
    assert [each["state"] for each in json.loads(out)["films"]] == ["failed", "done"]
    assert err.count("film.toml: cannot be read") + err.count("film.toml cannot be read") == 1
    assert cli.main(["batch", "other.mp4", *words[:-1], "--emit", "shell", "-y"]) == 2
    assert cli.main(["batch", "other.mp4", *words, "-s", "ink"]) == 2
    assert "--style cannot be used with --cues" in capfd.readouterr().err
