"""`vidstyle styles --like PICTURE`: the styles that come nearest to the look of a picture."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from skimage import data

from vidstyle.cli import main
from vidstyle.explore.composed.shipped_parts import shipped_styles
from vidstyle.explore.gates import faults
from vidstyle.explore.matching import like
from vidstyle.explore.matching.appearance import appearance_distance, appearance_of
from vidstyle.explore.matching.kept_subject import LOST_SUBJECT_FAULTS, KeptSubject
from vidstyle.explore.matching.like import (
    MAX_NEAR_DISTANCE,
    MIN_FAR_DISTANCE,
    known_styles,
    rank_styles,
    search_styles,
)
from vidstyle.explore.matching.tune import tune_style
from vidstyle.explore.measure import Original
from vidstyle.gallery.style_samples import restyle_picture
from vidstyle.media.resize import reduce_picture
from vidstyle.style import Step, Style, load_style

SIDE = 300


def photograph(name: str) -> np.ndarray:
    return reduce_picture(getattr(data, name)(), SIDE)


def named_among_three(given: str, tried: str, wanted: list[str], known: list[str]) -> int:
    """How many of the wanted styles are among the three nearest to their picture of another photograph."""
    looks = {name: appearance_of(restyle_picture(photograph(tried), load_style(name))) for name in known}
    hits = 0
    for name in wanted:
        target = appearance_of(restyle_picture(photograph(given), load_style(name)))
        hits += name in sorted(looks, key=lambda each: appearance_distance(looks[each], target))[:3]
    return hits


def test_finds_the_style_of_a_picture_of_something_else() -> None:
    known = ["sketch", "poster", "impressionist", "engraving", "noir"]
    assert named_among_three("coffee", "chelsea", ["poster"], known) == 1


@pytest.mark.thorough
def test_finds_eleven_of_thirteen_styles() -> None:
    known = [style.name for style in known_styles()]
    names = [style.name for style in shipped_styles()]
    assert named_among_three("chelsea", "coffee", names, known) >= 11


def test_the_look_does_not_depend_on_the_size() -> None:
    picture = restyle_picture(photograph("coffee"), load_style("poster"))
    double = cv2.resize(picture, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    other = restyle_picture(photograph("coffee"), load_style("engraving"))
    here, larger, different = map(appearance_of, (picture, double, other))
    assert (
        appearance_distance(here, larger)
        < MAX_NEAR_DISTANCE
        < MIN_FAR_DISTANCE
        < appearance_distance(here, different)
    )


def test_search_comes_nearer(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in {"SEARCH_ROUNDS": 2, "PARENT_COUNT": 1, "CHILD_COUNT": 3, "TUNED_COUNT": 0}.items():
        monkeypatch.setattr(like, name, value)
    wanted = restyle_picture(photograph("coffee"), load_style({"format": 1, "ink": "#303080", "lines": [
        {"block": "flow_xdog", "sigma": 3.0, "p": 12}]}))  # fmt: skip
    known = rank_styles(wanted, photograph("chelsea"), [load_style("ink:blue")])
    found = search_styles(wanted, photograph("chelsea"), known)[0]
    assert found.distance < known[0].distance


def test_a_search_does_not_lose_the_subject(monkeypatch: pytest.MonkeyPatch) -> None:
    """A reference without edges is nearest to a blur of the photograph, which nobody wants."""
    for name, value in {"SEARCH_ROUNDS": 1, "PARENT_COUNT": 1, "CHILD_COUNT": 1, "TUNED_COUNT": 1}.items():
        monkeypatch.setattr(like, name, value)
    blurred, given = cv2.GaussianBlur(photograph("coffee"), (0, 0), 12), photograph("chelsea")
    soft = {"block": "gaussian", "sigma": 1.0}
    known = rank_styles(blurred, given, [load_style({"format": 1, "background": [soft]})])
    found = search_styles(blurred, given, known)[0]
    assert found.distance <= known[0].distance
    original = Original(given)
    assert not LOST_SUBJECT_FAULTS.intersection(faults(original.measure(restyle_picture(given, found.style))))


def test_a_search_does_not_lose_faces_that_the_known_style_keeps() -> None:
    """A reference with white areas is nearest to a drawing whose faces are blank."""
    given = data.astronaut()
    blank = given.copy()
    blank[60:220, 170:280] = 230
    assert KeptSubject(given, given).is_lost(blank)
    assert not KeptSubject(given, given).is_lost(restyle_picture(given, load_style("sketch")))
    assert not KeptSubject(given, blank).is_lost(blank)


def test_a_variation_that_cannot_be_rendered_comes_last() -> None:
    """A working size of eight times the picture is refused."""
    large = style_with(levels=4, saturation=1.0)
    large = replace(large, background=(Step("scale", {"factor": 8.0}), *large.background))
    wanted, given = photograph("coffee"), photograph("chelsea")
    ranked = rank_styles(wanted, given, [large, load_style("poster")])
    assert [each.style.name for each in ranked] == ["poster", "test"]
    assert ranked[1].distance == float("inf")


def test_tuning_finds_values_one_by_one() -> None:
    style = style_with(levels=4, saturation=1.0)

    def distances(styles: Sequence[Style]) -> list[float]:
        values = [{step.block: step.values for step in each.steps} for each in styles]
        return [
            abs(each["luma_posterize"]["levels"] - 9) / 9 + abs(each["saturation"]["factor"] - 1.5)
            for each in values
        ]

    tuned, distance = tune_style(style, distances, rounds=6)
    assert distance == distances([tuned])[0] < 0.2 < distances([style])[0]
    assert [step.block for step in tuned.steps] == [step.block for step in style.steps]
    assert tune_style(style, distances, rounds=6)[0] == tuned


def test_tuning_leaves_a_style_that_nothing_improves() -> None:
    style = style_with(levels=4, saturation=1.0)
    assert tune_style(style, lambda styles: [1.0] * len(styles)) == (style, 1.0)


def style_with(levels: int, saturation: float) -> Style:
    steps = Step("luma_posterize", {"levels": levels}), Step("saturation", {"factor": saturation})
    return Style("test", height=720, background=steps)


def test_command_names_the_nearest(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(like, "known_styles", lambda: [load_style(name) for name in ("noir", "poster")])
    picture = restyle_picture(photograph("coffee"), load_style("poster"))
    cv2.imwrite(str(tmp_path / "poster.png"), picture[..., ::-1])
    assert main(["styles", "--like", str(tmp_path / "poster.png"), "--json", "--progress", "none"]) == 0
    rows = json.loads(capfd.readouterr().out)
    assert [row["name"] for row in rows] == ["poster", "noir"]
    for name, value in {"SEARCH_ROUNDS": 1, "PARENT_COUNT": 1, "CHILD_COUNT": 1, "TUNED_COUNT": 0}.items():
        monkeypatch.setattr(like, name, value)
    near = ["styles", "--like", str(tmp_path / "poster.png"), "-o", str(tmp_path / "style.toml")]
    assert main([*near, "--progress", "none"]) == 0
    written = capfd.readouterr().out
    assert "style.toml" in written and "before tuning" in written
    assert load_style(tmp_path / "style.toml").layers
    wrong = ["styles", "--like", str(tmp_path / "poster.png"), "-o", str(tmp_path / "style.png")]
    assert main(wrong) == 2
    assert "is not a style file" in capfd.readouterr().err


def test_command_says_whether_a_look_is_reached(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(like, "known_styles", lambda: [load_style("poster")])
    for name, value in {"SEARCH_ROUNDS": 1, "PARENT_COUNT": 1, "CHILD_COUNT": 1, "TUNED_COUNT": 0}.items():
        monkeypatch.setattr(like, name, value)
    wanted = {
        "poster": restyle_picture(like.photograph_for(None), load_style("poster")),
        "stripes": np.tile(np.uint8([[0] * 3 + [255] * 3]), (300, 50)),
    }
    for name, picture in wanted.items():
        cv2.imwrite(str(tmp_path / f"{name}.png"), picture[..., ::-1] if picture.ndim == 3 else picture)
        near = ["styles", "--like", str(tmp_path / f"{name}.png"), "-o", str(tmp_path / f"{name}.toml")]
        assert main([*near, "--progress", "none"]) == 0
        said = "; no style found reaches this look" in capfd.readouterr().out
        assert said == (name == "stripes")
