"""vidstyle demo: a generated film in three styles and as a comic page."""

from __future__ import annotations

from pathlib import Path

import click

from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.parsing.common_options import threads_option
from vidstyle.cli.parsing.path_arguments import PATH
from vidstyle.cli.terminal.reporting import reporting_options


@command("Generate a short film and restyle it.", examples=("vidstyle demo",))
@option("-o", "--output", "folder", type=PATH, default=Path("demo"), metavar="FOLDER", help="Output folder.")
@threads_option
@reporting_options
def demo(folder: Path) -> None:
    """Generate a short film with sound, restyle it, make a comic page, and print the names of the files."""
    from vidstyle.demo.make_demo import make_demo

    for path in make_demo(folder):
        click.echo(path)
