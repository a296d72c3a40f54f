"""vidstyle live: restyle a camera, a screen or a stream in real time."""

from __future__ import annotations

import json
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli import browser
from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.configuration import configured_options
from vidstyle.cli.parsing.cue_options import cues_option, style_list
from vidstyle.cli.parsing.path_arguments import parents_option, path_arguments
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.cues.times import parse_interval
from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.live.control import Controls, LiveOptions


@command(
    "Restyle a camera, a screen or a stream in real time.",
    examples=(
        "vidstyle live --style ink",
        "vidstyle live /dev/video0 --to /dev/video9 -s noir",
        "vidstyle live in.mp4 --loop --to page --to show.mkv",
    ),
    epilog="Styles: vidstyle styles. Guide: docs/camera.md in the source folder.",
)
@path_arguments(source="[SOURCE]")
@common.style_options(default="ink", help="Name of a style, or a style file; several as in ink,noir,poster.")
@option("--change", "interval", type=common.Parsed("time", parse_interval), group=Group.STYLE,
        help="Time after which the next style of --style follows, such as 30s.")  # fmt: skip
@cues_option("Cue file that the key c starts; without keys it starts at once.")
@option("--to", "targets", metavar="TARGET", multiple=True, default=["page"], group=Group.OUTPUT,
        help="page, /dev/videoN, a file, -, a URL, name.m3u8 or null; may be repeated.")  # fmt: skip
@option("--size", type=common.SIZE, group=Group.OUTPUT,
        help="Capture and output size; 1280x-2 keeps the aspect ratio.")  # fmt: skip
@option("--fps", type=common.RATE, group=Group.OUTPUT,
        help="Frame rate.  [default: of the source; 30 for cameras]")  # fmt: skip
@option("--budget", type=click.Choice(["auto", "off"]), default="auto", group=Group.DEVICE,
        help="If too slow, auto reduces working size and frame rate; off reduces only the rate.")  # fmt: skip
@option("--loop", is_flag=True, group=Group.INPUT, help="Repeat a file.")
@option("--frames", type=common.number(1, whole=True), group=Group.OUTPUT, help="Stop after N frames.")
@option("--duration", "seconds", type=common.SECONDS, group=Group.OUTPUT, help="Stop after this time.")
@option("--format", "file_format", metavar="y4m|nut|raw", group=Group.OUTPUT,
        help="Format of standard output.  [default: y4m]")  # fmt: skip
@option("--pix-fmt", metavar="NAME", group=Group.VIDEO,
        help="Pixel format of a virtual camera (yuyv422, nv12, i420), a file or stdout.")  # fmt: skip
@option("--codec", metavar="NAME", group=Group.VIDEO, help="Video encoder of files and network streams.")
@option("--crf", type=common.number(0, 63), group=Group.VIDEO,
        help="Constant quality of files; a lower value gives better quality and a larger file.")  # fmt: skip
@option("--bitrate", type=common.number(1000, whole=True), group=Group.VIDEO,
        help="Bit rate of network streams, in bits per second.")  # fmt: skip
@option("--audio", type=click.Choice(["auto", "none"]), default="auto", group=Group.AUDIO,
        help="Audio of files and streams.")  # fmt: skip
@option("--microphone", metavar="NAME", group=Group.AUDIO,
        help="Audio source: default, hw:1,0, part of a name, or test.")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite existing files.")
@parents_option("targets")
@option("--input-format", metavar="NAME", group=Group.INPUT,
        help="Format of a camera (mjpeg) or of standard input (raw).")  # fmt: skip
@common.raw_video_options("Frame rate of raw video.  [default: 30]", "raw_rate")
@browser.port_option
@option("--host", type=common.ADDRESS, group=Group.CONTROL,
        help="Serve the page to the network on this local address, or 0.0.0.0 for all.")  # fmt: skip
@browser.open_option
@common.device_option()
@option(
    "--list", "listing", is_flag=True, group=Group.INPUT, help="List cameras, their modes and microphones."
)
@option("--no-keys", is_flag=True, group=Group.CONTROL, help="Disable keyboard control.")
@option("--stats", is_flag=True, help="Print latency and dropped frames at the end.")
@option("--json", "as_json", is_flag=True,
        help="Print --stats or --list as JSON (on stderr if a target is -).")  # fmt: skip
