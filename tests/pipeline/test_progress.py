"""Progress of a job."""

from __future__ import annotations

import json

import pytest

from vidstyle.pipeline.progress import Progress, StepProgress


def test_rates_and_the_rest_follow_from_what_is_known():
    progress = Progress(frames=50, position=2.0, elapsed=4.0, total_frames=200, duration=8.0)
    assert (progress.rate, progress.speed, progress.fraction, progress.remaining) == (12.5, 0.5, 0.25, 12.0)


def test_frames_serve_where_the_duration_is_unknown():
    assert Progress(frames=50, position=2.0, elapsed=4.0, total_frames=200).fraction == 0.25


@pytest.mark.parametrize("elapsed", [0.0, 1.0])
def test_nothing_known_is_no_error(elapsed):
    told = Progress(frames=0, position=0.0, elapsed=elapsed).as_dict()
    assert told["fraction"] is None and told["eta"] is None
    assert json.loads(json.dumps(told)) == told


def test_headers_that_promise_too_little_do_not_go_past_the_end():
    assert Progress(frames=50, position=9.0, elapsed=4.0, duration=8.0).fraction == 1.0


def test_steps_are_told_by_name_and_their_time_counts_from_the_first_part(monkeypatch: pytest.MonkeyPatch):
    clock = iter([100.0, 101.0, 111.0, 112.0, 113.0, 120.0])
    monkeypatch.setattr("vidstyle.pipeline.progress.time.monotonic", lambda: next(clock))
    shown: list[Progress] = []
    on_step = StepProgress(shown.append)
    for step, done, total in [("read", 0, 5), ("read", 1, 5), ("read", 2, 5), ("read", 3, 5), ("draw", 0, 0)]:
        on_step(step, done, total)
    assert [each.remaining for each in shown] == [None, None, 3.0, 2.0, None]
    assert [each.pace_text for each in shown[2:]] == ["read, 0:03 left", "read, 0:02 left", "draw"]
    assert shown[3].as_dict() == {"step": "read", "elapsed": 13.0, "fraction": 0.6, "eta": 2.0}
