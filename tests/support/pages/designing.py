"""A designer server with a clip, and a client, for the tests of the designer."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from live_page import Visitor
from waiting import guard
from websockets.sync.client import ClientConnection

from vidstyle.design.designer import Designer
from vidstyle.design.drafts import Drafts
from vidstyle.design.page import open_page
from vidstyle.design.page.design_server import DesignServer
from vidstyle.preview.clip import Clip, open_clip
from vidstyle.web.connection import PICTURE_HEADER


class SentPicture(NamedTuple):
    """A picture that was sent to the page."""

    kind: int
    number: int
    revision: int
    data: bytes

    @property
    def pixels(self) -> np.ndarray:
        """H x W x 3 RGB."""
        decoded = cv2.imdecode(np.frombuffer(self.data, np.uint8), cv2.IMREAD_COLOR)
        assert decoded is not None
        return decoded[..., ::-1]


class Page:
    """A client of the designer.

    Attributes:
        told: the newest message of each kind.
        pictures: all pictures that came.
        order: kinds of the messages since the last question, answers and pictures included.
        texts: all messages that are not pictures, as they came.
    """

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.told: dict[str, Any] = {}
        self.pictures: list[SentPicture] = []
        self.order: list[str] = []
        self.texts: list[str] = []
        self.progress: list[dict[str, Any]] = []
        self._answers: dict[int, dict[str, Any]] = {}
        self._id = 0

    def say(self, do: str, **fields: Any) -> int:
        """Send a message and return its id."""
        self._id += 1
        self.socket.send(json.dumps({"do": do, "id": self._id, **fields}))
        return self._id

    def ask(self, do: str, **fields: Any) -> dict[str, Any]:
        """Send a message and wait for its answer."""
        self.order = []
        return self.answer(self.say(do, **fields))

    def upload(self, name: str, content: bytes) -> dict[str, Any]:
        """Upload a file in one chunk, and return the answer."""
        id = self.say("upload", name=name, size=len(content))
        assert "error" not in self.answer(id)
        self.order = []
        self.socket.send(content)
        return self.answer(id)

    def error(self, do: str, **fields: Any) -> str:
        """Send a message and return its error, or ""."""
        return str(self.ask(do, **fields).get("error", ""))

    def answer(self, id: int) -> dict[str, Any]:
        """Wait for an answer."""
        left = guard()
        while id not in self._answers:
            self.take(left())
        return self._answers.pop(id)

    def wait_for(self, kind: str) -> Any:
        """Wait for a message of a kind."""
        left = guard(f"no {kind}")
        while kind not in self.told:
            self.take(left())
        return self.told[kind]

    def picture(self, kind: int, number: int | None = None) -> SentPicture:
        """Wait for a picture of a kind, and discard earlier ones."""
        left = guard(f"no picture of kind {kind}")
        while True:
            while self.pictures:
                sent = self.pictures.pop(0)
                if sent.kind == kind and number in (None, sent.number):
                    return sent
            self.take(left())

    def take(self, seconds: float) -> None:
        """Receive the next message."""
        data = self.socket.recv(seconds)
        if isinstance(data, bytes):
            self.pictures.append(SentPicture(*PICTURE_HEADER.unpack(data[:16]), data[16:]))
            self.order.append(f"picture {data[0]}")
            return
        self.texts.append(data)
        message = json.loads(data)
        if "answer" in message:
            self._answers[message["answer"]] = message
            self.order.append("answer")
        else:
            if "changes" in message:
                message = {"state": _changed(self.told["state"], message["changes"])}
            self.told |= message
            self.order += message
            self.progress += [message["progress"]] if "progress" in message else []


def _changed(state: dict[str, Any], changes: list[Any]) -> dict[str, Any]:
    """Apply changes as the page does (`session.js`)."""
    root: dict[str, Any] = {"root": copy.deepcopy(state)}
    for path, value in changes:
        *keys, last = ("root", *path)
        place: Any = root
        for key in keys:
            place = place[key]
        if isinstance(place, list) and last == "length":
            del place[value:]
        elif isinstance(place, list) and last == len(place):
            place.append(value)
        else:
            place[last] = value
    return dict(root["root"])


@contextmanager
def served(folder: Path, clip: Clip | None = None) -> Iterator[DesignServer]:
    """Serve a designer that writes to a folder, with a clip or the demo film."""
    designer = Designer(clip or open_clip(None), folder, Drafts(folder / "drafts" / "draft.json"))
    server = open_page(designer, device="cpu")
    try:
        yield server
        assert server.error is None
    finally:
        server.close()


@contextmanager
def shown(server: DesignServer, side: int = 64, where: str = "page") -> Iterator[Page]:
    """Connect a page to the designer."""
    with Visitor(server).look() as window:
        page = Page(window.socket)
        page.wait_for("drafts")
        assert page.error("watch", solo=None, side=side, where=where) == ""
        yield page