@reporting_options
def live(
    targets: tuple[str, ...], listing: bool, as_json: bool, source: str = "camera", **options: Any
) -> int:
    """Restyle SOURCE in real time: a camera, a screen, a stream or a file, to one or more targets.

    SOURCE is the path, number or name of a camera (default: the first one), screen, test, -, a URL, or a
    file, which is played in real time.
    """
    from vidstyle.live.keys import KEY_HELP, keys
    from vidstyle.live.session import LiveSession
    from vidstyle.live.targets import TargetOptions, target_maker
    from vidstyle.media.capture.sources import SourceOptions, resolve_source
    from vidstyle.media.write.writer import WriteOptions
    from vidstyle.pipeline.stopping import stop_on_signals

    if listing:
        _list_devices(as_json)
        return 0
    controls = _controls(options)
    file = common.from_options(WriteOptions, options, audio="copy", optional=configured_options())
    browse = browser.open_page if browser.is_wanted(options["no_open"]) else None
    of_targets = {"format": options["file_format"], "file": file, "browse": browse}
    target_options = common.from_options(TargetOptions, options, **of_targets)
    makers = [target_maker(target, target_options) for target in targets]
    read = {"rate": options["fps"], "format": options["input_format"], "raw": common.raw_video(options)}
    opened = resolve_source(source, common.from_options(SourceOptions, options, **read))
    session = LiveSession(opened, controls, makers, _live_options(options))
    no_keys = options["no_keys"] or source == "-"
    with stop_on_signals() as stop, nullcontext(False) if no_keys else keys(controls) as has_keys:
        if not has_keys:
            controls.start_cues()
        summary = session.run(stop, KEY_HELP if has_keys else "")
    if options["stats"]:
        for line in summary.lines():
            say(line)
    if as_json:
        click.echo(json.dumps(summary.as_dict()), err="-" in targets)
    return stop.exit_code if stop.is_set() else 0


def _controls(options: dict[str, Any]) -> Controls:
    """Return the controls of a session with the styles that the options describe."""
    from vidstyle.cues.cue_file import read_cue_file
    from vidstyle.live.control import Controls, StyleShow

    first, *others = (
        common.style_from_options({**options, "style_name": name}) for name in style_list(options)
    )
    seconds = options["interval"]
    if seconds is not None and not others:
        raise UsageError("--change", "needs several styles", "give them as in --style ink,noir,poster")
    cues = None if options["cues"] is None else read_cue_file(options["cues"])
    return Controls(first, show=StyleShow(others, None if seconds is None else float(seconds), cues))


def _list_devices(as_json: bool) -> None:
    from vidstyle.media.capture.camera import list_cameras
    from vidstyle.media.capture.microphone import list_microphones

    cameras, microphones = list_cameras(), list_microphones()
    if as_json:
        heard = [{"kind": "microphone", "path": path, "name": name} for path, name in microphones]
        click.echo(json.dumps([*(_described(device) for _, device in cameras), *heard]))
        return
    if not cameras:
        say("no camera found")
    for name, device in cameras:
        what = "" if device.can_capture else "  (virtual camera: an output)"
        click.echo(f"{name}  {device.name}{what}")
        for mode in device.modes:
            click.echo(f"    {mode}")
    for path, name in microphones:
        click.echo(f"{path}  {name}  (microphone)")


def _described(device: Any) -> dict[str, Any]:
    return {
        "kind": "camera",
        "path": device.path,
        "name": device.name,
        "gives": device.can_capture,
        "takes": device.can_output,
        "modes": [
            {"format": mode.format, "size": [mode.width, mode.height], "fps": [*map(float, mode.rates)]}
            for mode in device.modes
        ],
    }


def _live_options(options: dict[str, Any]) -> LiveOptions:
    from vidstyle.live.control import LiveOptions
    from vidstyle.media.capture.microphone import Microphone

    sound, microphone = options["audio"] == "auto", options["microphone"]
    if microphone is not None and not sound:
        raise UsageError("--microphone", "has no effect with --audio none", "remove one of them")
    return common.from_options(
        LiveOptions,
        options,
        rate=options["fps"],
        budget=options["budget"] == "auto",
        sound=sound,
        microphone=None if microphone is None else Microphone(microphone),
    )
