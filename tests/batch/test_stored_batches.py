"""Batches of films in storage, with real processes; also where the storage refuses writes."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import folder_storage
import media
import pytest

SECRET = "SecretKeyOfThisTest"
OUTPUT = ("-o", "s3://out/{folder}/{name}-{style}.mp4")


@pytest.fixture(autouse=True)
def environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """The variables of the program; a storage with three films."""
    monkeypatch.chdir(tmp_path)
    films = Path("storage/films")
    (films / "day 1").mkdir(parents=True)
    for number, name in enumerate(("a.mp4", "b.mkv", "day 1/c.mp4")):
        media.make_clip(films / name, size=(64, 48), frames=5 + number, audio_tracks=1)
    (films / "notes.md").write_text("no film")
    (films / ".hidden").mkdir()
    (films / ".hidden" / "d.mp4").write_text("not asked for")
    variables = folder_storage.install(tmp_path / "about", tmp_path / "storage")
    return {**variables, "XDG_CACHE_HOME": str(tmp_path / "cache"), "AWS_SECRET_ACCESS_KEY": SECRET}


def batch(environment: dict[str, str], *words: str) -> tuple[int, list[dict[str, Any]], str]:
    """Exit code, films of the summary, standard error."""
    # `plain`: the empty cache of each test has no kernels, and compiling them would take most of its time.
    line = [sys.executable, "-m", "vidstyle", "batch", "-s", "plain", "--threads", "1", "--json"]
    result = subprocess.run([*line, "--progress", "plain", *words], env=environment, capture_output=True)
    out, err = result.stdout.decode(), result.stderr.decode()
    assert SECRET not in out + err
    return result.returncode, json.loads(out)["films"] if out else [], err


def states(films: list[dict[str, Any]]) -> list[str]:
    return [film["state"] for film in films]


def stored() -> dict[str, bytes]:
    """The results in storage."""
    return {path.relative_to("storage/out").as_posix(): path.read_bytes() for path in sorted(results())}


def results() -> list[Path]:
    return [path for path in Path("storage/out").rglob("*") if path.is_file()]


def expected() -> dict[str, bytes]:
    """The results of a batch of the same films on this machine."""
    words = ("batch", "-s", "plain", "--threads", "1", "-o", "local/{folder}/{name}-{style}.mp4")
    subprocess.run(
        [sys.executable, "-m", "vidstyle", *words, "storage/films"], check=True, capture_output=True
    )
    return {
        path.relative_to("local").as_posix(): path.read_bytes()
        for path in sorted(Path("local").rglob("*.mp4"))
    }


def kept() -> list[Path]:
    """The local copies of films."""
    return [path for path in Path("cache/vidstyle/storage").rglob("*") if path.is_file()]


def test_films_go_from_storage_to_storage_and_are_skipped_until_they_change(
    environment: dict[str, str],
) -> None:
    code, films, err = batch(environment, "s3://films/", *OUTPUT, "-j", "2")
    assert (code, states(films)) == (0, ["done"] * 3), err
    assert films[2]["source"] == "s3://films/day 1/c.mp4"
    assert stored() == expected() and len(stored()) == 3 and kept() == []
    assert SECRET not in "".join(path.read_text() for path in Path("cache").rglob("*.jsonl"))

    assert states(batch(environment, "s3://films", *OUTPUT)[1]) == ["skipped"] * 3
    Path("list.txt").write_text("s3://films/a.mp4\ns3://films/b.mkv\n")
    words = ("list.txt", "-o", "s3://out/films/{name}-{style}.mp4")
    assert states(batch(environment, *words)[1]) == ["skipped"] * 2
    code, films, _ = batch(environment, *words, "--crf", "40", "--dry-run")
    assert code == 2 and "already exists, made with another crf; add -y" in films[0]["reason"]

    media.make_clip(Path("storage/films/a.mp4"), size=(64, 48), frames=9)
    code, films, _ = batch(environment, "s3://films/*.m*", *words[1:])
    assert code == 2 and "made with another source; add -y" in films[0]["reason"]
    code, films, _ = batch(environment, "s3://films/*.mp4", *words[1:], "-y")
    assert (code, states(films)) == (0, ["done"])
    assert len(media.read_all(Path("storage/out/films/a-plain.mp4"))) == 9

    Path("storage/out/films/b-plain.mp4").write_bytes(b"another program")
    code, films, _ = batch(environment, *words)
    assert (code, states(films)) == (2, ["skipped", "failed"]) and "already exists" in films[1]["reason"]


def test_one_side_may_be_on_this_machine(environment: dict[str, str]) -> None:
    code, films, err = batch(environment, "s3://films", "-o", "here/")
    assert (code, states(films)) == (0, ["done"] * 3), err
    assert sorted(os.listdir("here")) == [".vidstyle-batch.jsonl", "a.mp4", "b.mkv", "c.mp4"]
    assert states(batch(environment, "s3://films", "-o", "here/")[1]) == ["skipped"] * 3
    code, films, err = batch(environment, "storage/films/a.mp4", "-o", "s3://out/")
    assert (code, states(films)) == (0, ["done"]), err
    assert stored()["a.mp4"] == Path("here/a.mp4").read_bytes()
    assert states(batch(environment, "storage/films/a.mp4", "-o", "s3://out/")[1]) == ["skipped"]


def test_refused_writes_are_a_line_or_another_attempt(environment: dict[str, str]) -> None:
    environment |= {folder_storage.PERIOD: "3"}
    code, films, err = batch(environment, "s3://films", *OUTPUT, "-j", "1")
    assert (code, states(films)) == (5, ["done", "done", "failed"])
    assert "cannot be written: 503 Slow Down" in films[2]["reason"] and err.count("503") == 1
    assert len(kept()) == 3, "the source, the result, and the lock of the film that failed"
    code, films, _ = batch(environment, "s3://films", *OUTPUT, "-j", "1")
    assert (code, states(films)) == (0, ["skipped", "skipped", "done"])
    assert stored() == expected() and kept() == []

    words = ("s3://films", "-o", "s3://out/again/{name}.mp4", "--retry", "1", "-j", "1")
    code, films, _ = batch(environment, *words)
    assert (code, states(films)) == (0, ["done"] * 3) and max(film["attempts"] for film in films) == 2


def test_a_batch_that_was_killed_continues(environment: dict[str, str]) -> None:
    words = ("s3://films/a.mp4", *OUTPUT)
    assert batch(environment, *words)[0] == 0
    assert (
        "s3://out/films contains no films" in batch(environment, "s3://out/films", "-o", "s3://out/again/")[2]
    )
    (journal,) = Path("cache").rglob(".vidstyle-batch.jsonl")
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:-1]))  # killed after the film was put, before its line was written
    assert states(batch(environment, *words)[1]) == ["skipped"]
    (Path("storage/out/films/a-plain.mp4")).unlink()
    assert states(batch(environment, *words)[1]) == ["done"]


def test_a_film_that_appears_after_a_failure_is_no_result(environment: dict[str, str]) -> None:
    words = ("s3://films/a.mp4", *OUTPUT)
    assert batch(environment | {folder_storage.PERIOD: "1"}, *words)[0] == 5
    Path("storage/out/films").mkdir(parents=True)
    Path("storage/out/films/a-plain.mp4").write_bytes(b"another program")
    code, films, _ = batch(environment, *words)
    assert (code, states(films)) == (2, ["failed"]) and "already exists" in films[0]["reason"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("s3://films", "-o", "s3://out/", "--segment", "30"), 2, "--segment needs files on this machine"),
        (("s3://films/none/", "-o", "s3://out/"), 2, "s3://films/none/ contains no films"),
        (("s3://films/*.avi", "-o", "s3://out/"), 2, "s3://films/*.avi contains no films"),
        (("s3://films/list.txt", "-o", "s3://out/"), 2, "s3://films/list.txt is a list in storage"),
        (("s3://films/none.mp4", "-o", "s3://out/"), 3, "s3://films/none.mp4: no such file"),
        (("s3://films/", "-o", "s3://out/{name}"), 2, "has no extension"),
        (("s3://films/", "-o", "s3://out/a.mp4"), 2, "would be the result of both"),
        (("s3://films/", "-o", "s3://films/{name}.mp4"), 2, "is an input"),
        (("sftp://me:hidden@host/a.mp4", "-o", "s3://out/"), 2, "sftp://host/a.mp4 holds a password"),
        (("storage/films/a.mp4", "-o", "sftp://me:hidden@host/"), 2, "sftp://host/a.mp4 holds a password"),
    ],
)
def test_what_cannot_be_is_one_line(
    environment: dict[str, str], words: tuple[str, ...], code: int, message: str
) -> None:
    result = batch(environment, *words)
    assert result[0] == code and message in result[2] and "hidden" not in result[2] + str(result[1])
    assert sum(message in line for line in result[2].splitlines()) == 1 and not results()
