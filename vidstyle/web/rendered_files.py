"""Rendered files, which the page plays and offers for download."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from aiohttp import web

RENDERED_PATH = "/rendered"


class RenderedFiles:
    """Serves the files that finished jobs wrote, by the number of the job; no other file can be read."""

    def __init__(self, path_of: Callable[[int], Path | None]) -> None:
        """`path_of`: returns the file of a finished job; None for other numbers."""
        self._path_of = path_of

    async def serve(self, request: web.Request) -> web.StreamResponse:
        """Respond with a file, or the range of it that is asked for; 404 for other numbers."""
        number = request.query.get("of", "")
        is_number = number.isascii() and number.isdigit() and len(number) < 10
        path = self._path_of(int(number)) if is_number else None
        if path is None:
            raise web.HTTPNotFound
        return web.FileResponse(path)
