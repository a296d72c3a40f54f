"""Films in a real S3 server (moto) behind a proxy that refuses every third write."""

from __future__ import annotations

import http.client
import json
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import media
import pytest

pytestmark = pytest.mark.thorough
SECRET = "SecretKeyOfThisTest"


class Proxy(BaseHTTPRequestHandler):
    """Passes requests on, and counts what they fetch and write; `upstream`: host and port."""

    protocol_version = "HTTP/1.1"
    upstream = ("", 0)
    writes, refused, fetched = 0, 0, 0

    def _pass_on(self) -> None:
        kind = type(self)
        body = self.rfile.read(int(self.headers.get("Content-Length", 0)))
        if self.command == "PUT":
            kind.writes += 1
            if kind.writes % 3 == 0:
                kind.refused += 1
                self._answer(503, [], b"<Error><Code>SlowDown</Code><Message>no</Message></Error>")
                return
        connection = http.client.HTTPConnection(*self.upstream)
        connection.request(self.command, self.path, body, dict(self.headers))
        response = connection.getresponse()
        content = response.read()
        if response.status == 206:  # a range of a file
            kind.fetched += len(content)
        self._answer(response.status, response.getheaders(), content)
        connection.close()

    def _answer(self, status: int, headers: list[tuple[str, str]], content: bytes) -> None:
        self.send_response_only(status)
        is_head = self.command == "HEAD"
        for name, value in headers:
            if name.lower() not in ("connection", "transfer-encoding") and (
                is_head or name.lower() != "content-length"
            ):
                self.send_header(name, value)
        if not is_head:
            self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(b"" if is_head else content)

    def log_message(self, format: str, *values: object) -> None:
        """Print nothing."""


for method in ("GET", "PUT", "HEAD", "DELETE", "POST"):
    setattr(Proxy, f"do_{method}", Proxy._pass_on)


@pytest.fixture
def environment(tmp_path: Path) -> Iterator[dict[str, str]]:
    """The variables of a program that uses the server."""
    server_kind = pytest.importorskip("moto.server").ThreadedMotoServer
    pytest.importorskip("s3fs")
    server = server_kind(ip_address="127.0.0.1", port=0, verbose=False)
    server.start()
    Proxy.upstream, Proxy.writes, Proxy.refused, Proxy.fetched = server.get_host_and_port(), 0, 0, 0
    proxy = ThreadingHTTPServer(("127.0.0.1", 0), Proxy)
    threading.Thread(target=proxy.serve_forever, daemon=True).start()
    yield {
        **os.environ,
        "XDG_CACHE_HOME": str(tmp_path / "cache"),
        "AWS_ACCESS_KEY_ID": "test",
        "AWS_SECRET_ACCESS_KEY": SECRET,
        "AWS_DEFAULT_REGION": "us-east-1",
        "AWS_ENDPOINT_URL": f"http://127.0.0.1:{proxy.server_address[1]}",
    }
    proxy.shutdown()
    proxy.server_close()
    server.stop()


def run(environment: dict[str, str], *words: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *words], env=environment, capture_output=True, text=True)


def test_refused_writes_change_no_film(environment: dict[str, str], tmp_path: Path) -> None:
    local = tmp_path / "a.mp4"
    media.make_clip(local, size=(320, 180), frames=40, audio_tracks=1)
    fill = "import s3fs, sys; files = s3fs.S3FileSystem(); files.mkdir('films'); "
    fill += "files.put_file(sys.argv[1], 'films/a.mp4')"
    filled = run(environment, "-c", fill, str(local))
    assert filled.returncode == 0, filled.stderr
    words = ("-m", "vidstyle", "render", "-s", "ink", "--threads", "1")
    assert run(environment, *words, str(local), str(tmp_path / "b.mp4")).returncode == 0
    for number in range(4):
        result = run(environment, *words, "s3://films/a.mp4", f"s3://films/out/{number}.mp4")
        assert result.returncode == 0 and SECRET not in result.stderr, result.stderr
    assert Proxy.refused > 0
    assert Proxy.fetched == 4 * local.stat().st_size, "each byte of the source once"
    for number in range(4):
        copy = tmp_path / f"{number}.mp4"
        get = "import s3fs, sys; s3fs.S3FileSystem().get_file(sys.argv[1], sys.argv[2])"
        assert run(environment, "-c", get, f"films/out/{number}.mp4", str(copy)).returncode == 0
        assert copy.read_bytes() == (tmp_path / "b.mp4").read_bytes()


@pytest.mark.parametrize("where", [(), ("--on", "ray")], ids=["here", "ray"])
def test_a_batch_goes_on_where_writes_are_refused(
    environment: dict[str, str], tmp_path: Path, where: tuple[str, ...]
) -> None:
    if where:
        pytest.importorskip("ray")
    media.make_clip(tmp_path / "a.mp4", size=(320, 180), frames=20, audio_tracks=1)
    bucket = f"batch-{len(where)}"  # moto keeps those of earlier tests
    fill = "import s3fs, sys; files = s3fs.S3FileSystem(); files.mkdir(sys.argv[2]); "
    fill += "[files.put_file(sys.argv[1], f'{sys.argv[2]}/in/{name}.mp4') for name in 'abc']"
    filled = run(environment, "-c", fill, str(tmp_path / "a.mp4"), bucket)
    assert filled.returncode == 0, filled.stderr
    words = ("-m", "vidstyle", "render", "-s", "ink", "--threads", "1")
    assert run(environment, *words, str(tmp_path / "a.mp4"), str(tmp_path / "b.mp4")).returncode == 0
    words = (
        "-m",
        "vidstyle",
        "batch",
        f"s3://{bucket}/in/*.mp4",
        "-s",
        "ink",
        "--threads",
        "1",
        "--json",
        *where,
    )
    words += ("-o", "s3://" + bucket + "/out/{name}.mp4", "--retry", "2", "-j", "2")
    for state in ("done", "skipped"):
        result = run(environment, *words)
        assert result.returncode == 0 and SECRET not in result.stdout + result.stderr, result.stderr
        assert [film["state"] for film in json.loads(result.stdout)["films"]] == [state] * 3
    assert Proxy.refused > 0
    for name in "abc":
        copy = tmp_path / f"copy-{name}.mp4"
        get = "import s3fs, sys; s3fs.S3FileSystem().get_file(sys.argv[1], sys.argv[2])"
        assert run(environment, "-c", get, f"{bucket}/out/{name}.mp4", str(copy)).returncode == 0
        assert copy.read_bytes() == (tmp_path / "b.mp4").read_bytes()
