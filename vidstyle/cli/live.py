"""vidstyle live: a camera, a screen or a stream in, restyled as it comes."""

from __future__ import annotations

import json
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.options import Rate, Seconds, Size, raw_video, raw_video_options
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.live.options import LiveOptions
    from vidstyle.live.targets import TargetOptions
    from vidstyle.media.capture.sources import SourceOptions


@click.command(short_help="Restyle a camera, a screen or a stream in real time.")
@click.argument("source", metavar="[SOURCE]", default="camera")
@click.option("--style", "style_name", metavar="NAME", default="ink", show_default=True,
              help="Name of a style or a file.")  # fmt: skip
@click.option("--set", "changes", metavar="STEP.PARAMETER=VALUE", multiple=True,
              help="Override a style parameter; may be repeated.")  # fmt: skip
@click.option("--steady", type=click.FloatRange(0, 1), metavar="S",
              help="Temporal smoothing, from 0 (off) to 1 (strongest).  [default: the style's]")  # fmt: skip
@click.option("--to", "targets", metavar="TARGET", multiple=True, default=["page"], show_default=True,
              help="page, /dev/videoN, a file, -, a URL, name.m3u8 or null; may be repeated.")  # fmt: skip
@click.option("--size", type=Size(), help="Capture and output size; 1280x-2 keeps the aspect ratio.")
@click.option("--fps", type=Rate(), help="Frame rate.  [default: that of the source; 30 for cameras]")
@click.option("--budget", type=click.Choice(["auto", "off"]), default="auto", show_default=True,
              help="To hold the frame rate, auto reduces the working size; off drops frames.")  # fmt: skip
@click.option("--loop", is_flag=True, help="Repeat a file.")
@click.option("--frames", type=click.IntRange(min=1), metavar="N", help="Stop after N frames.")
@click.option("--duration", type=Seconds(), help="Stop after this time.")
@click.option("--format", "file_format", metavar="y4m|nut|raw", help="Format on '-'.  [default: y4m]")
@click.option(
    "--pix-fmt", metavar="NAME", help="Pixel format of a virtual camera (yuyv422, nv12, i420), a file or '-'."
)
@click.option("--codec", metavar="NAME", help="Video encoder of files and network streams.")
@click.option(
    "--crf", type=click.FloatRange(0, 63), metavar="Q", help="Quality of files; lower is better and larger."
)
@click.option("--bitrate", type=click.IntRange(min=1000), metavar="BITS",
              help="Bit rate of network streams, in bits per second.")  # fmt: skip
@click.option("--audio", type=click.Choice(["auto", "none"]), default="auto", show_default=True,
              help="Audio of files and streams.")  # fmt: skip
@click.option("--microphone", metavar="NAME", help="Audio source: default, hw:1,0, part of a name, or test.")
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite existing files.")
@click.option("--input-format", metavar="NAME", help="Format of a camera (mjpeg) or of '-' (raw).")
@raw_video_options("Frame rate of raw video.  [default: 30]")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port of the page.  [default: any free port]"
)
@click.option("--device", metavar="auto|cpu|gpu|gpu:N", default="auto", show_default=True,
              help="Device that runs the style.")  # fmt: skip
@click.option("--list", "listing", is_flag=True, help="List cameras with their modes, and microphones.")
@click.option("--no-keys", is_flag=True, help="Disable keyboard control.")
@click.option("--stats", is_flag=True, help="Print latency and dropped frames at the end.")
@click.option("--json", "as_json", is_flag=True,
              help="Print --stats or --list as JSON (on stderr when a target is '-').")  # fmt: skip
