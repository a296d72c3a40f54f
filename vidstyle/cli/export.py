"""vidstyle export: a style for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from vidstyle.cli.bench import both_sides
from vidstyle.cli.options import SIZE, STYLE, change_options, parents_option, style_from_options
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable


@click.command(short_help="Write a style for a browser, mpv or FFmpeg, or as a style file.")
@click.argument("style_name", type=STYLE, metavar="STYLE")
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
@change_options
@click.option("--from", "film", type=click.Path(path_type=Path), metavar="FILM",
              help="For OUT.hook: freeze what is measured, and the size, as in this film.")  # fmt: skip
@click.option("--size", type=SIZE, callback=both_sides, help="For OUT.hook: the size of the pictures.")
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite OUT if it exists.")
@parents_option("target")
@reporting_options
def export(
    target: Path, overwrite: bool, film: Path | None, size: tuple[int, int] | None, **options: Any
) -> None:
    r"""Write a style so that it runs elsewhere, without vidstyle.

    \b
    OUT.html  a page that restyles a camera, a film or a photograph in a browser
    OUT.hook  a shader for mpv, FFmpeg (libplacebo) and other players
    OUT.toml  a style file with all that --set, --steady and a variant change
    """
    from vidstyle.export.export_style import export_style
    from vidstyle.style import style_file

    style = style_from_options(options)
    count = export_style(style, target, style_file(options["style_name"]), overwrite, film, size)
    say(printable(f"{target}: {count / 1000:.0f} kB"))
