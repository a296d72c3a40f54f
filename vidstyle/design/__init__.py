"""The designer: a style built out of blocks on a page of this machine."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import vidstyle.web  # noqa: F401  # first of all: it says what to install if aiohttp is missing
from vidstyle.style import Style, style_text


def serve(
    source: str | None,
    style: str | Style | None,
    folder: Path,
    port: int,
    device: str,
    browse: Callable[[str], None] | None,
    stop: threading.Event,
) -> Iterator[str]:
    """Serve the designer until `stop` is set; yields the address of its page once it is there.

    Args:
        source: what is restyled, as for `open_clip`.
        style: what to open: a name or a file, or a style that is not saved yet; None: the page begins with a
            choice.
        folder: where files are written.
        port: of this machine; 0 chooses a free one.
        device: which restyles for browsers that cannot, as for `open_renderer`.
        browse: opens the page in a browser.

    Raises:
        VidstyleError: the input, the style or the port cannot be used.
    """
    from vidstyle.design.designer import Designer
    from vidstyle.design.drafts import Drafts
    from vidstyle.design.page.design_server import DesignServer
    from vidstyle.preview.clip import open_clip

    designer = Designer(open_clip(source), folder, Drafts())
    try:
        if isinstance(style, Style):
            designer.open_text(style.name, style_text(style))
        elif style is not None:
            designer.open_style(style)
        server = DesignServer(designer, port, device)
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
