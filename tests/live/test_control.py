"""Control of a session by keys and requests, and adaptation of the working size."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from dataclasses import replace

import pytest
from waiting import LONG, eventually

from vidstyle.cues.cue_list import CueList
from vidstyle.errors import UsageError, VidstyleError
from vidstyle.live.control import Controls, StyleShow
from vidstyle.live.keys import keys, press
from vidstyle.live.latest import DropOldestQueue
from vidstyle.live.process import WORKING_SCALES, AdaptiveScale
from vidstyle.style import FIRST_STYLES, describe, load_style, override, style_names
from vidstyle.style.behind import style_behind


def test_styles_go_round():
    controls = Controls(load_style("plain"), ["ink", "plain", "poster"])
    seen = []
    for _ in range(4):
        seen.append(controls.style.name)
        controls.next_style()
    assert seen == ["plain", "poster", "ink", "plain"]


def test_the_popular_styles_follow_the_first():
    names = Controls(load_style("noir")).names
    assert names[:4] == ["noir", *FIRST_STYLES[:3]] and sorted(names) == style_names()


def test_what_was_set_by_hand_stays_with_the_first_style():
    first = override(load_style("ink"), ["steady=0.9"])
    controls = Controls(first, ["ink", "poster"])
    controls.choose("poster")
    controls.choose("ink")
    assert controls.style is first


def test_a_background_stays_with_all_styles():
    """A call must not show the room when another style is chosen."""
    first = replace(load_style("plain"), behind=style_behind("blur"), keep="faces")
    controls = Controls(first, ["plain", "poster", "ink"])
    for name in ("poster", "poster:pink", "ink", "plain"):
        controls.choose(name)
        assert (controls.style.behind, controls.style.keep) == (first.behind, "faces"), name
        controls.set_values({"steady": 0.3})
        assert controls.style.behind == first.behind
    assert replace(controls.named("ink"), behind=None, keep="") == load_style("ink")


def test_variants_are_chosen_by_name():
    controls = Controls(override(load_style("ink"), ["steady=0.9"]), ["ink", "poster", "noir"])
    controls.choose("poster:pink")
    assert controls.style == load_style("poster:pink") and controls.status().style == "poster:pink"
    controls.next_style()
    assert controls.style.name == "noir"
    controls.choose("ink:green")
    assert (controls.style.ink, controls.style.steady) == (load_style("ink:green").ink, 0.9)
    for wrong, reason in (("ink:purple", "no variant"), ("oil:x", "not a style"), (":", "not a style")):
        with pytest.raises(VidstyleError, match=reason):
            controls.choose(wrong)
    assert controls.style.name == "ink:green"


def test_a_session_may_begin_with_a_variant():
    first = override(load_style("ink:green"), ["steady=0.9"])
    controls = Controls(first, ["ink", "poster"])
    controls.next_style()
    assert controls.style == load_style("ink")
    controls.choose("ink:green")
    assert controls.style is first
    assert controls.without_variant("ink:green") == load_style("ink")


def test_chosen_styles_follow_one_another():
    first, *others = (load_style(name) for name in ("ink", "poster:pink", "noir"))
    controls = Controls(first, ["ink", "noir", "comic"], StyleShow(others))
    seen = []
    for _ in range(4):
        seen.append(controls.style.name)
        controls.next_style()
    assert seen == ["ink", "poster:pink", "noir", "ink"] and controls.names[0] == "poster:pink"
    controls.choose("comic")
    controls.next_style()
    assert controls.style is first, "a style that is not in the list is followed by the first"


def test_styles_change_by_themselves_after_a_time():
    controls = Controls(load_style("plain"), ["plain"], StyleShow([load_style("ink")], seconds=30))
    seen = []
    for time in (5, 34.9, 35, 64, 65, 94):
        controls.follow(time)
        seen.append(controls.style.name)
    assert seen == ["plain", "plain", "ink", "ink", "plain", "plain"]
    controls.choose("plain")
    controls.follow(95)
    controls.bypass()
    controls.follow(200)
    assert controls.style.name == "plain"
    controls.bypass()
    controls.follow(201)
    assert controls.style.name == "ink", "it was due while it was bypassed"


def test_a_cue_list_lasts_until_another_request():
    cues = CueList.of(load_style("noir"))
    controls = Controls(load_style("plain"), ["plain", "ink"], StyleShow(cues=cues, seconds=1))
    press(controls, "c")
    first = controls.look
    assert first == cues and controls.style.name == "plain"
    press(controls, "c")
    assert controls.look == cues and controls.look is not first, "it starts again"
    for time in (1, 5):
        controls.follow(time)
    assert controls.look == cues
    for request in (lambda: controls.choose("ink"), lambda: controls.steady(0.3)):
        controls.start_cues()
        request()
        assert controls.look is controls.style
    without = Controls(load_style("plain"))
    without.start_cues()
    assert without.look is without.style


def test_only_known_styles_can_be_chosen():
    controls = Controls(load_style("plain"), ["ink"])
    assert controls.names == ["plain", "ink"]
    with pytest.raises(UsageError, match="../../secret.toml is not a style to choose"):
        controls.choose("../../secret.toml")
    assert controls.style.name == "plain"


def test_values_that_cannot_be_change_nothing():
    before = load_style({"format": 1, "background": [{"block": "posterize"}]})
    controls = Controls(before)
    with pytest.raises(UsageError, match="outside"):
        controls.set_values({"steady": 0.5, "posterize.levels": 99})
    assert controls.style == before
    assert describe(controls.style)["background"][0]["parameters"]["levels"]["value"] == 10
    controls.set_values({"posterize.levels": 5})
    assert describe(controls.style)["background"][0]["parameters"]["levels"]["value"] == 5


def test_steadiness_stays_in_its_range():
    controls = Controls(load_style("plain"))
    for value, expected in ((0.7, 0.7), (5, 1.0), (-1, 0.0)):
        controls.steady(value)
        assert controls.style.steady == expected


def test_a_snapshot_is_taken_once():
    controls = Controls(load_style("plain"))
    controls.snapshot()
    assert [controls.pop_snapshot(), controls.pop_snapshot()] == [True, False]


def test_keys():
    controls = Controls(load_style("plain"), ["plain", "poster"])
    for key in "nbsr+x":
        press(controls, key)
    assert (controls.style.name, controls.bypassed, controls.recording) == ("poster", True, True)
    assert controls.pop_snapshot()
    steady = controls.style.steady
    press(controls, "-")
    assert controls.style.steady == pytest.approx(max(0, steady - 0.1))
    press(controls, "q")
    assert controls.quitting.is_set()


def test_keys_in_a_terminal_that_gets_its_old_ways_back():
    import termios

    ours, theirs = pty.openpty()
    before = termios.tcgetattr(theirs)
    controls = Controls(load_style("plain"), ["plain", "poster"])
    with keys(controls, theirs) as has_keys:
        assert has_keys
        assert not termios.tcgetattr(theirs)[3] & termios.ICANON, "keys come without the enter key"
        os.write(ours, b"n")
        eventually(lambda: controls.style.name == "poster")
    assert termios.tcgetattr(theirs) == before
    os.close(ours)
    os.close(theirs)


def test_no_terminal_no_keys():
    reading, writing = os.pipe()
    with keys(Controls(load_style("plain")), reading) as has_keys:
        assert not has_keys
    os.close(reading)
    os.close(writing)


def test_the_program_listens_to_keys():
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "vidstyle", "live", "test", "--size", "160x90", "--device", "cpu"]
    program = subprocess.Popen(
        [*command, "--style", "plain", "--to", "null"],
        stdin=theirs,
        stderr=subprocess.PIPE,
        start_new_session=True,
    )
    assert program.stderr is not None
    assert b"q quit" in program.stderr.readline()
    os.write(ours, b"q")
    assert program.wait(LONG) == 0
    program.stderr.close()
    os.close(ours)
    os.close(theirs)


def run_budget(budget: AdaptiveScale, full: float, frames: int) -> list[float]:
    """The scales at which a style runs that takes `full` seconds at the full size."""
    scales = []
    for _ in range(frames):
        scales.append(budget.scale)
        budget.update(full * budget.scale**2)
    return scales


def test_the_budget_goes_down_until_the_rate_holds():
    scales = run_budget(AdaptiveScale(1 / 30, 720), 0.1, 300)
    assert scales[0] == 1 and scales[-1] == 0.5
    assert scales == sorted(scales, reverse=True), "it does not try what cannot be"


def test_the_rate_falls_before_the_size_is_less_than_half():
    budget = AdaptiveScale(1 / 30, 720)
    assert min(run_budget(budget, 0.2, 300)) == 0.5
    assert budget.slow_rate == pytest.approx(20)
    assert run_budget(budget, 0.6, 300)[-1] < 0.5
    assert 0.5 in run_budget(budget, 0.1, 300) and budget.slow_rate == 0


def test_the_budget_goes_no_lower_than_its_least():
    for lines, least in ((720, WORKING_SCALES[-1]), (480, 0.375), (100, 0.5)):
        assert run_budget(AdaptiveScale(1 / 30, lines), 10.0, 50)[-1] == least


def test_the_budget_goes_up_again_and_stays_up():
    budget = AdaptiveScale(1 / 30, 720)
    run_budget(budget, 0.1, 200)
    scales = run_budget(budget, 0.01, 300)
    assert scales[0] == 0.5 and scales[-1] == 1 and 0.75 in scales


def test_the_budget_leaves_alone_what_is_fast_enough():
    """24 frames per second look smooth, for sources of any rate."""
    for rate, seconds in ((30, 0.041), (60, 0.041), (10, 0.099)):
        assert set(run_budget(AdaptiveScale(1 / rate, 720), seconds, 500)) == {1.0}


def test_the_budget_keeps_the_size_where_smaller_pictures_are_no_faster():
    budget, scales = AdaptiveScale(1 / 30, 720), []
    for _ in range(600):
        scales.append(budget.scale)
        budget.update(0.05)
    assert scales.count(1.0) > 0.8 * len(scales) and min(scales) < 1


def test_the_budget_forgives_a_second_of_slow_frames():
    scales = run_budget(AdaptiveScale(1 / 30, 720), 0.1, 30)
    assert set(scales[:20]) == {1.0} and scales[-1] < 1


def test_a_rise_that_fails_is_tried_later_and_later():
    budget = AdaptiveScale(1 / 30, 720)
    changes = []
    for number in range(3000):
        # Small pictures cost less than their size promises, so that the larger ones always disappoint.
        if budget.update({1.0: 0.05, 0.75: 0.01}.get(budget.scale, 0.005)):
            changes.append((number, budget.scale))
    rises = [number for number, scale in changes if scale == 1]
    waits = [after - before for before, after in zip(rises, rises[1:], strict=False)]
    assert len(waits) >= 3 and all(
        after > 1.5 * before for before, after in zip(waits, waits[1:], strict=False)
    )


def test_only_the_newest_wait():
    queue = DropOldestQueue[int](capacity=2)
    for number in range(5):
        queue.put(number)
    assert [queue.get(), queue.get(), queue.get(0.01)] == [3, 4, None] and queue.dropped == 3
    queue.put(9)
    queue.close()
    queue.put(10)
    assert not queue.exhausted and queue.get() == 9 and queue.exhausted and queue.get() is None
