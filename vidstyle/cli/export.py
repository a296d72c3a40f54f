"""vidstyle export: a style for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from vidstyle.cli.bench import both_sides
from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.parsing.common_options import (
    SIZE,
    STYLE,
    change_options,
    style_from_options,
    threads_option,
)
from vidstyle.cli.parsing.path_arguments import PATH, parents_option
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable


@command(
    "Write a style for a browser, mpv or FFmpeg, or as a style file.",
    examples=(
        "vidstyle export ink ink.html                 # page for a browser",
        "vidstyle export ink ink.hook --size 1280x720 # shader for a player",
        "vidstyle export ink my-ink.toml --steady 0.8 # style file",
    ),
)
@click.argument("style_name", type=STYLE, metavar="STYLE")
@click.argument("target", metavar="OUT", type=PATH)
@change_options
@option("--from", "film", type=PATH, metavar="FILM",
        help="For OUT.hook: take measurements and size from this film.")  # fmt: skip
@option("--size", type=SIZE, callback=both_sides, help="For OUT.hook: size of the pictures.")
@option("-y", "--overwrite", is_flag=True, help="Overwrite OUT if it exists.")
@parents_option("target")
@threads_option
@reporting_options
def export(
    target: Path, overwrite: bool, film: Path | None, size: tuple[int, int] | None, **options: Any
) -> None:
    """Write a style that runs without vidstyle.

    OUT.html is a page for the browser, OUT.hook a shader for mpv, FFmpeg (libplacebo) and other libplacebo
    players, and OUT.toml a style file that includes the changes made by options and variants.
    """
    from vidstyle.export.export_style import export_style
    from vidstyle.style import style_file

    style = style_from_options(options)
    count = export_style(style, target, style_file(options["style_name"]), overwrite, film, size)
    say(printable(f"{target}: {count / 1000:.0f} kB"))
