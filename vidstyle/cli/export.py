"""vidstyle export: a style for other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from vidstyle.cli.bench import both_sides
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import (
    SIZE,
    STYLE,
    change_options,
    style_from_options,
    threads_option,
)
from vidstyle.cli.parsing.path_arguments import PATH, parents_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import printable
from vidstyle.export.export_targets import EXPORT_TARGETS, film_targets


def _help() -> str:
    kinds = "\n\n".join(f"OUT.{kind}: {target.help}." for kind, target in EXPORT_TARGETS.items())
    return f"Write a style that runs without vidstyle.\n\n{kinds}".replace("`", "")


@command(
    "Write a style for a browser, mpv or FFmpeg, or as a style file.",
    help=_help(),
    examples=[
        f"vidstyle export ink {target.example:<25} # {target.title.lower()}"
        for target in EXPORT_TARGETS.values()
    ],
)
@click.argument("style_name", type=STYLE, metavar="STYLE")
@click.argument("target", metavar="OUT", type=PATH)
@change_options
@option("--from", "film", type=PATH, metavar="FILM", group=Group.OUTPUT,
        help=f"For {film_targets()}: take measurements and size from this film.")  # fmt: skip
@option("--size", type=SIZE, callback=both_sides, group=Group.OUTPUT,
        help=f"For {film_targets()}: size of the pictures.")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite OUT if it exists.")
@parents_option("target")
@threads_option
@reporting_options
def export(
    target: Path, overwrite: bool, film: Path | None, size: tuple[int, int] | None, **options: Any
) -> None:
    """Write a style to OUT, see `_help`."""
    from vidstyle.export.export_style import export_style
    from vidstyle.style import style_file

    style = style_from_options(options)
    count = export_style(style, target, style_file(options["style_name"]), overwrite, film, size)
    say(printable(f"{target}: {count / 1000:.0f} kB"))
