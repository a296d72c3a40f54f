"""Which films a batch takes, what its results are called, and what it knows of earlier runs."""

from __future__ import annotations

import io
import json
import os
import threading
from dataclasses import replace
from pathlib import Path

import pytest

from vidstyle.batch.batch import BatchOptions, FilmBatch
from vidstyle.batch.batch_film import BatchFilm, State
from vidstyle.batch.inputs import Source, find_sources
from vidstyle.batch.journal import JOURNAL, Journal, content_digest
from vidstyle.batch.naming import result_path
from vidstyle.batch.planner import FilmLook, Planner
from vidstyle.batch.processes import Processes
from vidstyle.batch.report import counts_text, csv_text, exit_code, seconds_left
from vidstyle.batch.resources import JOB_BYTES, Room, local_room, missing_space, shared_cores
from vidstyle.batch.watch import LOOK_SECONDS, SETTLE_SECONDS, WatchedFolder
from vidstyle.cli.terminal.batch_display import BatchDisplay, live_table
from vidstyle.core.machine.cores import process_cores, use_threads
from vidstyle.errors import InputError, UsageError

PARTS = {"source": "0", "crf": "20"}


def make_files(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)


def found(*inputs: object) -> list[tuple[str, str]]:
    return [(source.path.name, source.folder) for source in find_sources([str(each) for each in inputs])]


def looks(*styles: str) -> list[FilmLook]:
    return [FilmLook("--style", style, lambda name: {"style": name}) for style in styles]


def film(path: Path, state: State = State.WAITING, code: int = 0) -> BatchFilm:
    source = Source(path, "")
    return BatchFilm(source, "ink", path.with_suffix(".mkv"), {}, Journal(path.parent), state, "", code)


def test_a_folder_gives_its_films_in_order(tmp_path: Path) -> None:
    names = ("b.mp4", "a.MOV", "sub/c d.mkv", "x.jpg", ".hidden.mp4", ".git/e.mp4", "a.partial.mp4")
    make_files(tmp_path / "trip", *names, "a.vidstyle-0123456789abcdef.mp4")
    assert found(tmp_path / "trip") == [("a.MOV", "trip"), ("b.mp4", "trip"), ("c d.mkv", "trip/sub")]


def test_patterns_lists_and_names_are_taken_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make_files(tmp_path, "clips/1.mp4", "clips/2.mp4", "clips/[3].mp4", "odd.bin", "none/readme")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "list.txt").write_text("\ufeffclips/2.mp4\n\n  odd.bin \nclips/*.mp4\n", encoding="utf-8")
    assert found("clips/*.mp4", "clips/[3].mp4", "clips") == [
        (name, "clips") for name in ("1.mp4", "2.mp4", "[3].mp4")
    ]
    assert [name for name, _ in found("list.txt")] == ["2.mp4", "odd.bin", "1.mp4", "[3].mp4"]
    for name in ("none", "no*.mp4"):
        with pytest.raises(UsageError, match="contains no films"):
            find_sources([name])


def test_a_list_of_itself_ends(tmp_path: Path) -> None:
    (tmp_path / "list.txt").write_text("list.txt\n", encoding="utf-8")
    assert found(tmp_path / "list.txt") == [("list.txt", tmp_path.name)]


def test_results_of_a_batch_are_no_inputs(tmp_path: Path) -> None:
    make_files(tmp_path, "a.mp4", "a-ink.mp4")
    Journal(tmp_path).begin(tmp_path / "a-ink.mp4", PARTS)
    assert [name for name, _ in found(tmp_path)] == ["a.mp4"]


def test_a_folder_as_output_keeps_the_name(tmp_path: Path) -> None:
    source = Source(Path("clips/a.mov"), "clips")
    assert result_path(str(tmp_path), source, "ink") == tmp_path / "a.mov"
    assert result_path("new/", source, "ink") == Path("new/a.mov")
    with pytest.raises(UsageError, match=r"no field \{nam\}; did you mean 'name'\?"):
        result_path("{nam}.mp4", source, "ink")


@pytest.mark.parametrize(
    ("template", "styles", "words"),
    [
        ("out.mp4", ["ink"], "would be the result of both .*a.mp4 and .*b.mp4; use {name}"),
        (
            "{name}.mp4",
            ["ink", "noir"],
            "would be the result of both --style ink and --style noir; use {style}",
        ),
        ("{folder}/../a.mp4", ["ink"], "would be the result of both"),
        ("a.mp4", ["ink"], "is an input, and would be overwritten"),
        ("{name}.xyz", ["ink"], "unknown extension '.xyz'"),
    ],
)
def test_names_are_checked_before_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, template: str, styles: list[str], words: str
) -> None:
    monkeypatch.chdir(tmp_path)
    make_files(tmp_path, "one/a.mp4", "one/b.mp4", "a.mp4")
    sources = find_sources(["one"] if "is an input" not in words else ["a.mp4"])
    with pytest.raises(UsageError, match=words):
        Planner(template, looks(*styles)).films(sources)


