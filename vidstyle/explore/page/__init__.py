"""The explorer's page: nine tiles of the user's own film, and one more like the one that is taken."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing

import vidstyle.web  # noqa: F401  # first of all: it says what to install if aiohttp is missing
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
) -> None:
    """Show the page until `stop` is set.

    Args:
        source: as for `open_clip`.
        stop: ends it.
        seed: of the screens: the same seed and the same clicks give the same styles.
        port: of this machine; 0 chooses a free one.
        browse: opens the page in a browser, by an address that admits only the first.
        designer: opens the designer with a style.

    Raises:
        InputError: the source cannot be read.
        OutputError: the port is taken or needs privileges.
    """
    with closing(open_clip(source)) as clip, Exploration(clip, seed) as exploration:
        with closing(ExploreServer(exploration, port, designer)) as page:
            log.warning("page: %s", page.url)
            if browse is not None:
                browse(page.one_time_url)
            while not stop.wait(0.5):
                if page.error is not None:
                    raise page.error
