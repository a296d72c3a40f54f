"""The page of the explorer: nine styles of the user's film, and nine more like the chosen one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import vidstyle.web  # noqa: F401  # first, since it reports how to install a missing aiohttp
from vidstyle.errors import log
from vidstyle.explore.page.exploration import Exploration
from vidstyle.explore.page.explore_server import ExploreServer, OpenDesigner
from vidstyle.preview.clip import open_clip

__all__ = ["explore"]


def explore(
    source: str | None,
    *,
    stop: threading.Event,
    seed: int = 0,
    port: int = 0,
    browse: Callable[[str], None] | None = None,
    designer: OpenDesigner | None = None,
    reveal: Callable[[Path], None] | None = None,
) -> None:
    """Serve the page until `stop` is set.

    Args:
        source: the input, see `open_clip`.
        stop: ends the server when set.
        seed: random seed; the same seed and clicks give the same styles.
        port: port to listen on; 0 selects a free one.
        browse: opens a one-time URL of the page in a browser.
        designer: opens the designer with a style.
        reveal: shows a file in its folder; None without a desktop.

    Raises:
        InputError: the source cannot be read.
        OutputError: the port is taken or needs privileges.
    """
    with closing(open_clip(source)) as clip, Exploration(clip, seed) as exploration:
        with closing(ExploreServer(exploration, port, designer, reveal)) as page:
            log.warning("page: %s", page.url)
            if browse is not None:
                browse(page.one_time_url)
            while not stop.wait(0.5):
                if page.error is not None:
                    raise page.error
