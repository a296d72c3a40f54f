"""vidstyle render: restyle a film, a picture, an image sequence or a pipe."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli import options as common
from vidstyle.cli.configuration import configured_options
from vidstyle.cli.display import display, progress_option
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable
from vidstyle.pipeline.progress import clock

if TYPE_CHECKING:
    from vidstyle.pipeline.progress import Summary


@click.command(short_help="Restyle a film, a picture, an image sequence or a pipe.")
@common.path_arguments(source="INPUT", target="OUTPUT")
@common.style_options()
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite OUTPUT if it exists.")
@common.parents_option("target")
@click.option("--resume", is_flag=True, help="Continue what an interrupted run has left of OUTPUT.")
@click.option("--start", type=common.SECONDS, help="Start time, in seconds or as h:mm:ss.")
@click.option("--end", type=common.SECONDS, help="End time.")
@click.option("--frames", type=common.number(1, whole=True), help="Write at most N frames.")
@click.option("--size", type=common.SIZE, help="Scale to this size; 1280x-2 keeps the aspect ratio.")
@click.option("--fps", type=common.RATE,
              help="Constant frame rate; by default all frames keep their timestamps.")  # fmt: skip
@click.option("--codec", metavar="NAME", help="Video encoder, such as libx265 or h264_nvenc.")
@click.option("--crf", type=common.number(0, 63), help="Quality; lower is better and larger.")
@click.option("--preset", metavar="NAME", help="Encoder preset: speed against compression.")
@click.option("--pix-fmt", metavar="NAME", help="Output pixel format, such as yuv420p10le.")
@click.option("--audio", metavar="copy|none|CODEC", default="copy", help="Copy, drop or re-encode the audio.")
@click.option("--format", "file_format", metavar="NAME",
              help="Format of OUTPUT on '-', such as nut, y4m or raw.")  # fmt: skip
@click.option("--input-format", metavar="NAME",
              help="Format of INPUT where its content does not tell: raw.")  # fmt: skip
@common.raw_video_options("Frame rate of raw video or an image sequence.  [default: 25]", "rate")
@click.option("--hwaccel", metavar="NAME", help="Hardware decoder, such as cuda.")
@click.option("--rotate", type=click.Choice(["0", "90", "180", "270"]),
              help="Rotate clockwise by this angle, ignoring the rotation in the file.")  # fmt: skip
@click.option("--no-autorotate", is_flag=True, help="Ignore the rotation in the file.")
@click.option("--allow-url", is_flag=True, help="Allow INPUT to be a URL.")
@click.option("--compare", type=click.Choice(["side", "split"]),
              help="Show source and result side by side, or split in the middle.")  # fmt: skip
@common.device_option()
@progress_option
@click.option("--json", "as_json", is_flag=True,
              help="Print a summary as JSON (on stderr when OUTPUT is '-').")  # fmt: skip
@reporting_options
def render(source: str, target: str, as_json: bool, progress: str, **options: Any) -> int:
    """Restyle INPUT into OUTPUT: a film, a picture, an image sequence or a pipe (-).

    A sequence is named by %05d.png, as INPUT by '*.png' in quotes too. A folder as OUTPUT takes a file of
    INPUT's name.
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
