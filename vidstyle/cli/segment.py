"""vidstyle segment: restyle a segment of a long film, for `batch` and render farms."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import SECONDS, style_option
from vidstyle.cli.parsing.cue_options import by_options, cues_option, look_from_options, turns_of_film
from vidstyle.cli.parsing.film_options import film_options, read_options, write_options
from vidstyle.cli.parsing.path_arguments import PATH, path_arguments
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import event, reporting_options
from vidstyle.core.machine.cores import available_cores
from vidstyle.errors import UsageError, log


@command(
    "Restyle a segment of a long film.",
    examples=(
        "vidstyle segment in.mp4 out.mp4 -s ink --threads 1 --every 30  # prints ranges",
        "vidstyle segment in.mp4 out.mp4 -s ink --threads 1 --range 0:720",
        "vidstyle segment in.mp4 out.mp4 -s ink --threads 1 --join",
    ),
    epilog="'vidstyle batch --segment' does all of this. Guide: docs/batch.md in the source folder.",
)
@path_arguments(source="INPUT", target="OUTPUT")
@style_option()
@cues_option()
@by_options
@film_options
@option("--every", type=SECONDS, group=Group.OUTPUT,
        help="Find the scene cuts, and plan segments of at least this length.")  # fmt: skip
@option("--range", "name", metavar="A:B", group=Group.OUTPUT,
        help="Restyle the segment from frame A to frame B, excluding B.")  # fmt: skip
@option("--join", is_flag=True, group=Group.OUTPUT, help="Join the finished segments into OUTPUT.")
@option("--scratch", type=PATH, metavar="FOLDER", group=Group.OUTPUT,
        help="Folder for the plan and the segments.  [default: .OUTPUT.segments]")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite OUTPUT if it exists.")
@progress_option
@reporting_options
def segment(source: str, target: str, progress: str, scratch: Path | None, **options: Any) -> int:
    """Restyle INPUT in segments on any number of machines, and join them to OUTPUT.

    First run it with --every, then with --range for each segment, and finally with --join. All other options
    must be the same.
    """
    from vidstyle.cues.rotation import StyleRotation
    from vidstyle.pipeline.resume import setting_parts
    from vidstyle.pipeline.segments import SegmentedFilm
    from vidstyle.pipeline.stopping import stop_on_signals

    if (options["every"] is not None) + bool(options["name"]) + options["join"] != 1:
        raise UsageError("segment", "needs one of --every, --range and --join")
    if options["every"] == 0:
        raise UsageError("--every", "0 is not a length", "give seconds, such as 30")
    if options["frames"] is not None:
        raise UsageError("--frames", "cannot be used with segments", "use --end")
    look, read, write = look_from_options(options), read_options(options), write_options(options)
    device, compare = options["device"], options["compare"]
    more = {"device": device, "compare": compare, "threads": available_cores()}
    parts = setting_parts(look, read, write, **more)
    folder = scratch or Path(target).with_name(f".{Path(target).name}.segments")
    if scratch is None and folder.is_symlink():
        raise UsageError(folder, "is a link, which is not followed", "name another folder with --scratch")
    folder.mkdir(parents=True, exist_ok=True)
    film = SegmentedFilm(Path(source), Path(target), folder, look, read, write, device, compare, parts)
    with stop_on_signals() as stop, display(progress) as show:
        if options["every"]:
            turns = turns_of_film(source, look, read) if isinstance(look, StyleRotation) else []
            plan = film.plan(options["every"], show, stop, turns)
            if plan.undivided:
                log.info("%s has no segments: it %s; use 'vidstyle render'", source, plan.undivided)
            click.echo(json.dumps([each.name for each in plan.segments if not plan.undivided]))
            return 0
        work = (
            film.join(options["overwrite"], stop)
            if options["join"]
            else film.render(options["name"], show, stop)
        )
    event("summary", work.as_dict())
    return stop.exit_code if work.stopped else work.exit_code
