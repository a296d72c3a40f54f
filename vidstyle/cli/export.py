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
from vidstyle.cli.parsing.path_arguments import PATH, PATH_TEXT, parents_option
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import counted, printable
from vidstyle.export.export_targets import EXPORT_TARGETS, film_targets
from vidstyle.pipeline.progress import StepProgress


def _help() -> str:
    kinds = "\n\n".join(f"OUT.{kind}: {target.help}." for kind, target in EXPORT_TARGETS.items())
    return f"Write a style that runs without vidstyle.\n\n{kinds}".replace("`", "")


@command(
    "Write a style for a browser, mpv or FFmpeg, or as a style file.",
    help=_help(),
    examples=[
        f"vidstyle export ink {target.example:<25} # {target.title.lower()}"
        for target in EXPORT_TARGETS.values()
    ]
    + ["vidstyle export --all looks                   # all styles on one page"],
)
@click.argument("style_name", type=STYLE, metavar="STYLE", required=False)
@click.argument("target", metavar="OUT", type=PATH, required=False)
@change_options
@option("--from", "film", type=PATH, metavar="FILM", group=Group.OUTPUT,
        help=f"For {film_targets()}: take measurements and size from this film.")  # fmt: skip
@option("--size", type=SIZE, callback=both_sides, group=Group.OUTPUT,
        help=f"For {film_targets()}: size of the pictures.")  # fmt: skip
@option("--all", "folder", type=PATH, metavar="FOLDER", group=Group.OUTPUT,
        help="Instead of OUT, write a page of all styles, also your own, to FOLDER/index.html.")  # fmt: skip
@option("--example", "examples", type=PATH_TEXT, metavar="PICTURE", multiple=True, group=Group.OUTPUT,
        help="For --all: a photograph or film to start with; repeat for several.")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite existing files.")
@parents_option("target", "folder")
@threads_option
@progress_option
@reporting_options
def export(
    target: Path | None, overwrite: bool, film: Path | None, size: tuple[int, int] | None,
    folder: Path | None, examples: tuple[str, ...], progress: str, **options: Any,
) -> None:  # fmt: skip
    """Write a style to OUT, see `_help`."""
    given = [options["style_name"], target]
    if folder is not None:
        if any(given) or film or size:
            raise click.UsageError("--all exports every style; remove STYLE, OUT, --from and --size")
        return _export_all(folder, examples, overwrite, progress, options)
    if examples:
        raise click.UsageError("--example needs --all FOLDER")
    if target is None:
        raise click.UsageError("STYLE and OUT are missing" if given[0] is None else "OUT is missing")
    from vidstyle.export.export_style import export_style
    from vidstyle.style import style_file

    style = style_from_options(options)
    count = export_style(style, target, style_file(options["style_name"]), overwrite, film, size)
    say(printable(f"{target}: {count / 1000:.0f} kB"))


def _export_all(
    folder: Path, examples: tuple[str, ...], overwrite: bool, progress: str, options: dict[str, Any]
) -> None:
    from vidstyle.gallery.showcase import default_example, read_example, write_showcase
    from vidstyle.style import PLAIN, style_names

    names = [name for name in style_names() if name != PLAIN]
    styles = [style_from_options(options | {"style_name": name}) for name in names]
    pictures = [read_example(Path(name)) for name in examples] or [default_example()]
    with display(progress) as show:
        count = write_showcase(folder, styles, pictures, "vidstyle", overwrite, StepProgress(show))
    say(printable(f"{folder / 'index.html'}: {counted(len(styles), 'look')}, {count / 1e6:.1f} MB"))
