"""The designer: edit styles on a local web page."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import vidstyle.web  # noqa: F401  # first, since it reports how to install a missing aiohttp
from vidstyle.design.front_door import FrontDoor
from vidstyle.style import Style, style_text


def serve(
    source: str | None,
    style: str | Style | None,
    folder: Path,
    port: int,
    device: str,
    browse: Callable[[str], None] | None,
    stop: threading.Event,
    front: FrontDoor | None = None,
) -> Iterator[str]:
    """Serve the designer until `stop` is set; yield the address of its page once it is ready.

    Args:
        source: the input, see `open_clip`.
        style: a name, a file or an unsaved style to open; None: show the start screen.
        folder: the output folder.
        port: port to listen on; 0 selects a free one.
        device: renders for browsers that cannot, see `open_renderer`.
        browse: opens the page in a browser.
        front: the ways to other pages, for the page of `vidstyle open`.

    Raises:
        VidstyleError: the input, the style or the port is invalid or unavailable.
    """
    from vidstyle.design.designer import Designer
    from vidstyle.design.drafts import Drafts
    from vidstyle.design.page import open_page
    from vidstyle.preview.clip import open_clip

    designer = Designer(open_clip(source), folder, Drafts())
    try:
        if isinstance(style, Style):
            designer.open_text(style.name, style_text(style))
        elif style is not None:
            designer.open_style(style)
        server = open_page(designer, port, device, front)
    except BaseException:
        designer.clip.close()
        raise
    try:
        yield server.url
        if browse is not None:
            browse(server.one_time_url)
        while not stop.wait(0.2):
            if server.error is not None:
                raise server.error
    finally:
        server.close()
