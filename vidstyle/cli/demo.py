"""vidstyle demo: a generated film in three styles and as a comic page."""

from __future__ import annotations

from pathlib import Path

import click

from vidstyle.cli.reporting import reporting_options


@click.command(short_help="Generate a short film and restyle it.")
@click.option("-o", "--output", "folder", type=click.Path(path_type=Path), default=Path("demo"),
              metavar="FOLDER", help="Output folder.")  # fmt: skip
@reporting_options
def demo(folder: Path) -> None:
    """Generate a short film with sound, restyle it, make a comic page, and print the files' names."""
    from vidstyle.demo.make_demo import make_demo

    for path in make_demo(folder):
        click.echo(path)
