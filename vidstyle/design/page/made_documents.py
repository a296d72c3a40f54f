"""Documents that the front page had made, such as comics, which the browser shows."""

from __future__ import annotations

from pathlib import Path

from aiohttp import web

from vidstyle.web.server import DOCUMENT_POLICY

DOCUMENT_PATH = "/document"
SHOWN_SUFFIX = ".html"


class MadeDocuments:
    """Serves documents that this program wrote, by number; no other file can be read."""

    def __init__(self) -> None:
        self._paths: list[Path] = []

    def add(self, path: Path) -> str:
        """Return the address of a document; "" if browsers do not show its type."""
        if path.suffix != SHOWN_SUFFIX:
            return ""
        self._paths.append(path)
        return f"{DOCUMENT_PATH}?of={len(self._paths)}"

    async def serve(self, request: web.Request) -> web.StreamResponse:
        """Respond with a document; 404 for other numbers, and for a document that was removed."""
        known = {str(number): path for number, path in enumerate(self._paths, 1)}
        path = known.get(request.query.get("of", ""))
        if path is None or not path.is_file():
            raise web.HTTPNotFound
        return web.FileResponse(path, headers={"Content-Security-Policy": DOCUMENT_POLICY})
