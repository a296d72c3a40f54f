"""vidstyle render: restyle a film, a picture, an image sequence or a pipe."""

from __future__ import annotations

import glob
import json
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import style_option
from vidstyle.cli.parsing.cue_options import by_options, cues_option, look_from_options, look_of_film
from vidstyle.cli.parsing.film_options import film_options, read_options, write_options
from vidstyle.cli.parsing.path_arguments import parents_option, path_arguments
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import InputError, UsageError, printable
from vidstyle.pipeline.progress import clock

if TYPE_CHECKING:
    from vidstyle.pipeline.progress import Summary

SEVERAL_FILMS = "restyle several films with 'vidstyle batch'"


@command(
    "Restyle a film, a picture, an image sequence or a pipe.",
    examples=(
        "vidstyle render in.mp4 out.mp4 --style comic",
        "vidstyle render in.mp4 ink.mkv -s ink:blue --start 1:20 --end 1:32 --crf 20",
        "vidstyle render 'frames/*.png' film.mp4 -s sketch --input-fps 12",
    ),
    epilog="Styles: vidstyle styles. Guide: docs/commands.md in the source folder.",
)
@path_arguments(SEVERAL_FILMS, source="INPUT", target="OUTPUT")
@style_option()
@cues_option()
@by_options
@film_options
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite OUTPUT if it exists.")
@parents_option("target")
@option("--resume", is_flag=True, group=Group.OUTPUT, help="Continue an interrupted run that wrote OUTPUT.")
@option("--format", "file_format", metavar="NAME", group=Group.OUTPUT,
        help="Format of standard output, such as nut, y4m or raw.")  # fmt: skip
@option("--allow-url", is_flag=True, group=Group.INPUT, help="Allow INPUT to be a URL.")
@progress_option
@option("--json", "as_json", is_flag=True,
        help="Print a summary as JSON (on stderr if OUTPUT is -).")  # fmt: skip
@reporting_options
def render(source: str, target: str, as_json: bool, progress: str, **options: Any) -> int:
    """Restyle INPUT into OUTPUT: a film, a picture, an image sequence or a pipe (-).

    Name a sequence frames/%05d.png; as INPUT, '*.png' in quotes works too. If OUTPUT is a folder, the file
    keeps INPUT's name.
    """
    from vidstyle.media.read.open import redact_url
    from vidstyle.media.storage import is_stored
    from vidstyle.pipeline.render import render as render_film
    from vidstyle.pipeline.resume import setting_parts
    from vidstyle.pipeline.stopping import stop_on_signals
    from vidstyle.pipeline.stored_film import StoredFilm

    _refuse_several(source)
    format_out = options["file_format"] if target == "-" else None
    is_stored_film = is_stored(source) or is_stored(target)
    if is_stored(source) and options["by"] is not None:
        raise UsageError("--by", "needs a film on this machine", "copy it, or give --cues")
    read, write = read_options(options), write_options(options, format_out)
    style = look_of_film(source, look_from_options(options), read)
    more = {name: options[name] for name in ("device", "frames", "compare")}

    def run(source: str, target: str) -> Summary:
        return render_film(
            source,
            target,
            style,
            read=read,
            write=write,
            **more,
            resume=options["resume"],
            on_progress=show,
            stop=stop,
        )

    with stop_on_signals() as stop, display(progress) as show:
        if is_stored_film:
            film = StoredFilm(source, target, options["overwrite"])
            with film.local_names(setting_parts(style, read, write, **more), stop) as names:
                summary = run(*names)
                if not summary.stopped:
                    film.put()
            summary = replace(summary, source=redact_url(film.source), target=redact_url(film.target))
        else:
            summary = run(source, target)
    _report(summary, quiet=progress == "none")
    if as_json:
        click.echo(json.dumps(summary.as_dict()), err=target == "-")
    return stop.exit_code if summary.stopped else summary.exit_code


def _refuse_several(source: str) -> None:
    """Raise an error for a folder, or a pattern that matches films: those are for `batch`."""
    if os.path.isdir(source):
        remedy = (
            f"restyle its films with 'vidstyle batch', or name a pattern such as '{source.rstrip('/')}/*.png'"
        )
        raise InputError(source.rstrip("/"), "is a folder", remedy)
    if glob.has_magic(source) and not os.path.lexists(source):
        from vidstyle.batch.inputs import is_film_name

        if any(is_film_name(os.path.basename(name)) for name in glob.iglob(source)):
            raise UsageError(source, "matches films", SEVERAL_FILMS)


def _report(summary: Summary, quiet: bool) -> None:
    """Report the outcome; damage and an early stop even when quiet."""
    if summary.damage:
        source = "standard input" if summary.source == "-" else printable(summary.source)
        say(f"{source}: {summary.damage}")
    target = "standard output" if summary.target == "-" else printable(summary.target)
    text = ""
    if summary.stopped:
        kept = f"; {printable(summary.partial)} keeps the finished part" if summary.partial else ""
        text = f"{target}: stopped before its end{kept}"
    elif summary.frames and not quiet:
        pace = f"{summary.rate:.3g} fps" if summary.elapsed else ""
        number = summary.frames - summary.kept
        made = f"{number}{' more' if summary.kept else ''} frame{'s' if number != 1 else ''}"
        text = f"{target}: {made} in {clock(summary.elapsed)}, {pace}"
    say(text, summary.as_dict())
