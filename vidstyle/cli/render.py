"""vidstyle render: restyle a film, a picture, an image sequence or a pipe."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.display import KINDS, clock, display
from vidstyle.cli.options import Rate, Seconds, Size, raw_video, raw_video_options
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import printable

if TYPE_CHECKING:
    from vidstyle.media.read.reader import ReadOptions
    from vidstyle.media.write.writer import WriteOptions
    from vidstyle.pipeline.progress import Summary


@click.command(short_help="Restyle a film, a picture, an image sequence or a pipe.")
@click.argument("source", metavar="INPUT")
@click.argument("target", metavar="OUTPUT")
@click.option("--style", "style_name", metavar="NAME", required=True, help="Name of a style or a file.")
@click.option("--set", "changes", metavar="STEP.PARAMETER=VALUE", multiple=True,
              help="Override a style parameter; may be repeated.")  # fmt: skip
@click.option("--steady", type=click.FloatRange(0, 1), metavar="S",
              help="Temporal smoothing, from 0 (off) to 1 (strongest).  [default: the style's]")  # fmt: skip
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite OUTPUT if it exists.")
@click.option("--start", type=Seconds(), help="Start time, in seconds or as h:mm:ss.")
@click.option("--end", type=Seconds(), help="End time.")
@click.option("--frames", type=click.IntRange(min=1), metavar="N", help="Write at most N frames.")
@click.option("--size", type=Size(), help="Scale to this size; 1280x-2 keeps the aspect ratio.")
@click.option("--fps", type=Rate(), help="Constant frame rate; by default all frames keep their timestamps.")
@click.option("--codec", metavar="NAME", help="Video encoder, such as libx265 or h264_nvenc.")
@click.option("--crf", type=click.FloatRange(0, 63), metavar="Q", help="Quality; lower is better and larger.")
@click.option("--preset", metavar="NAME", help="Encoder preset: speed against compression.")
@click.option("--pix-fmt", metavar="NAME", help="Output pixel format, such as yuv420p10le.")
@click.option("--audio", metavar="copy|none|CODEC", default="copy", show_default=True,
              help="Copy, drop or re-encode the audio.")  # fmt: skip
@click.option("--format", "file_format", metavar="NAME",
              help="Container format on '-', such as nut or yuv4mpegpipe.")  # fmt: skip
@raw_video_options("Frame rate of raw video or an image sequence.  [default: 25]")
@click.option("--hwaccel", metavar="NAME", help="Hardware decoder, such as cuda.")
@click.option("--rotate", type=click.Choice(["0", "90", "180", "270"]),
              help="Rotate clockwise by this angle, ignoring the rotation in the file.")  # fmt: skip
@click.option("--no-autorotate", is_flag=True, help="Ignore the rotation in the file.")
@click.option("--allow-url", is_flag=True, help="Allow INPUT to be a URL.")
@click.option("--compare", type=click.Choice(["side", "split"]),
              help="Show source and result side by side, or split in the middle.")  # fmt: skip
@click.option("--device", metavar="auto|cpu|gpu|gpu:N", default="auto", show_default=True,
              help="Device that runs the style.")  # fmt: skip
@click.option("--progress", type=click.Choice(KINDS), default="auto", show_default=True,
              help="How to report progress on stderr.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True,
              help="Print a summary as JSON (on stderr when OUTPUT is '-').")  # fmt: skip
@reporting_options
def render(source: str, target: str, as_json: bool, progress: str, **options: Any) -> int:
    """Restyle INPUT into OUTPUT: a film, a picture, an image sequence (%05d.png) or a pipe (-)."""
    from vidstyle.pipeline.render import render as render_film
    from vidstyle.pipeline.stopping import stop_on_signals
    from vidstyle.style import load_style, override, set_values

    style = override(load_style(options["style_name"]), options["changes"])
    if options["steady"] is not None:
        style = set_values(style, {"steady": options["steady"]})
    with stop_on_signals() as stop, display(progress) as show:
        summary = render_film(
            source,
            target,
            style,
            read=_read_options(options, source == "-"),
            write=_write_options(options, target == "-"),
            device=options["device"],
            frames=options["frames"],
            compare=options["compare"],
            on_progress=show,
            stop=stop,
        )
    _report(summary, quiet=progress in ("json", "none"))
    if as_json:
        click.echo(json.dumps(summary.as_dict()), err=target == "-")
    return stop.exit_code if summary.stopped else summary.exit_code


def _read_options(options: dict[str, Any], piped: bool) -> ReadOptions:
    from vidstyle.media.read import reader

    rotate = options["rotate"]
    return reader.ReadOptions(
        start=options["start"],
        end=options["end"],
        size=options["size"],
        fps=options["fps"],
        rate=options["input_fps"],
        raw=raw_video(options),
        hwaccel=options["hwaccel"],
        rotate=0 if options["no_autorotate"] else None if rotate is None else int(rotate),
        allow_url=options["allow_url"],
        format=options["file_format"] if piped else None,
    )


def _write_options(options: dict[str, Any], piped: bool) -> WriteOptions:
    from vidstyle.media.write import writer

    names = ("codec", "crf", "preset", "pix_fmt", "audio", "overwrite")
    file_format = options["file_format"] if piped else None
    return writer.WriteOptions(format=file_format, **{name: options[name] for name in names})


def _report(summary: Summary, quiet: bool) -> None:
    """Report the outcome; damage and an early stop even when quiet."""
    if summary.damage:
        say(f"{printable(summary.source)}: {summary.damage}")
    target = "standard output" if summary.target == "-" else printable(summary.target)
    if summary.stopped:
        kept = f"; {printable(summary.partial)} keeps what was done" if summary.partial else ""
        say(f"{target}: stopped before its end{kept}")
    elif not quiet:
        pace = f"{summary.frames / summary.elapsed:.3g} fps" if summary.elapsed else ""
        say(f"{target}: {summary.frames} frames in {clock(summary.elapsed)}, {pace}")
