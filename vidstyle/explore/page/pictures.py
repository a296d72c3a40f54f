"""HTTP handlers for the pictures of the page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from aiohttp import web

from vidstyle.errors import UsageError
from vidstyle.explore.choosing.tile_screen import Tile
from vidstyle.explore.page.exploration import Exploration
from vidstyle.web.page_server import jpeg_response
from vidstyle.web.server import Handler

PICTURE_SIDES_PX = (180, 270, 360, 540, 720, 1080)
"""Sizes of pictures that the page may request: the shorter side."""


def picture_handlers(exploration: Exploration) -> dict[str, Handler]:
    """Return handlers for JPEG pictures by path; unknown pictures give 404."""
    pictures = _Pictures(exploration)
    return {
        "/glance.jpg": pictures.glance,
        "/frame.jpg": pictures.frame,
        "/tile.jpg": pictures.tile,
        "/look.jpg": pictures.look,
        "/pad.jpg": pictures.pad,
        "/tuned.jpg": pictures.tuned,
        "/tried.jpg": pictures.tried,
        "/reference.jpg": pictures.reference,
    }


class _Pictures:
    def __init__(self, exploration: Exploration) -> None:
        self._exploration = exploration

    async def glance(self, request: web.Request) -> web.StreamResponse:
        return jpeg_response(self._exploration.glance)

    async def reference(self, request: web.Request) -> web.StreamResponse:
        references = self._exploration.references
        return jpeg_response(references[_number(request, "number", len(references))])

    async def tried(self, request: web.Request) -> web.StreamResponse:
        tries = self._exploration.tries
        return jpeg_response(tries[_number(request, "number", len(tries))])

    async def frame(self, request: web.Request) -> web.StreamResponse:
        frame = _number(request, "frame", self._exploration.clip.count)
        return jpeg_response(await asyncio.to_thread(self._exploration.source, frame, _side(request)))

    async def tile(self, request: web.Request) -> web.StreamResponse:
        frame = _number(request, "frame", self._exploration.clip.count)
        style = self._tile(request).style
        opened = "opened" in request.query
        future = await self._or_nothing(self._exploration.styled, style, frame, _side(request), opened)
        return jpeg_response(await asyncio.wrap_future(future))

    async def look(self, request: web.Request) -> web.StreamResponse:
        self._tile(request)
        return jpeg_response(await asyncio.to_thread(self._exploration.look, _number(request, "tile")))

    async def pad(self, request: web.Request) -> web.StreamResponse:
        self._tile(request)
        return jpeg_response(await self._or_nothing(self._exploration.pad_picture, _number(request, "tile")))

    async def tuned(self, request: web.Request) -> web.StreamResponse:
        self._tile(request)
        pad = await self._or_nothing(self._exploration.pad, _number(request, "tile"))
        style = pad.style_at(_part(request, "x"), _part(request, "y"))
        frame = _number(request, "frame", self._exploration.clip.count)
        future = await self._or_nothing(self._exploration.styled, style, frame, _side(request), True)
        return jpeg_response(await asyncio.wrap_future(future))

    def _tile(self, request: web.Request) -> Tile:
        try:
            return self._exploration.tile(_number(request, "tile"))
        except UsageError as error:
            raise web.HTTPNotFound from error

    async def _or_nothing(self, function: Callable[..., Any], *arguments: object) -> Any:
        try:
            return await asyncio.to_thread(function, *arguments)
        except UsageError as error:
            raise web.HTTPNotFound from error


def _number(request: web.Request, name: str, count: int = 2**31) -> int:
    text = request.query.get(name, "")
    if not (text.isascii() and text.isdigit() and len(text) < 10 and int(text) < count):
        raise web.HTTPNotFound
    return int(text)


def _side(request: web.Request) -> int:
    side = _number(request, "side")
    if side not in PICTURE_SIDES_PX:
        raise web.HTTPNotFound
    return side


def _part(request: web.Request, name: str) -> float:
    """A number from 0 to 1."""
    try:
        part = float(request.query.get(name, ""))
    except ValueError:
        raise web.HTTPNotFound from None
    if not 0 <= part <= 1:
        raise web.HTTPNotFound
    return part
