"""A live page with frames, and clients, for the tests of the live page."""

from __future__ import annotations

import http.client
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

import av
import numpy as np
from waiting import LONG, guard
from websockets.sync.client import ClientConnection, connect

from vidstyle.live.control import Controls
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.page import PageTarget
from vidstyle.live.target import LiveFrame
from vidstyle.media.capture.monotonic import MONOTONIC, Clock
from vidstyle.media.frame import picture_from_frame
from vidstyle.style import load_style
from vidstyle.web.connection import PICTURE_HEADER


def live_frame(number: int = 0, size: tuple[int, int] = (64, 48), captured: float = 0.0) -> LiveFrame:
    """Return a frame with a ramp that gets brighter from frame to frame."""
    width, height = size
    ramp = (np.linspace(0, 150, width) + number % 100).astype(np.uint8)
    rgb = np.repeat(np.repeat(ramp[None, :, None], 3, axis=2), height, axis=0)
    picture = av.VideoFrame.from_ndarray(rgb, format="rgb24").reformat(format="yuv420p")
    return LiveFrame(picture_from_frame(picture), captured, number)


class Visitor:
    """Sends requests to the server of a page, as a browser or as an attacker."""

    def __init__(self, page: PageTarget, address: str = "") -> None:
        """`address`: host to connect to; "" for the host of the page."""
        parts = urlsplit(page.url)
        self.port = int(parts.port or 0)
        self.address = address or str(parts.hostname)
        self.host = f"{self.address}:{self.port}"
        self.token = parts.query.partition("=")[2]
        self.cookie = f"vidstyle-{self.port}={self.token}"

    def ask(
        self, path: str, headers: list[tuple[str, str]] | None = None, method: str = "GET", body: bytes = b""
    ) -> tuple[int, dict[str, str], bytes]:
        """Return status, headers with lower-case names, and body; status 0 if the connection is closed."""
        headers = self.headers() if headers is None else headers
        connection = http.client.HTTPConnection(self.address, self.port, timeout=LONG)
        try:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in headers:
                connection.putheader(name, value)
            connection.endheaders(body)
            answer = connection.getresponse()
            return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read()
        except (http.client.HTTPException, ConnectionError):
            return 0, {}, b""
        finally:
            connection.close()

    def headers(
        self, host: str | None = None, cookie: str | None = None, **more: str
    ) -> list[tuple[str, str]]:
        """Return the headers of a browser with access; names of `more` have _ instead of -."""
        pairs = [("Host", host or self.host), ("Cookie", cookie or self.cookie)]
        return pairs + [(name.replace("_", "-"), value) for name, value in more.items()]

    @contextmanager
    def look(
        self, origin: str | None = "", cookie: str | None = None, path: str = "/socket"
    ) -> Iterator[Window]:
        """Open a WebSocket like a browser; `origin`: None for no header, "" for the page's origin."""
        own = f"http://{self.host}" if origin == "" else origin
        with connect(
            f"ws://{self.host}{path}",
            max_size=None,  # as in browsers; plans of large styles exceed a megabyte
            origin=own,  # type: ignore[arg-type]
            additional_headers={"Cookie": self.cookie if cookie is None else cookie},
            open_timeout=LONG,
            close_timeout=LONG,
            max_queue=None,  # as in browsers, which answer pings while messages wait
            compression=None,
            proxy=None,
        ) as socket:
            yield Window(socket)


class Window:
    """The messages of a browser."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self._id = 0
        self._unread: list[str | bytes] = []

    def say(self, **message: Any) -> int:
        """Send a message and return its number."""
        self._id += 1
        self.socket.send(json.dumps(message | {"id": self._id}))
        return self._id

    @property
    def pictures(self) -> int:
        """Return the number of received pictures that have not been read."""
        return sum(isinstance(data, bytes) for data in self._unread)

    def picture(self) -> tuple[int, bytes]:
        """Return number and JPEG data of the next picture."""
        data = self._next(lambda data: isinstance(data, bytes))
        assert isinstance(data, bytes)
        return PICTURE_HEADER.unpack(data[: PICTURE_HEADER.size])[1], data[PICTURE_HEADER.size :]

    def news(self, name: str) -> Any:
        """Return the next news with this name."""
        return json.loads(self._next(lambda data: isinstance(data, str) and name in json.loads(data)))[name]

    def _next(self, is_wanted: Callable[[str | bytes], bool]) -> str | bytes:
        """Return the first wanted message; keep the others for later."""
        left = guard()
        for place, data in enumerate(self._unread):
            if is_wanted(data):
                return self._unread.pop(place)
        while not is_wanted(data := self.socket.recv(left())):
            self._unread.append(data)
        return data

    def answer(self, **message: Any) -> dict[str, Any]:
        """Send a message and wait for its answer."""
        return self.answer_to(self.say(**message))

    def answer_to(self, id: int) -> dict[str, Any]:
        """Wait for the next answer to the message of this number."""
        found = self._next(lambda data: isinstance(data, str) and json.loads(data).get("answer") == id)
        return dict(json.loads(found))

    def ask(self, **message: Any) -> str:
        """Send a message and return its error, or ""."""
        return str(self.answer(**message).get("error", ""))


@contextmanager
def showing(
    style: object = "ink", names: list[str] | None = None, clock: Clock = MONOTONIC, **given: Any
) -> Iterator[tuple[PageTarget, Controls, Visitor]]:
    """Yield a page with one frame, its controls, and a client; `given` are arguments of the page."""
    controls = Controls(load_style(style), names)  # type: ignore[arg-type]
    page = PageTarget(controls, meter=LatencyMeter(clock), **given)
    try:
        page.offer(live_frame())
        yield page, controls, Visitor(page)
    finally:
        page.close()
