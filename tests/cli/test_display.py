"""Progress on standard error."""

from __future__ import annotations

import pytest

from vidstyle.cli.parsing.child_pages import report_progress
from vidstyle.cli.terminal import display
from vidstyle.cli.terminal.reporting import Reporting
from vidstyle.pipeline.progress import Progress


def test_plain_progress_begins_with_the_first_frame(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Before the total is known, the step of a job is shown."""
    monkeypatch.setattr(display, "LINE_SECONDS", 0)
    with Reporting(), display.display("plain") as show:
        show(Progress(0, 0.0, 3.0, duration=8.0))
        show(Progress(2, 0.1, 4.0, duration=8.0))
        show(Progress(0, 1.0, 5.0, duration=4.0, step="read"))
    lines = capsys.readouterr().err.splitlines()
    assert lines == ["vidstyle: 1%, frame 2, 0.5 fps, 0.03 x, 5:16 left", "vidstyle: 25%, read, 0:15 left"]


def test_plain_progress_of_a_child_is_reported_in_words(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(display, "LINE_SECONDS", 0)
    with Reporting(), display.display("plain") as show:
        show(Progress(0, 1.0, 5.0, duration=4.0, step="analyzing the film"))
        show(Progress(0, 0.0, 5.0, step="laying out"))
    lines = capsys.readouterr().err.splitlines(keepends=True)
    reports: list[str] = []
    assert [*report_progress(lines, reports.append)] == lines
    assert reports == ["Analyzing the film: 25 %, 0:15 left"]