@reporting_options
def live(source: str, targets: tuple[str, ...], listing: bool, as_json: bool, **options: Any) -> int:
    """Restyle SOURCE in real time: a camera, a screen, a stream or a file, to one or more targets.

    SOURCE is a camera's path, number or name (default: the first camera), screen, test, -, a URL, or a
    file, which plays in real time.
    """
    from vidstyle.live.control import Controls
    from vidstyle.live.keys import HELP, keys
    from vidstyle.live.session import LiveSession
    from vidstyle.live.targets import target_maker
    from vidstyle.media.capture.sources import live_source
    from vidstyle.pipeline.stopping import stop_on_signals
    from vidstyle.style import load_style, override

    if listing:
        _list_devices(as_json)
        return 0
    steady = [] if options["steady"] is None else [f"steady={options['steady']}"]
    controls = Controls(override(load_style(options["style_name"]), [*options["changes"], *steady]))
    makers = [target_maker(target, _target_options(options)) for target in targets]
    opened = live_source(source, _source_options(options))
    session = LiveSession(opened, controls, makers, _live_options(options))
    no_keys = options["no_keys"] or source == "-"
    with stop_on_signals() as stop, nullcontext(False) if no_keys else keys(controls) as has_keys:
        if has_keys:
            say(HELP)
        summary = session.run(stop)
    if options["stats"]:
        for line in summary.lines():
            say(line)
    if as_json:
        click.echo(json.dumps(summary.as_dict()), err="-" in targets)
    return stop.exit_code if stop.is_set() else 0


def _list_devices(as_json: bool) -> None:
    from vidstyle.media.capture.camera import camera_list
    from vidstyle.media.capture.microphone import microphone_list

    cameras, microphones = camera_list(), microphone_list()
    if as_json:
        heard = [{"kind": "microphone", "path": path, "name": name} for path, name in microphones]
        click.echo(json.dumps([*(_described(device) for _, device in cameras), *heard]))
        return
    if not cameras:
        say("there is no camera here")
    for name, device in cameras:
        what = "" if device.can_capture else "  (virtual: pictures can be written to it)"
        click.echo(f"{name}  {device.name}{what}")
        for mode in device.modes:
            click.echo(f"    {mode}")
    for path, name in microphones:
        click.echo(f"{path}  {name}  (microphone)")


def _described(device: Any) -> dict[str, Any]:
    modes = [
        {
            "format": mode.format,
            "size": [mode.width, mode.height],
            "fps": [float(rate) for rate in mode.rates],
        }
        for mode in device.modes
    ]
    return {
        "kind": "camera",
        "path": device.path,
        "name": device.name,
        "gives": device.can_capture,
        "takes": device.can_output,
        "modes": modes,
    }


def _source_options(options: dict[str, Any]) -> SourceOptions:
    from vidstyle.media.capture import sources as live_sources

    return live_sources.SourceOptions(
        size=options["size"],
        rate=options["fps"],
        loop=options["loop"],
        format=options["input_format"],
        raw=raw_video(options),
        raw_rate=options["input_fps"],
    )


def _target_options(options: dict[str, Any]) -> TargetOptions:
    from vidstyle.live import targets
    from vidstyle.media.write.writer import WriteOptions

    names = ("codec", "crf", "pix_fmt", "overwrite")
    return targets.TargetOptions(
        format=options["file_format"],
        pix_fmt=options["pix_fmt"],
        codec=options["codec"],
        bitrate=options["bitrate"],
        file=WriteOptions(**{name: options[name] for name in names}),
        port=options["port"],
    )


def _live_options(options: dict[str, Any]) -> LiveOptions:
    from vidstyle.live import options as setting
    from vidstyle.media.capture.microphone import Microphone

    microphone = options["microphone"]
    if microphone is not None and options["audio"] == "none":
        raise UsageError("--microphone", "is of no use with --audio none", "leave one of them out")
    return setting.LiveOptions(
        size=options["size"],
        rate=options["fps"],
        device=options["device"],
        budget=options["budget"] == "auto",
        sound=options["audio"] == "auto",
        microphone=None if microphone is None else Microphone(microphone),
        frames=options["frames"],
        seconds=None if options["duration"] is None else float(options["duration"]),
    )
