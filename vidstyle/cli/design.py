"""vidstyle design: build a style out of blocks on a page."""

from __future__ import annotations

from pathlib import Path

import click

from vidstyle.cli import browser
from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.terminal.reporting import reporting_options, say


@command(
    "Build a style out of blocks on a page in the browser.",
    examples=("vidstyle design in.mp4", "vidstyle design camera --style comic"),
)
@click.argument("source", metavar="[INPUT]", required=False)
@option("-s", "--style", type=common.STYLE, help="Name of a style, or a style file, to open.")
@browser.port_option
@browser.open_option
@common.device_option()
@reporting_options
def design(source: str | None, style: str | None, port: int, no_open: bool, device: str) -> int:
    """Build a style on a page that shows INPUT restyled: a film, a photograph, a folder or a camera.

    INPUT is a source of render or live, such as camera, the first camera. Without INPUT the page shows a
    short demo film. Files are saved in the current folder, or next to the style's own file. Press Ctrl-C to
    stop.
    """
    from vidstyle.design import serve
    from vidstyle.pipeline.stopping import stop_on_signals

    browse = browser.open_page if browser.is_wanted(no_open) else None
    with stop_on_signals() as stop:
        for url in serve(source, style, Path.cwd(), port, device, browse, stop):
            say(f"page: {url}")
    return stop.exit_code
