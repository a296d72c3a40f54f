"""vidstyle design: build a style out of blocks on a page."""

from __future__ import annotations

from pathlib import Path

import click

from vidstyle.cli import browser
from vidstyle.cli import options as common
from vidstyle.cli.reporting import reporting_options, say


@click.command(short_help="Build a style out of blocks on a page in the browser.")
@click.argument("source", metavar="[INPUT]", required=False)
@click.option("-s", "--style", type=common.STYLE, help="Name of a style or a file to open.")
@click.option("--port", type=common.number(0, 65535, whole=True), default=0, show_default=False,
              help="Port of the page.  [default: any free port]")  # fmt: skip
@browser.open_option
@common.device_option()
@reporting_options
def design(source: str | None, style: str | None, port: int, no_open: bool, device: str) -> int:
    """Build a style on a page that shows INPUT restyled: a film, a photograph, a folder or a camera.

    INPUT is as for render and live, "camera" for the first camera; without it a short demo film is shown.
    Files are saved in this folder, or beside the style's own file. Ends with Ctrl-C.
    """
    from vidstyle.design import serve
    from vidstyle.pipeline.stopping import stop_on_signals

    browse = browser.open_page if browser.is_wanted(no_open) else None
    with stop_on_signals() as stop:
        for url in serve(source, style, Path.cwd(), port, device, browse, stop):
            say(f"page: {url}")
    return stop.exit_code
