"""vidstyle cues: find the scenes of a film, and write a file that gives each one a style."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import style_option, threads_option
from vidstyle.cli.parsing.cue_options import (
    by_options,
    cues_option,
    refuse_with_cues,
    scenes_of,
    styles_of_scenes,
)
from vidstyle.cli.parsing.path_arguments import path_arguments
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import UsageError, counted, printable

SHEET_ENDING = ".html"


@command(
    "Find the scenes of a film, and write a cue file for them.",
    examples=(
        "vidstyle cues in.mp4 cues.toml                      # then open cues.html",
        "vidstyle cues in.mp4 cues.toml -s ink,noir --by like",
        "vidstyle cues in.mp4 cues.toml --cues cues.toml -y  # edit it again",
    ),
    epilog="Use the file with 'vidstyle render --cues'. Guide: docs/cues.md in the source folder.",
)
@path_arguments(source="INPUT", target="OUTPUT")
@style_option(help="Styles to begin with, as in ink,noir,poster.  [default: plain]")
@by_options
@cues_option("Begin with the cues of this file instead, to edit them further.")
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite OUTPUT and the page.")
@threads_option
@reporting_options
def cues(source: str, target: str, overwrite: bool, **options: Any) -> int:
    """Find the scenes of INPUT, and write OUTPUT, a cue file (.toml) that gives each scene a style.

    A page with a picture of each scene is written next to it, for choosing styles in the browser.
    """
    from vidstyle.cues.cue_file import cue_file_text, read_cue_tables, scene_cues
    from vidstyle.gallery.cue_sheet import SheetScene, cue_sheet
    from vidstyle.media.write.atomic import atomic_file
    from vidstyle.style import PLAIN

    file, page = Path(target), Path(target).with_suffix(SHEET_ENDING)
    if options["cues"] is not None:
        refuse_with_cues(options)
    if file.suffix != ".toml":
        raise UsageError(target, "is not the name of a cue file", "end it in .toml")
    with atomic_file(file, source, overwrite) as write, atomic_file(page, source, overwrite) as write_page:
        scenes, rate = scenes_of(source)
        starts = [each.start for each in scenes]
        if options["cues"] is None:
            names = {"style_name": options["style_name"] or PLAIN}
            made = scene_cues(styles_of_scenes(scenes, {**options, **names}))
        else:
            made = read_cue_tables(options["cues"], starts, file.parent)
        shown = [SheetScene(each.start, each.end, each.still) for each in scenes]
        write(cue_file_text(starts, rate, made).encode())
        write_page(cue_sheet(Path(source).name, file, shown, rate, made).encode())
    found = counted(len(scenes), "scene")
    say(f"{printable(file)}: {found}; choose styles in {printable(page)}")
    return 0
