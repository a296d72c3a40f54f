"""A network camera over RTSP: killed, restarted, frozen, silent, and with a wrong address."""

from __future__ import annotations

import contextlib
import socket
import struct
import threading

import av
import pytest
from live import Kept, session
from waiting import eventually

from vidstyle import cli
from vidstyle.errors import InputError
from vidstyle.media.capture import sources as live_sources
from vidstyle.media.capture.monotonic import MONOTONIC
from vidstyle.media.capture.sources import NetworkSource

RATE, SIZE = 25, (128, 96)
DESCRIPTION = (
    b"v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=camera\r\nc=IN IP4 127.0.0.1\r\nt=0 0\r\n"
    b"m=video 0 RTP/AVP 33\r\na=rtpmap:33 MP2T/90000\r\na=control:track\r\n"
)
TRANSPORT = "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n"


class Server:
    """Gives one film without an end, at /camera, as MPEG-TS in RTP among the answers (RFC 2326, 10.12).

    Attributes:
        frozen: set while sending is suspended.
        mute: whether not even questions are answered.
    """

    def __init__(self, port: int = 0, mute: bool = False) -> None:
        self.frozen, self.mute = threading.Event(), mute
        self._over = threading.Event()
        self._listening = socket.create_server(("127.0.0.1", port))
        self.port = int(self._listening.getsockname()[1])
        self._connections: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def kill(self) -> None:
        """Go away in mid-stream."""
        self._over.set()
        for each in (self._listening, *self._connections):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while not self._over.is_set():
                connection, _ = self._listening.accept()
                self._connections.append(connection)
                threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection: socket.socket) -> None:
        with contextlib.suppress(OSError, av.FFmpegError):
            asked = b""
            while part := connection.recv(4096):
                asked += part
                while not self.mute and b"\r\n\r\n" in asked:
                    question, _, asked = asked.partition(b"\r\n\r\n")
                    self._answer(connection, question.decode())

    def _answer(self, connection: socket.socket, question: str) -> None:
        lines = question.splitlines()
        method, address, _ = lines[0].split()
        number = next(line for line in lines if line.startswith("CSeq"))
        if method == "DESCRIBE" and not address.endswith("/camera"):
            connection.sendall(f"RTSP/1.0 404 Not Found\r\n{number}\r\n\r\n".encode())
            return
        content = DESCRIPTION if method == "DESCRIBE" else b""
        head = f"RTSP/1.0 200 OK\r\n{number}\r\nContent-Length: {len(content)}\r\n"
        head += "Content-Type: application/sdp\r\n" if content else TRANSPORT if method != "OPTIONS" else ""
        connection.sendall(f"{head}\r\n".encode() + content)
        if method == "PLAY":
            threading.Thread(target=self._play, args=(connection,), daemon=True).start()

    def _play(self, connection: socket.socket) -> None:
        with (
            contextlib.suppress(OSError, av.FFmpegError),
            av.open(Interleaved(connection), "w", "mpegts", container_options={"flush_packets": "1"}) as made,
        ):
            stream = made.add_stream("mpeg2video", rate=RATE)
            stream.width, stream.height, stream.pix_fmt, stream.gop_size = *SIZE, "yuv420p", 5
            for number in range(10**6):
                if self._over.wait(1 / RATE):
                    return
                while self.frozen.is_set() and not self._over.wait(0.02):
                    pass
                frame = av.VideoFrame(*SIZE, "yuv420p")
                frame.pts = number
                for plane in frame.planes:
                    plane.update(bytes([100 + number % 50]) * plane.buffer_size)
                made.mux(stream.encode(frame))


class Interleaved:
    """A file whose content goes into RTP packets on a connection."""

    def __init__(self, connection: socket.socket) -> None:
        self._connection, self._number = connection, 0

    def write(self, content: bytes) -> int:
        for begin in range(0, len(content), 7 * 188):
            part = content[begin : begin + 7 * 188]
            packet = (
                struct.pack("!BBHII", 0x80, 33, self._number & 0xFFFF, self._number * 3600 & 0xFFFFFFFF, 1)
                + part
            )
            self._connection.sendall(struct.pack("!cBH", b"$", 0, len(packet)) + packet)
            self._number += 1
        return len(content)


def test_it_plays_is_killed_and_comes_back(caplog: pytest.LogCaptureFixture):
    kept, server = Kept(), Server()
    with session(NetworkSource(f"rtsp://127.0.0.1:{server.port}/camera"), kept, clock=MONOTONIC) as running:
        eventually(lambda: len(kept.numbers) > 8)
        server.kill()
        eventually(lambda: "the last frame is repeated" in caplog.text)
        count = len(kept.numbers)
        server = Server(server.port)
        eventually(lambda: len(kept.numbers) > count + 8)
        running.end()
    server.kill()
    assert kept.newest is not None and (kept.newest.width, kept.newest.height) == SIZE
    assert "back after" in caplog.text


def test_one_that_freezes_is_lost_in_time(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(live_sources, "NETWORK_TIMEOUT_SECONDS", 2.0)
    kept, server = Kept(), Server()
    with session(NetworkSource(f"rtsp://127.0.0.1:{server.port}/camera"), kept, clock=MONOTONIC) as running:
        eventually(lambda: len(kept.numbers) > 8)
        server.frozen.set()
        # It is still there, says nothing, and hangs up on nobody.
        eventually(lambda: "was lost: no data for 2 s; the last frame is repeated" in caplog.text)
        count = len(kept.numbers)
        server.frozen.clear()
        eventually(lambda: len(kept.numbers) > count + 10)
        running.end()
    server.kill()


def test_what_it_has_not_is_one_line(capfd: pytest.CaptureFixture[str]):
    server = Server()
    address = f"rtsp://127.0.0.1:{server.port}/nothing"
    assert cli.main(["live", address, "--style", "plain", "--to", "null", "--no-keys"]) == 3
    server.kill()
    said = capfd.readouterr().err
    assert said == f"vidstyle: {address} cannot be opened: Server returned 404 Not Found\n"


def test_one_that_never_answers_is_not_waited_for(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(live_sources, "NETWORK_TIMEOUT_SECONDS", 0.5)
    server = Server(mute=True)
    with pytest.raises(InputError, match="has not answered within 0.5 s"):
        NetworkSource(f"rtsp://127.0.0.1:{server.port}/camera").open(threading.Event(), MONOTONIC)
    server.kill()
