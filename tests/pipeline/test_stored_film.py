"""Films in storage: fetched, restyled, and put back, also where the storage refuses requests."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import fsspec
import media
import pytest
from fsspec.implementations.memory import MemoryFileSystem

from vidstyle import cli
from vidstyle.core.machine.user_cache import user_cache
from vidstyle.errors import InputError, OutputError
from vidstyle.media import storage
from vidstyle.media.storage import StoredFile

FRAMES = 20


class FaultyStorage(MemoryFileSystem):
    """A storage in memory that refuses requests.

    Attributes:
        refusals: for each kind of request, numbers of those to refuse.
        requests: for each kind of request, how many there were.
    """

    protocol = ("s3", "sftp")
    cachable = False
    refusals: dict[str, set[int]] = {}
    requests: dict[str, int] = {}

    def _count(self, kind: str) -> None:
        self.requests[kind] = number = self.requests.get(kind, 0) + 1
        if number in self.refusals.get(kind, ()):
            raise ConnectionError("503 Slow Down,\nplease")

    @classmethod
    def _strip_protocol(cls, path: str) -> str:
        return "/" + path.partition("://")[2].strip("/") if "://" in path else path

    def cat_file(self, path: str, start: int | None = None, end: int | None = None, **options: Any) -> bytes:
        self._count("read")
        return super().cat_file(path, start=start, end=end, **options)

    def put_file(self, lpath: str, rpath: str, *rest: Any, mode: str = "overwrite", **options: Any) -> None:
        self._count("write")
        if mode == "create" and self.exists(rpath):
            raise FileExistsError(rpath)
        super().put_file(lpath, rpath, *rest, **options)


@pytest.fixture(autouse=True)
def bucket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MemoryFileSystem:
    """A storage with a film, and an empty cache."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    # Where an MP4 is flushed by the clock, its bytes depend on the machine's load.
    monkeypatch.setattr("vidstyle.media.write.film_writer.MAX_FLUSH_SECONDS", 1e6)
    monkeypatch.setattr(MemoryFileSystem, "store", {})
    monkeypatch.setattr(MemoryFileSystem, "pseudo_dirs", [""])
    monkeypatch.setattr(FaultyStorage, "refusals", {})
    monkeypatch.setattr(FaultyStorage, "requests", {})
    for scheme in FaultyStorage.protocol:
        fsspec.register_implementation(scheme, FaultyStorage, clobber=True)
    media.make_clip(Path("a.mp4"), size=(64, 48), frames=FRAMES, audio_tracks=1)
    files = FaultyStorage()
    files.pipe_file("/films/a.mp4", Path("a.mp4").read_bytes())
    return files


def render(*words: str) -> int:
    return cli.main(["render", "-s", "ink", "--threads", "1", *words])


def kept() -> list[str]:
    """The files in the cache."""
    return sorted(path.name for path in (user_cache() / "storage").rglob("*") if path.is_file())


