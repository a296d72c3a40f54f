"""vidstyle export: a style for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from vidstyle.cli.options import STYLE, change_options, parents_option, style_from_options
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable


@click.command(short_help="Write a style for a browser, or as a style file.")
@click.argument("style_name", type=STYLE, metavar="STYLE")
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
@change_options
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite OUT if it exists.")
@parents_option("target")
@reporting_options
def export(target: Path, overwrite: bool, **options: Any) -> None:
    r"""Write a style so that it runs elsewhere, without vidstyle.

    \b
    OUT.html  a page that restyles a camera, a film or a photograph in a browser
    OUT.toml  a style file with all that --set, --steady and a variant change
    """
    from vidstyle.export.export_style import export_style
    from vidstyle.style import style_file

    style = style_from_options(options)
    size = export_style(style, target, style_file(options["style_name"]), overwrite)
    say(printable(f"{target}: {style.name}, {size / 1000:.0f} kB"))
