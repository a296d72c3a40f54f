"""The page as a target of a live session."""

from __future__ import annotations

import asyncio
import logging
import threading

from vidstyle.errors import OutputError
from vidstyle.live.control import Controls
from vidstyle.live.meter import Meter
from vidstyle.live.page.hub import FrameHub
from vidstyle.live.page.server import CLOSE_SECONDS, Server
from vidstyle.live.target import LiveFrame

log = logging.getLogger("vidstyle")


class PageTarget:
    """A target, see `Target`: a web page for browsers on this machine, served by a thread of its own.

    Attributes:
        url: where it is, with the secret that lets a browser in.
    """

    name = "page"
    repeated = 0

    def __init__(self, controls: Controls, port: int = 0, meter: Meter | None = None) -> None:
        """Open it, and say where it is.

        Args:
            controls: of the session.
            port: of this machine; 0 is any that is free.
            meter: is told when a browser has shown a frame.

        Raises:
            OutputError: the port is taken, or not ours to take.
        """
        self._exhibit = FrameHub(controls, meter or Meter())
        self._server = Server(self._exhibit)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name="vidstyle page", daemon=True)
        try:
            self._loop.run_until_complete(self._server.open(port))
        except OSError as error:
            self._loop.close()
            reason = error.strerror or str(error)
            raise OutputError("page", f"port {port}: {reason}", "give another with --port") from error
        self.url = self._server.address
        self._thread.start()
        log.warning("page: %s", self.url)

    @property
    def state(self) -> str:
        """How many browsers look at it."""
        viewers = len(self._exhibit.viewers)
        return f"{viewers} browser{'s' * (viewers != 1)}" if viewers else "no browser"

    @property
    def error(self) -> BaseException | None:
        """Why it could not go on, which is a fault of ours, or None."""
        return self._server.error

    @property
    def delivered(self) -> int:
        """Frames that a browser has shown."""
        return self._exhibit.delivered

    @property
    def dropped(self) -> int:
        """Frames that no browser was shown, newer ones being there."""
        return self._exhibit.dropped

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._exhibit.show, frame)

    def close(self) -> None:
        """See Target."""
        if self._thread.is_alive():
            asyncio.run_coroutine_threadsafe(self._end(), self._loop)
            self._thread.join(2 * CLOSE_SECONDS)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
        finally:
            self._loop.run_until_complete(self._loop.shutdown_default_executor())
            self._loop.close()

    async def _end(self) -> None:
        await self._server.close()
        self._loop.stop()
