"""vidstyle render: restyle a film, a picture, an image sequence or a pipe."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.display import KINDS, clock, display
from vidstyle.cli.raw_video import raw_video, raw_video_options
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.cli.values import Rate, Seconds, Size
from vidstyle.errors import printable

if TYPE_CHECKING:
    from vidstyle.media.read.reader import ReadOptions
    from vidstyle.media.write.writer import WriteOptions
    from vidstyle.pipeline.progress import Summary


@click.command(short_help="Restyle a film, a picture, an image sequence or a pipe.")
@click.argument("source", metavar="INPUT")
@click.argument("target", metavar="OUTPUT")
@click.option("--style", "style_name", metavar="NAME", required=True, help="A style's name, or a style file.")
@click.option(
    "--set", "changes", metavar="STEP.PARAMETER=VALUE", multiple=True, help="Change the style a bit."
)
@click.option(
    "--steady",
    type=click.FloatRange(0, 1),
    metavar="S",
    help="Hold what flickers: 0 lets it boil, 1 keeps it still.  [default: the style's own]",
)
@click.option("-y", "--overwrite", is_flag=True, help="Replace OUTPUT if it exists.")
@click.option("--start", type=Seconds(), help="Begin here: seconds or h:mm:ss.")
@click.option("--end", type=Seconds(), help="End here.")
@click.option("--frames", type=click.IntRange(min=1), metavar="N", help="Write N frames at most.")
@click.option("--size", type=Size(), help="Scale to this size; 1280x-2 keeps the shape.")
@click.option("--fps", type=Rate(), help="Constant frame rate; without it every frame keeps its own time.")
@click.option("--codec", metavar="NAME", help="Video encoder, such as libx265 or h264_nvenc.")
@click.option("--crf", type=click.FloatRange(0, 63), metavar="Q", help="Quality: lower is better and bigger.")
@click.option("--preset", metavar="NAME", help="How much time the encoder takes.")
@click.option("--pix-fmt", metavar="NAME", help="Pixel format to write, such as yuv420p10le.")
@click.option(
    "--audio", metavar="copy|none|CODEC", default="copy", show_default=True, help="What to do with sound."
)
@click.option(
    "--format", "file_format", metavar="NAME", help="Kind of file on '-', such as nut, yuv4mpegpipe."
)
@raw_video_options("Frame rate of raw video or an image sequence.  [default: 25]")
@click.option("--hwaccel", metavar="NAME", help="Decode on this device, such as cuda.")
@click.option(
    "--rotate", type=click.Choice(["0", "90", "180", "270"]), help="Turn clockwise by this instead."
)
@click.option("--no-autorotate", is_flag=True, help="Leave the pictures as they are stored.")
@click.option("--allow-url", is_flag=True, help="Let INPUT be an address on the network.")
@click.option("--compare", type=click.Choice(["side", "split"]), help="Show the source beside the result.")
@click.option(
    "--device", metavar="auto|cpu|gpu|gpu:N", default="auto", show_default=True, help="What runs the style."
)
@click.option("--progress", type=click.Choice(KINDS), default="auto", show_default=True)
@click.option(
    "--json", "as_json", is_flag=True, help="Print a summary as JSON (on stderr when OUTPUT is '-')."
)
@reporting_options
def render(source: str, target: str, as_json: bool, progress: str, **options: Any) -> int:
    """Restyle INPUT into OUTPUT: a film, a picture, an image sequence (%05d.png) or a pipe (-)."""
    from vidstyle.pipeline.render import render as render_film
    from vidstyle.pipeline.stopping import stop_on_signals
    from vidstyle.style import load_style, override

    changes = list(options["changes"])
    if options["steady"] is not None:
        changes.append(f"steady={options['steady']}")
    style = override(load_style(options["style_name"]), changes)
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
    _tell(summary, quiet=progress in ("json", "none"))
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


def _tell(summary: Summary, quiet: bool) -> None:
    """The outcome; what a user must know is said even when quiet."""
    if summary.damage:
        say(f"{printable(summary.source)}: {summary.damage}")
    target = "standard output" if summary.target == "-" else printable(summary.target)
    if summary.stopped:
        kept = f"; {printable(summary.partial)} keeps what was done" if summary.partial else ""
        say(f"{target}: stopped before its end{kept}")
    elif not quiet:
        pace = f"{summary.frames / summary.elapsed:.3g} fps" if summary.elapsed else ""
        say(f"{target}: {summary.frames} frames in {clock(summary.elapsed)}, {pace}")