def test_a_look_may_be_a_file_for_each_film(tmp_path: Path) -> None:
    def settings(name: str) -> dict[str, str]:
        if name.endswith("b.toml"):
            raise InputError(name, "cannot be read")
        return {"style": name}

    sources = [Source(tmp_path / name, "day") for name in ("a.mp4", "b.mp4")]
    films = Planner("out/{name}.mp4", [FilmLook("--cues", "{folder}/{name}.toml", settings)]).films(sources)
    assert [(each.style, each.option, each.state) for each in films] == [
        ("day/a.toml", "--cues", State.WAITING),
        ("day/b.toml", "--cues", State.FAILED),
    ]
    assert films[0].settings == {"style": "day/a.toml"} and films[1].reason == "day/b.toml cannot be read"
    with pytest.raises(InputError):
        FilmLook("--cues", "b.toml", settings)
    with pytest.raises(UsageError, match="--cues: there is no field {style}|--cues there is no field"):
        Planner("out/{name}.mp4", [FilmLook("--cues", "{style}.toml", settings)]).films(sources)


def test_names_that_differ_in_case_only_are_the_same(tmp_path: Path) -> None:
    sources = [Source(tmp_path / name, "") for name in ("A.mp4", "a.mov")]
    with pytest.raises(UsageError, match="would be the result of both"):
        Planner("out/{name}.mp4", looks("ink")).films(sources)


def test_a_result_is_finished_only_as_it_was_made(tmp_path: Path) -> None:
    source, target, journal = tmp_path / "a.mp4", tmp_path / "b.mp4", Journal(tmp_path)
    make_files(tmp_path, "a.mp4", "b.mp4")
    assert not journal.is_finished(target, PARTS)
    journal.finish(target, PARTS, source)
    assert journal.is_finished(target, PARTS) and Journal(tmp_path).is_finished(target, PARTS)
    assert not journal.is_finished(target, {**PARTS, "crf": "21"})
    assert journal.changed_parts(target, {**PARTS, "crf": "21"}) == ["crf"]
    assert journal.source_digest(target, source) == PARTS["source"]
    source.write_text("other")
    assert journal.source_digest(target, source) is None
    target.write_text("other")
    assert not journal.is_finished(target, PARTS)


def test_a_batch_killed_before_its_last_line_has_finished_the_film(tmp_path: Path) -> None:
    journal, target = Journal(tmp_path), tmp_path / "b.mp4"
    make_files(tmp_path, "b.mp4")
    os.utime(target, (1, 1))
    journal.begin(target, PARTS)
    assert not journal.is_finished(target, PARTS), "it was there before"
    make_files(tmp_path, "b.mp4")
    assert journal.is_finished(target, PARTS)
    make_files(tmp_path, "b.partial.mp4")
    assert not journal.is_finished(target, PARTS), "another run has left it unfinished"


def test_a_line_that_was_cut_off_costs_no_other(tmp_path: Path) -> None:
    make_files(tmp_path, "a.mp4", "b.mp4")
    first, second = Journal(tmp_path), Journal(tmp_path)
    first.begin(tmp_path / "b.mp4", PARTS)
    assert second.names() == {"b.mp4"}
    with open(tmp_path / JOURNAL, "ab") as file:
        file.write(b'\n{"target": "c.m')
    assert second.names() == {"b.mp4"}
    first.finish(tmp_path / "b.mp4", PARTS, tmp_path / "a.mp4")
    assert second.is_finished(tmp_path / "b.mp4", PARTS)


def test_a_digest_is_of_the_content(tmp_path: Path) -> None:
    make_files(tmp_path, "a")
    before = content_digest(tmp_path / "a")
    os.utime(tmp_path / "a", (1, 1))
    (tmp_path / "a").rename(tmp_path / "b")
    assert content_digest(tmp_path / "b") == before


def test_a_result_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    target = tmp_path / "a.mp4"
    assert missing_space(target, 1, []) == ""
    assert "MB are free" in missing_space(target, 2**60, [])
    assert missing_space(target, 1, [(tmp_path / "b.mp4", 2**60)]), "others take the room"


def test_processes_share_the_cores() -> None:
    cores = process_cores().number
    room = local_room()
    jobs, threads = shared_cores(None, 1000, room)
    assert 1 <= jobs <= cores and threads == cores // jobs
    assert shared_cores(1, 1000, room) == (1, cores) and shared_cores(None, 1, room) == (1, cores)
    with use_threads(cores):
        room = local_room()
        assert shared_cores(None, 1000, room) == (1, cores) and shared_cores(3, 1000, room) == (3, cores)


