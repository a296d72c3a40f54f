"""Wakes all tasks of one loop that wait for something new."""

from __future__ import annotations

import asyncio


class News:
    """Something that happens again and again; only for tasks of one loop."""

    def __init__(self) -> None:
        self._next = asyncio.Event()

    def tell(self) -> None:
        """It has happened: wake all who wait."""
        told, self._next = self._next, asyncio.Event()
        told.set()

    async def wait(self) -> None:
        """Wait until it happens."""
        await self._next.wait()

    async def wait_for(self, seconds: float) -> None:
        """Wait until it happens, but no longer than this."""
        try:
            await asyncio.wait_for(self._next.wait(), seconds)
        except TimeoutError:
            pass
