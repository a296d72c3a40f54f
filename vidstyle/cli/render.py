"""vidstyle render: restyle a film, a picture, an image sequence or a pipe."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.display import display, progress_option
from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.configuration import configured_options
from vidstyle.cli.parsing.path_arguments import parents_option, path_arguments
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable
from vidstyle.pipeline.progress import clock

if TYPE_CHECKING:
    from vidstyle.pipeline.progress import Summary


@command(
    "Restyle a film, a picture, an image sequence or a pipe.",
    examples=(
        "vidstyle render in.mp4 out.mp4 --style comic",
        "vidstyle render in.mp4 ink.mkv -s ink:blue --start 1:20 --end 1:32 --crf 20",
        "vidstyle render 'frames/*.png' film.mp4 -s sketch --input-fps 12",
    ),
    epilog="Styles: vidstyle styles. Guide: docs/commands.md in the source folder.",
)
@path_arguments(source="INPUT", target="OUTPUT")
@common.style_options()
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite OUTPUT if it exists.")
@parents_option("target")
@option("--resume", is_flag=True, group=Group.OUTPUT, help="Continue an interrupted run that wrote OUTPUT.")
@option("--start", type=common.SECONDS, group=Group.INPUT, help="Start time, in seconds or as h:mm:ss.")
@option("--end", type=common.SECONDS, group=Group.INPUT, help="End time, as a position in INPUT.")
@option("--frames", type=common.number(1, whole=True), group=Group.OUTPUT, help="Write at most N frames.")
@option("--size", type=common.SIZE, group=Group.OUTPUT,
        help="Scale to this size; 1280x-2 keeps the aspect ratio.")  # fmt: skip
@option("--fps", type=common.RATE, group=Group.OUTPUT,
        help="Convert to a constant frame rate.  [default: keep all timestamps]")  # fmt: skip
@option("--codec", metavar="NAME", group=Group.VIDEO, help="Video encoder, such as libx265 or h264_nvenc.")
@option("--crf", type=common.number(0, 63), group=Group.VIDEO,
        help="Constant quality; a lower value gives better quality and a larger file.")  # fmt: skip
@option("--preset", metavar="NAME", group=Group.VIDEO,
        help="Encoder preset; a slower one gives a smaller file.")  # fmt: skip
@option("--pix-fmt", metavar="NAME", group=Group.VIDEO, help="Output pixel format, such as yuv420p10le.")
@option("--audio", metavar="copy|none|CODEC", default="copy", group=Group.AUDIO,
        help="Copy, drop or re-encode the audio.")  # fmt: skip
@option("--format", "file_format", metavar="NAME", group=Group.OUTPUT,
        help="Format of standard output, such as nut, y4m or raw.")  # fmt: skip
@option("--input-format", metavar="NAME", group=Group.INPUT,
        help="Format of INPUT if it cannot be detected: raw.")  # fmt: skip
@common.raw_video_options("Frame rate of raw video or an image sequence.  [default: 25]", "rate")
@option("--hwaccel", metavar="NAME", group=Group.INPUT, help="Hardware decoder, such as cuda.")
@option("--rotate", type=click.Choice(["0", "90", "180", "270"]), group=Group.INPUT,
        help="Rotate clockwise by this angle instead of the rotation stored in INPUT.")  # fmt: skip
@option("--no-autorotate", is_flag=True, group=Group.INPUT, help="Ignore the rotation stored in INPUT.")
@option("--allow-url", is_flag=True, group=Group.INPUT, help="Allow INPUT to be a URL.")
@option("--compare", type=click.Choice(["side", "split"]), group=Group.OUTPUT,
        help="Show source and result side by side, or split in the middle.")  # fmt: skip
@common.device_option()
@progress_option
@option("--json", "as_json", is_flag=True,
        help="Print a summary as JSON (on stderr if OUTPUT is -).")  # fmt: skip
@reporting_options
def render(source: str, target: str, as_json: bool, progress: str, **options: Any) -> int:
    """Restyle INPUT into OUTPUT: a film, a picture, an image sequence or a pipe (-).

    Name a sequence frames/%05d.png; as INPUT, '*.png' in quotes works too. If OUTPUT is a folder, the file
    keeps INPUT's name.
    """
    from vidstyle.media.read.reader import ReadOptions
    from vidstyle.media.write.writer import WriteOptions
    from vidstyle.pipeline.render import render as render_film
    from vidstyle.pipeline.stopping import stop_on_signals

    style, raw, rotate = common.style_from_options(options), common.raw_video(options), options["rotate"]
    turn = 0 if options["no_autorotate"] else None if rotate is None else int(rotate)
    options |= {"raw": raw, "rotate": turn, "format": options["input_format"]}
    format_out = options["file_format"] if target == "-" else None
    with stop_on_signals() as stop, display(progress) as show:
        summary = render_film(
            source,
            target,
            style,
            read=common.from_options(ReadOptions, options),
            write=common.from_options(
                WriteOptions, options, format=format_out, habitual=configured_options()
            ),
            device=options["device"],
            frames=options["frames"],
            compare=options["compare"],
            resume=options["resume"],
            on_progress=show,
            stop=stop,
        )
    _report(summary, quiet=progress == "none")
    if as_json:
        click.echo(json.dumps(summary.as_dict()), err=target == "-")
    return stop.exit_code if summary.stopped else summary.exit_code


def _report(summary: Summary, quiet: bool) -> None:
    """Report the outcome; damage and an early stop even when quiet."""
    if summary.damage:
        source = "standard input" if summary.source == "-" else printable(summary.source)
        say(f"{source}: {summary.damage}")
    target = "standard output" if summary.target == "-" else printable(summary.target)
    text = ""
    if summary.stopped:
        kept = f"; {printable(summary.partial)} keeps what was done" if summary.partial else ""
        text = f"{target}: stopped before its end{kept}"
    elif summary.frames and not quiet:
        pace = f"{summary.rate:.3g} fps" if summary.elapsed else ""
        number = summary.frames - summary.kept
        made = f"{number}{' more' if summary.kept else ''} frame{'s' if number != 1 else ''}"
        text = f"{target}: {made} in {clock(summary.elapsed)}, {pace}"
    say(text, summary.as_dict())