@pytest.mark.parametrize("scheme", FaultyStorage.protocol)
def test_a_film_goes_from_storage_to_storage(
    bucket: MemoryFileSystem, scheme: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert render("a.mp4", "b.mp4") == 0
    bucket.pipe_file("/out/other.mp4", b"")
    capfd.readouterr()
    assert render(f"{scheme}://films/a.mp4", f"{scheme}://out/", "--json") == 0
    assert bucket.cat_file("/out/a.mp4") == Path("b.mp4").read_bytes()
    assert sorted(bucket.ls("/out", detail=False)) == ["/out/a.mp4", "/out/other.mp4"] and kept() == []
    summary = json.loads(capfd.readouterr().out)
    assert (summary["source"], summary["target"]) == (f"{scheme}://films/a.mp4", f"{scheme}://out/a.mp4")

    assert render(f"{scheme}://films/a.mp4", f"{scheme}://out/a.mp4") == 2
    assert "already exists; add -y" in capfd.readouterr().err
    assert render("a.mp4", f"{scheme}://out/a.mp4", "--crf", "40", "-y") == 0
    assert bucket.cat_file("/out/a.mp4") != Path("b.mp4").read_bytes()
    assert render(f"{scheme}://films/a.mp4", "c.mp4") == 0
    assert Path("c.mp4").read_bytes() == Path("b.mp4").read_bytes()


@pytest.mark.parametrize("scheme", FaultyStorage.protocol)
def test_a_refused_write_is_one_line_and_resume_writes_again(
    bucket: MemoryFileSystem, scheme: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FaultyStorage, "refusals", {"write": {1}})
    words = (f"{scheme}://films/a.mp4", f"{scheme}://out/a.mp4", "--progress", "none")
    assert render(*words) == 5
    last = capfd.readouterr().err.splitlines()[-1]
    assert f"{scheme}://out/a.mp4 cannot be written: 503 Slow Down, please; " in last
    assert "--resume tries again" in last
    assert kept() == ["a.mp4", "a.mp4", "lock"] and not bucket.exists("/out/a.mp4")
    reads = FaultyStorage.requests["read"]
    assert render(*words, "--resume") == 0 and kept() == []
    assert FaultyStorage.requests["read"] == reads, "fetched again"
    assert render("a.mp4", "b.mp4") == 0
    assert bucket.cat_file("/out/a.mp4") == Path("b.mp4").read_bytes()


def test_other_options_use_no_result_of_an_earlier_run(
    bucket: MemoryFileSystem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FaultyStorage, "refusals", {"write": {1}})
    assert render("a.mp4", "s3://out/a.mp4") == 5
    assert render("a.mp4", "s3://out/a.mp4", "--resume", "--crf", "40") == 0
    assert render("a.mp4", "b.mp4", "--crf", "40") == 0
    assert bucket.cat_file("/out/a.mp4") == Path("b.mp4").read_bytes()


def test_a_fetch_continues_where_it_was_refused(
    bucket: MemoryFileSystem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = bucket.cat_file("/films/a.mp4")
    monkeypatch.setattr(storage, "BLOCK_BYTES", len(content) // 4)
    monkeypatch.setattr(FaultyStorage, "refusals", {"read": {4}})
    monkeypatch.setattr(FaultyStorage, "requests", {})
    film, local = StoredFile("s3://films/a.mp4"), tmp_path / "part"
    with pytest.raises(InputError, match="cannot be read: 503 Slow Down, please"):
        film.fetch(local, lambda: None)
    assert local.stat().st_size == 3 * (len(content) // 4)
    local.write_bytes(local.read_bytes()[:-1])  # killed while it wrote a block
    film.fetch(local, lambda: None)
    assert local.read_bytes() == content
    blocks = -(-len(content) // (len(content) // 4))
    assert FaultyStorage.requests["read"] == 4 + blocks - 2


def test_a_film_that_changes_while_it_is_fetched_is_refused(bucket: MemoryFileSystem, tmp_path: Path) -> None:
    film, local = StoredFile("s3://films/a.mp4"), tmp_path / "part"
    with pytest.raises(InputError, match="was changed while it was read"):
        film.fetch(local, lambda: bucket.pipe_file("/films/a.mp4", bucket.cat_file("/films/a.mp4")))
    assert not local.exists()


def test_a_version_does_not_depend_on_the_time_of_access(
    bucket: MemoryFileSystem, monkeypatch: pytest.MonkeyPatch
) -> None:
    times = itertools.count()
    facts = bucket.info("/films/a.mp4")
    monkeypatch.setattr(FaultyStorage, "info", lambda self, path, **_: {**facts, "time": next(times)})
    film = StoredFile("sftp://films/a.mp4")
    version = film.version()
    assert film.version() == version
    facts["size"] += 1
    assert film.version() != version


@pytest.mark.parametrize("scheme", FaultyStorage.protocol)
def test_a_file_that_appears_meanwhile_is_not_replaced(bucket: MemoryFileSystem, scheme: str) -> None:
    bucket.pipe_file("/out/a.mp4", b"other")
    with pytest.raises(OutputError, match="has appeared meanwhile"):
        StoredFile(f"{scheme}://out/a.mp4").put(Path("a.mp4"), False)
    assert bucket.cat_file("/out/a.mp4") == b"other" and bucket.ls("/out", detail=False) == ["/out/a.mp4"]


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (("s3://films/none.mp4", "b.mp4"), 3, "s3://films/none.mp4: no such file"),
        (("sftp://me:secret@host/a.mp4", "b.mp4"), 2, "sftp://host/a.mp4 holds a password"),
        (("a.mp4", "s3://out/%03d.png"), 2, "is a pattern, and storage"),
        (("a.mp4", "oss://out/a.mp4"), 2, "oss://out/a.mp4 needs a package"),
    ],
)
def test_a_name_that_cannot_be_used_is_one_line(
    words: tuple[str, str], code: int, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert render(*words) == code
    err = capfd.readouterr().err
    assert message in err and "secret" not in err and err.count("\n") == 1 and not Path("b.mp4").exists()
