"""The options for the look and the encoding of a film, which `render` and `batch` share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.command import Group, option
from vidstyle.cli.parsing.configuration import configured_options
from vidstyle.errors import UsageError, log

if TYPE_CHECKING:
    from vidstyle.media.options import ReadOptions, WriteOptions


rotate_option = option(
    "--rotate",
    type=click.Choice(["0", "90", "180", "270"]),
    group=Group.INPUT,
    help="Rotate clockwise by this angle instead of as stored in INPUT; 0: do not rotate.",
)

_OPTIONS: tuple[Callable[[Any], Any], ...] = (
    common.change_options,
    option("--start", type=common.SECONDS, group=Group.INPUT, help="Start time, in seconds or as h:mm:ss."),
    option("--end", type=common.SECONDS, group=Group.INPUT, help="End time, as a position in INPUT."),
    option("--frames", type=common.number(1, whole=True), group=Group.OUTPUT,
           help="Write at most N frames."),
    option("--size", type=common.SIZE, group=Group.OUTPUT,
           help="Scale to this size; 1280x-2 keeps the aspect ratio."),
    option("--fps", type=common.RATE, group=Group.OUTPUT,
           help="Convert to a constant frame rate.  [default: keep all timestamps]"),
    option("--codec", metavar="NAME", group=Group.VIDEO,
           help="Video encoder, such as libx265 or h264_nvenc."),
    option("--crf", type=common.number(0, 63), group=Group.VIDEO,
           help="Constant quality; a lower value gives better quality and a larger file."),
    option("--preset", metavar="NAME", group=Group.VIDEO,
           help="Encoder preset; a slower one gives a smaller file."),
    option("--pix-fmt", metavar="NAME", group=Group.VIDEO, help="Output pixel format, such as yuv420p10le."),
    option("--hdr", type=click.Choice(["map", "keep"]), default="map", group=Group.VIDEO,
           help="Map HDR to SDR tones, or keep PQ and HLG in HEVC or AV1 with 10 bits."),
    option("--alpha", type=click.Choice(["keep", "style"]), default="keep", group=Group.VIDEO,
           help="Keep the alpha channel of INPUT, or restyle its edges as well."),
    option("--matte", metavar="COLOR", group=Group.VIDEO,
           help="Put this colour behind the transparent parts of INPUT, such as #ffffff; alpha is dropped. "
           "--background is what is behind people."),
    option("--audio", metavar="copy|none|CODEC", default="copy", group=Group.AUDIO,
           help="Copy, drop or re-encode the audio."),
    option("--input-format", metavar="NAME", group=Group.INPUT,
           help="Format of INPUT if it cannot be detected: raw."),
    common.raw_video_options("Frame rate of raw video or an image sequence.  [default: 25]", "rate"),
    option("--hwaccel", metavar="NAME", group=Group.INPUT, help="Hardware decoder, such as cuda."),
    rotate_option,
    option("--no-autorotate", is_flag=True, hidden=True, group=Group.INPUT),
    option("--compare", type=click.Choice(["side", "split"]), group=Group.OUTPUT,
           help="Show source and result side by side, or split in the middle."),
    common.device_option(),
    common.memory_option,
)  # fmt: skip


def film_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that decide how a film looks and is encoded, except --style."""
    for add in reversed(_OPTIONS):
        command = add(command)
    return command


def film_option_names() -> set[str]:
    """Return the names of the parameters that `film_options` adds."""

    def declared() -> None: ...

    film_options(declared)
    return {str(each.name) for each in declared.__click_params__}  # type: ignore[attr-defined]


def read_options(options: Mapping[str, Any]) -> ReadOptions:
    """Return how to read, from the values of `film_options`."""
    from vidstyle.media.options import ReadOptions

    own = {
        "raw": common.raw_video(options),
        "rotate": _rotation(options),
        "format": options["input_format"],
        "matte": _matte(options["matte"]),
    }
    return common.from_options(ReadOptions, {**options, **own})


def write_options(options: Mapping[str, Any], file_format: str | None = None) -> WriteOptions:
    """Return how to write, from the values of `film_options`.

    Args:
        file_format: of standard output.
    """
    from vidstyle.media.options import WriteOptions

    own = {"format": file_format, "optional": configured_options()}
    return common.from_options(WriteOptions, options, **own)


def _matte(text: str | None) -> tuple[float, float, float] | None:
    """Return the RGB of `--matte`, 0..1."""
    if text is None:
        return None
    from vidstyle.block import Color, rgb_from_text

    try:
        return rgb_from_text(Color("").check(text, False))
    except ValueError as error:
        raise UsageError("--matte", str(error), "give a colour such as #ffffff") from None


def _rotation(options: Mapping[str, Any]) -> int | None:
    """Return the angle of `--rotate` in degrees, or None to follow the rotation stored in INPUT."""
    rotate = options["rotate"]
    if options["no_autorotate"]:
        if rotate not in (None, "0"):
            raise UsageError("--no-autorotate", f"contradicts --rotate {rotate}", "remove one of them")
        log.warning("--no-autorotate: replaced by --rotate 0")
        return 0
    return angle_of(rotate)


def angle_of(rotate: str | None) -> int | None:
    """Return the value of `rotate_option` in degrees."""
    return None if rotate is None else int(rotate)