def test_a_process_has_the_cores_of_one_machine() -> None:
    room = Room(cores=64, machine_cores=8, memory=64 * JOB_BYTES)
    assert shared_cores(None, 4, room) == (4, 8) and shared_cores(None, 1000, room) == (64, 1)
    assert shared_cores(None, 1000, replace(room, memory=10 * JOB_BYTES))[0] == 10
    with use_threads(4):
        assert shared_cores(None, 1000, room) == (16, 4)


def test_a_watched_file_is_taken_when_it_no_longer_changes(tmp_path: Path) -> None:
    now = 0.0
    folder = WatchedFolder(tmp_path, lambda: now)

    def taken_after(seconds: float) -> list[str]:
        nonlocal now
        now += seconds
        return [source.path.name for source in folder.complete_sources()]

    make_files(tmp_path, "a.mp4", "b.partial.mp4", "c.mp4.part")
    (tmp_path / "empty.mp4").touch()
    assert taken_after(0) == [] and taken_after(SETTLE_SECONDS - LOOK_SECONDS) == []
    with open(tmp_path / "a.mp4", "a", encoding="utf-8") as file:
        file.write("more")
    assert taken_after(LOOK_SECONDS) == [] and taken_after(SETTLE_SECONDS - LOOK_SECONDS) == []
    assert taken_after(LOOK_SECONDS) == ["a.mp4"]
    assert taken_after(SETTLE_SECONDS) == []
    make_files(tmp_path, "a.mp4")
    assert taken_after(LOOK_SECONDS) == [] and taken_after(SETTLE_SECONDS) == ["a.mp4"]


def test_a_folder_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        WatchedFolder(tmp_path / "none").complete_sources()


def test_a_bug_in_a_thread_ends_the_batch(tmp_path: Path) -> None:
    work = FilmBatch(
        [film(tmp_path / "none.mp4")], BatchOptions(1, 1), Processes(), on_end=lambda film: 1 / 0
    )
    with pytest.raises(ZeroDivisionError):
        work.run(threading.Event(), lambda: None)
    assert (work.films[0].state, work.films[0].exit_code) == (State.FAILED, 3)


def test_the_report_counts_and_estimates(tmp_path: Path) -> None:
    make_files(tmp_path, "aaaa.mp4", "bbbb.mp4", "cccc.mp4", "dddd.mp4")
    films = [
        film(tmp_path / "aaaa.mp4", State.DONE),
        film(tmp_path / "bbbb.mp4", State.SKIPPED),
        film(tmp_path / "cccc.mp4", State.FAILED, 5),
        film(tmp_path / "dddd.mp4", State.RUNNING),
    ]
    films[3].fraction = 0.5
    assert counts_text(films) == "1 running, 1 done, 1 skipped, 1 failed" and exit_code(films) == 5
    assert seconds_left(films, 30) == pytest.approx(10)
    assert exit_code([film(tmp_path / "aaaa.mp4", State.DONE, 4), films[1]]) == 4
    header, *rows = csv_text(films).splitlines()
    assert header.startswith("source,style,target,state,frames") and len(rows) == 4
    json.dumps([each.as_dict() for each in films])


def test_a_batch_that_waits_for_films_reports_it_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    make_files(tmp_path, "a.mp4")
    display, only = BatchDisplay(0), film(tmp_path / "a.mp4", State.DONE)
    for _ in range(3):
        display.update([only], 1.0)
    assert caplog.messages == ["1 done"]
    only.state = State.RUNNING
    for _ in range(3):
        display.update([only], 1.0)
    assert caplog.messages == ["1 done", *["1 running"] * 3]


def test_the_live_table_shows_the_films_under_way(tmp_path: Path) -> None:
    from rich.console import Console

    make_files(tmp_path, "a.mp4", "[red]b.mp4", "c.mp4")
    films = [film(tmp_path / "a.mp4", State.RUNNING), film(tmp_path / "[red]b.mp4", State.ELSEWHERE)]
    films[0].follow({"frames": 30, "fps": 12.34, "fraction": 0.25, "eta": 75.0})
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(live_table([*films, film(tmp_path / "c.mp4")], 20))
    first, second, last = console.export_text().splitlines()[1:]
    assert first.split() == ["a.mp4", "ink", "running", "25%", "12.3", "1:15"]
    assert second.split() == ["[red]b.mp4", "ink", "elsewhere"]
    assert last == "1 waiting, 1 running, 1 elsewhere: 12.3 fps, 5:00 left"
