"""Which style a cue list shows at which time."""

from __future__ import annotations

from fractions import Fraction

import pytest

from vidstyle.cues.cue_list import Cue, CueList, Moment
from vidstyle.cues.moving import style_between
from vidstyle.errors import UsageError
from vidstyle.style import Style, load_style, set_values

INK, POSTER = load_style("ink"), load_style("poster")


def cue(time: float, style: Style, **fields: object) -> Cue:
    return Cue(Fraction(time), style, **fields)  # type: ignore[arg-type]


def shown(cues: CueList, time: float) -> Style:
    return cues.at(time).active.style


def test_a_style_lasts_until_the_next_cue() -> None:
    cues = CueList((cue(1, INK), cue(3, POSTER)))
    assert shown(cues, 0.9).is_plain and shown(cues, 1) is INK
    assert shown(cues, 2.999) is INK and shown(cues, 3) is POSTER and shown(cues, 1e6) is POSTER
    assert shown(cues, 2.9996) is POSTER, "times in files are rounded"


def test_a_transition_shows_both_styles() -> None:
    cues = CueList((cue(0, INK), cue(2, POSTER, transition="fade", seconds=Fraction(1))))
    moment = cues.at(2.25)
    assert moment.ending is not None and moment.ending.style is INK and moment.active.style is POSTER
    assert moment.transition == "fade" and moment.share == pytest.approx(0.25, abs=0.001)
    assert cues.at(1.9) == Moment(cues.at(0).active) and cues.at(3).ending is None


def test_the_first_style_fades_in_from_the_film() -> None:
    moment = CueList((cue(0, INK, transition="fade", seconds=Fraction(1)),)).at(0.5)
    assert moment.ending is not None and moment.ending.style.is_plain


@pytest.mark.parametrize(("curve", "middle"), [("hold", 0), ("linear", 0.25), ("ease", 0.15625)])
def test_values_move_to_those_of_the_next_cue(curve: str, middle: float) -> None:
    first, last = (set_values(INK, {"strength": value}) for value in (0, 1))
    cues = CueList((cue(0, first, curve=curve), cue(4, last)))
    assert shown(cues, 1).strength == pytest.approx(middle, abs=0.001)
    assert shown(cues, 4).strength == 1
    assert cues.runs == [1, 1], "the memory of earlier frames is kept"


def test_another_style_or_a_transition_begins_a_run() -> None:
    fade = {"transition": "fade", "seconds": Fraction(1)}
    cues = CueList((cue(0, INK), cue(2, INK, **fade), cue(4, POSTER), cue(6, POSTER)))
    assert cues.runs == [1, 2, 3, 3]


def test_numbers_and_colors_move_and_choices_jump() -> None:
    table = {"format": 1, "name": "t", "ink": "#000000", "lines": [{"block": "sobel"}]}
    step = {"block": "posterize", "levels": 2}
    one = load_style({**table, "background": [{"block": "scale", "method": "area", "factor": 0.5}, step]})
    other = load_style(
        {**table, "ink": "#ff8040",
         "background": [{"block": "scale", "method": "bicubic", "factor": 1.0}, {**step, "levels": 5}]}
    )  # fmt: skip
    middle = style_between(one, other, 0.5)
    assert middle.ink == "#804020"
    assert middle.steps[0].values == {"method": "area", "factor": 0.75}
    assert middle.steps[1].values == {"levels": 4}
    assert style_between(one, other, 0).steps == one.steps
    assert style_between(one, other, 1).steps == other.steps


@pytest.mark.parametrize(
    ("cues", "reason"),
    [
        ((), "there are none"),
        ((cue(2, INK), cue(2, POSTER)), "cue 2 begins at 2 s, not after cue 1"),
        (
            (cue(0, INK, transition="wipe", seconds=Fraction(3)), cue(2, POSTER)),
            "the wipe of cue 1 takes 3 s, but the next begins after 2 s",
        ),
    ],
)
def test_impossible_lists_are_refused(cues: tuple[Cue, ...], reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        CueList(cues)


def test_a_list_is_moved_with_the_start_of_a_film() -> None:
    cues = CueList((cue(0, INK), cue(10, POSTER))).moved(Fraction(-8))
    assert shown(cues, 0) is INK and shown(cues, 2) is POSTER
