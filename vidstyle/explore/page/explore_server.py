"""The web server of the explorer."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from aiohttp import web

from vidstyle.errors import OutputError, UsageError, VidstyleError
from vidstyle.explore.chooser import Tile
from vidstyle.explore.page import outputs
from vidstyle.explore.page.exploration import Exploration
from vidstyle.explore.page.explore_messages import ACTIONS, MESSAGE_FIELDS
from vidstyle.explore.page.pictures import picture_handlers
from vidstyle.export import RUNNER_FOLDER
from vidstyle.pipeline.progress import Progress
from vidstyle.style import Style
from vidstyle.web.messages import RateLimit, read_message, receive, refuse
from vidstyle.web.server import WebServer

STATIC_FOLDER = Path(__file__).with_name("static")
MAX_VIEWERS, MAX_MESSAGES, MAX_UNDER_WAY = 4, 250, 40
"""Maximum number of browsers; of messages per second from each; and of unanswered messages from each."""

OpenDesigner = Callable[[str | None, Style], str]
"""Opens the designer on a source with a style; returns its URL."""


class ExploreServer:
    """Serves the page until it is closed.

    Attributes:
        url: the URL of the page, with its access token.
        one_time_url: a URL that admits a single browser.
    """

    def __init__(self, exploration: Exploration, port: int = 0, designer: OpenDesigner | None = None) -> None:
        """Open the page.

        Args:
            exploration: the exploration; closed with the server.
            port: port to listen on; 0 selects a free one.
            designer: opens the designer, if available.

        Raises:
            OutputError: the port is taken or needs privileges.
        """
        self.exploration, self.designer = exploration, designer
        self._viewers: list[_Viewer] = []
        self._stop: threading.Event | None = None
        self._failure: BaseException | None = None
        handlers = {"/socket": self._serve_socket, **picture_handlers(exploration)}
        try:
            self._server = WebServer(
                "vidstyle page", handlers, [STATIC_FOLDER, RUNNER_FOLDER], "explore.html", port
            )
        except OSError as error:
            reason = f"port {port}: {error.strerror or error}"
            raise OutputError("page", reason, "give another with --port") from error
        self.url, self.one_time_url = self._server.url, self._server.one_time_url
        threading.Thread(target=self._begin, name="vidstyle first screen", daemon=True).start()

    @property
    def error(self) -> BaseException | None:
        """The exception that ended the server (a bug in this program), or None."""
        return self._failure or self._server.error

    def close(self) -> None:
        """Cancel jobs and close the server."""
        self.cancel()
        self.exploration.close()
        self._server.close()

    def _begin(self) -> None:
        try:
            self.exploration.begin()
        except Exception as error:
            self._failure = error
        self._server.submit(self.send_state)

    def cancel(self) -> None:
        """Cancel rendering, if any."""
        if self._stop is not None:
            self._stop.set()

    # Messages to browsers

    def clip(self) -> dict[str, Any]:
        """Return the message that describes the clip and available actions."""
        exploration = self.exploration
        return {
            "name": Path(exploration.clip.name).name,
            "size": exploration.clip.size,
            "frames": list(exploration.frames),
            "rate": exploration.rate,
            "count": exploration.clip.count,
            "render": not exploration.clip.live,
            "design": self.designer is not None,
            "folder": str(Path.cwd()),
        }

    def state(self) -> dict[str, Any]:
        """Return the message that describes the current state."""
        chooser = self.exploration.chooser
        if not chooser.screens:
            return {"tiles": []}
        screen = chooser.screen
        return {
            "at": chooser.at,
            "tiles": [self._describe(tile) for tile in screen.tiles],
            "taken": screen.taken,
            "back": screen.before is not None,
            "forward": screen.after is not None,
            "near": chooser.near,
            "locks": sorted(chooser.locks),
            "history": [self._face(each.tiles) for each in chooser.screens],
            "stars": [self._describe(tile) for tile in chooser.stars],
        }

    def _describe(self, tile: Tile) -> dict[str, Any]:
        layers = {layer: [step.block for step in steps] for layer, steps in tile.style.layers.items()}
        return {
            "tile": self.exploration.number(tile),
            "name": tile.style.name,
            "kind": tile.kind,
            "parents": tile.parents,
            "layers": {layer: blocks for layer, blocks in layers.items() if blocks},
            "ink": tile.style.ink,
            "paper": tile.style.paper,
        }

    def _face(self, tiles: tuple[Tile, ...]) -> list[int]:
        """Return the tiles that represent a screen: the chosen one, or four of a first screen."""
        middle = tiles[len(tiles) // 2]
        return [
            self.exploration.number(tile) for tile in ((middle,) if middle.kind == "chosen" else tiles[:4])
        ]

    async def send_state(self) -> None:
        """Send the state to all browsers."""
        for viewer in list(self._viewers):
            await viewer.send({"state": self.state()})

    # Messages from browsers

    async def _serve_socket(self, request: web.Request) -> web.StreamResponse:
        return await self._server.serve(request, _Viewer(self), self._viewers, MAX_VIEWERS)

    async def answer(self, message: Mapping[str, Any], sent: set[str]) -> dict[str, Any]:
        """Handle a message and return its answer.

        Args:
            sent: the keys of the plans that the browser has.

        Raises:
            VidstyleError: the request failed.
        """
        do, exploration = message["do"], self.exploration
        fields = [message[name] for name in MESSAGE_FIELDS[do] if name != "id"]
        match do:
            case "plan":
                return await self._plan(exploration.tile(message["tile"]).style, message, sent)
            case "tune":
                pad = await asyncio.to_thread(exploration.pad, message["tile"])
                return await self._plan(pad.style_at(message["x"], message["y"]), message, sent)
            case "pad":
                pad = await asyncio.to_thread(exploration.pad, message["tile"])
                axes = [{"path": axis.path, "low": axis.low, "high": axis.high, "whole": axis.is_whole,
                         "factor": axis.is_factor} for axis in pad.axes]  # fmt: skip
                return {"axes": axes, "start": pad.start}
            case "save":
                tile, name, overwrite = fields
                style = exploration.tile(tile).style
                return {"file": str(await asyncio.to_thread(outputs.save, style, name, overwrite))}
            case "export":
                tile, name, kind = fields
                style = exploration.tile(tile).style
                return {"file": str(await asyncio.to_thread(outputs.write_export, style, name, kind))}
            case "render":
                return {"file": await asyncio.to_thread(self._render, *fields)}
            case "cancel":
                self.cancel()
                return {}
            case "design":
                if self.designer is None:
                    raise UsageError("designer", "cannot be opened from here")
                style = exploration.tile(message["tile"]).style
                return {"url": await asyncio.to_thread(self.designer, exploration.clip.file(), style)}
        action = getattr(exploration, ACTIONS[do])
        result = await asyncio.to_thread(action, *fields)
        await self.send_state()
        return {"tile": result} if do == "keep" else {"clip": self.clip()} if do == "move" else {}

    async def _plan(self, style: Style, message: Mapping[str, Any], sent: set[str]) -> dict[str, Any]:
        """Return the plan of a style; only its values if the browser has it, unless it requests the whole."""
        plan = await asyncio.wrap_future(self.exploration.plan(style, message["side"]))
        if plan["key"] in sent and not message["whole"]:
            return {name: plan[name] for name in ("key", "values")}
        sent.add(plan["key"])
        return plan

    def _render(self, tile: int, name: str) -> str:
        if self._stop is not None:
            raise UsageError("render", "a film is being rendered", "wait for it, or cancel it")
        self._stop = stop = threading.Event()
        try:
            style = self.exploration.tile(tile).style
            return str(outputs.render_clip(self.exploration.clip, style, name, self._tell_progress, stop))
        finally:
            self._stop = None

    def _tell_progress(self, progress: Progress) -> None:
        self._server.submit(self._send_progress, progress.as_dict())

    async def _send_progress(self, progress: dict[str, Any]) -> None:
        for viewer in list(self._viewers):
            await viewer.send({"progress": progress})


class _Viewer:
    """Serves one WebSocket until it closes."""

    def __init__(self, page: ExploreServer) -> None:
        self._page = page
        self._sent: set[str] = set()
        self._under_way = asyncio.Semaphore(MAX_UNDER_WAY)
        self._limit = RateLimit(MAX_MESSAGES, asyncio.get_running_loop().time)

    async def serve(self, socket: web.WebSocketResponse) -> None:
        """Answer messages until the socket closes."""
        self._socket = socket
        try:
            await self.send({"clip": self._page.clip()})
            await self.send({"state": self._page.state()})
            async with asyncio.TaskGroup() as tasks:
                self._tasks = tasks
                invalid = await receive(socket, self._handle)
                if invalid is not None:
                    await refuse(socket, invalid)
        except* ConnectionError:  # the browser disconnected without closing the socket
            pass

    async def send(self, message: dict[str, Any]) -> None:
        """Send a message, unless the browser has disconnected."""
        if not self._socket.closed:
            await self._socket.send_str(json.dumps(message))

    async def _handle(self, data: str | bytes) -> None:
        self._limit.count()
        message = read_message(data, MESSAGE_FIELDS)
        await self._under_way.acquire()
        self._tasks.create_task(self._answer(message))

    async def _answer(self, message: dict[str, Any]) -> None:
        answer: dict[str, Any] = {"answer": message["id"]}
        try:
            answer |= await self._page.answer(message, self._sent)
        except VidstyleError as error:
            answer["error"] = str(error)
        finally:
            self._under_way.release()
        await self.send(answer)
