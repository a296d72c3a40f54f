"""Batches on a Ray cluster, whose machines and processes get lost."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import media
import psutil
import pytest
from waiting import eventually

from vidstyle import cli
from vidstyle.batch import ray_cluster
from vidstyle.batch.ray_cluster import check_address
from vidstyle.errors import UsageError

FRAMES = 120
TOKEN = "0123456789abcdef" * 4
BATCH = ["batch", "long.mp4", "-s", "sketch", "--segment", "0.5", "--progress", "plain"]
needs_ray = pytest.mark.skipif(find_spec("ray") is None, reason="Ray is not installed")


@pytest.fixture
def film(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A film of four segments, in the working directory."""
    monkeypatch.chdir(tmp_path)
    media.make_clip(Path("long.mp4"), frames=FRAMES, scene_frames=30, audio_tracks=1, chapters=2)
    return tmp_path


def start(*words: str, **environment: str) -> subprocess.Popen[str]:
    line = [sys.executable, "-m", "vidstyle", *BATCH, *words]
    return subprocess.Popen(
        line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, **environment}
    )


def ended(driver: subprocess.Popen[str]) -> list[str]:
    """What a batch that succeeds has printed."""
    _, err = driver.communicate()
    assert driver.returncode == 0, err
    assert [line for line in err.splitlines() if not line.startswith("vidstyle: ")] == [], "lines of Ray"
    return err.splitlines()


def on_this_machine() -> bytes:
    """The film, made without Ray."""
    ended(start("-o", "here/{name}.mp4", "-j", "1"))
    return Path("here/long.mp4").read_bytes()


def has_begun() -> bool:
    """Whether a segment is being made."""
    return any(Path("out").glob(".long.mp4.segments-*/*-*.vidstyle-*.segment"))


@pytest.fixture
def nodes() -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A cluster of two nodes, as `ray_nodes` starts it, and its address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    program = Path(__file__).with_name("ray_nodes.py")
    # The first variable keeps the ports on 127.0.0.1.
    variables = {
        "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",
        "RAY_USAGE_STATS_ENABLED": "0",
        "RAY_AUTH_MODE": "token",
        "RAY_AUTH_TOKEN": TOKEN,
    }
    cluster = subprocess.Popen(
        [sys.executable, program, str(port)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env={**os.environ, **variables},
    )
    assert cluster.stdout is not None and cluster.stdin is not None
    assert "up\n" in iter(cluster.stdout.readline, ""), "the cluster has not started"
    yield cluster, f"ray://127.0.0.1:{port}"
    cluster.stdin.close()
    cluster.wait()
    cluster.stdout.close()


@needs_ray
@pytest.mark.thorough
def test_a_lost_machine_changes_nothing(film: Path, nodes: tuple[subprocess.Popen[str], str]) -> None:
    cluster, address = nodes
    driver = start("-o", "out/{name}.mp4", "--on", address, RAY_AUTH_MODE="token", RAY_AUTH_TOKEN=TOKEN)
    eventually(has_begun)
    print(file=cluster.stdin, flush=True)
    lines = ended(driver)
    assert any("a worker of the cluster was lost; its task begins again" in line for line in lines), lines
    assert Path("out/long.mp4").read_bytes() == on_this_machine()
    assert sorted(path.name for path in Path("out").iterdir()) == [".vidstyle-batch.jsonl", "long.mp4"]


@needs_ray
@pytest.mark.thorough
def test_a_killed_batch_leaves_no_process_of_ray_and_is_continued(film: Path) -> None:
    words = ("-o", "out/{name}.mp4", "--on", "ray")
    driver = start(*words)
    eventually(has_begun)
    processes = psutil.Process(driver.pid).children(recursive=True)
    assert any("raylet" in process.name() for process in processes)
    driver.kill()
    driver.communicate()
    eventually(lambda: not any(process.is_running() for process in processes))

    lost = start(*words)
    eventually(has_begun)
    for process in psutil.Process(lost.pid).children():
        process.kill()
    _, err = lost.communicate()
    assert lost.returncode == 5 and "the connection to Ray was lost" in err

    ended(start(*words))
    assert Path("out/long.mp4").read_bytes() == on_this_machine()


@pytest.mark.parametrize("address", ["here", "ray://", "ray://host", "http://host:1"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    with pytest.raises(UsageError, match="give ray or ray://HOST:PORT"):
        check_address(address, False)


def test_another_machine_must_ask_for_a_token(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ray_cluster, "version_of", lambda name: "2.52.0")
    monkeypatch.setattr(ray_cluster, "find_spec", lambda name: True)
    monkeypatch.delenv("RAY_AUTH_MODE", raising=False)
    for address in ("ray://10.0.0.1:10001", "ray://[fd00::1]:10001", "ray://127.0.0.1.example:10001"):
        with pytest.raises(UsageError, match="RAY_AUTH_MODE is not 'token'.*add --insecure"):
            check_address(address, False)
        check_address(address, True)
    for address in ("ray", "ray://127.0.0.1:10001", "ray://[::1]:10001", "ray://localhost:10001"):
        check_address(address, False)
    monkeypatch.setenv("RAY_AUTH_MODE", "token")
    check_address("ray://10.0.0.1:10001", False)


def test_ray_is_asked_for_where_it_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ray_cluster, "find_spec", lambda name: None)
    words = ["batch", "a.mp4", "-s", "plain", "-o", "out/{name}.mp4", "--on", "ray"]
    assert cli.main(words) == 2
    needed = "--on needs Ray 2.52 or newer; pip install 'vidstyle[cluster]'"
    assert needed in capfd.readouterr().err
    assert cli.main([*words, "--emit", "shell"]) == 2 and "contradicts --emit" in capfd.readouterr().err
