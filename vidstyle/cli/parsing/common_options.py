"""Option types and groups of options that several commands share."""

from __future__ import annotations

import dataclasses
import ipaddress
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from vidstyle.cli.parsing.command import Decorator, Group, option
from vidstyle.cli.parsing.region_options import region_options, with_background
from vidstyle.core.machine.cores import MAX_THREADS, limit_opencv, use_threads
from vidstyle.core.machine.free_memory import DEFAULT_MEMORY_SHARE, parse_memory, use_memory
from vidstyle.cues.times import parse_seconds
from vidstyle.errors import StyleError, UsageError

if TYPE_CHECKING:
    from vidstyle.media.options import RawVideo
    from vidstyle.style import Style

T = TypeVar("T")


class Parsed(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """The type of an option whose text is parsed by a function that raises ValueError."""

    def __init__(self, name: str, parse: Callable[[str], Any]) -> None:
        """`name`: of the values, for the help."""
        self.name, self._parse = name, parse

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            return self._parse(str(value)) if isinstance(value, str | int | float) else value
        except ValueError as error:
            self.fail(str(error), param, ctx)


class Name(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """The type of a name, or of several with commas between; a shell completes it, or else names of files."""

    name = "NAME"

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        self._names = names

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return str(value)

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        before, comma, last = incomplete.rpartition(",")
        found = [before + comma + name for name in self._names() if name.startswith(last)]
        return [CompletionItem(name) for name in found] or [CompletionItem(incomplete, type="file")]


def number(low: float = -inf, high: float = inf, whole: bool = False) -> Parsed:
    """Return the type of a number from `low` to `high`; `whole`: an integer."""

    def parse(text: str) -> float:
        try:
            value = int(text) if whole else float(text)
        except ValueError:
            raise ValueError(f"{text!r} is not a {'whole ' * whole}number") from None
        if not low <= value <= high:
            limits = f"below {low:g}" if high == inf else f"outside {low:g} to {high:g}"
            raise ValueError(f"{text} is {limits}")
        return value

    return Parsed("N" if high == inf else f"{low:g}..{high:g}", parse)


def all_styles() -> Iterator[str]:
    """Yield the names of all styles that can be read, and of their variants."""
    from vidstyle.style import load_style, style_names

    for name in style_names():
        with suppress(StyleError):
            yield from (name, *(f"{name}:{variant}" for variant in load_style(name).variants))


def all_block_names() -> Iterable[str]:
    """Return the names of all blocks."""
    from vidstyle.blocks import all_blocks

    return all_blocks()


STYLE, BLOCK = Name(all_styles), Name(all_block_names)


def parse_size(text: str) -> tuple[int, int]:
    """Width and height in pixels, as 1280x720; -1 for one keeps the aspect ratio, -2 makes it even too."""
    match = re.fullmatch(r"(-[12]|[1-9]\d{0,4})[xX](-[12]|[1-9]\d{0,4})", text)
    if match is None or match[1].startswith("-") and match[2].startswith("-"):
        raise ValueError(f"{text!r} is not a size such as 1280x720")
    return int(match[1]), int(match[2])


def parse_rate(text: str) -> Fraction:
    """Frames per second: an integer, a decimal number or a fraction."""
    if not re.fullmatch(r"\d+(\.\d+|/0*[1-9]\d*)?", text) or not 0 < Fraction(text) <= 1000:
        raise ValueError(f"{text!r} is not a rate such as 25, 23.976 or 30000/1001")
    return Fraction(text)


def parse_address(text: str) -> str:
    """Return an IPv4 address."""
    try:
        return str(ipaddress.IPv4Address(text))
    except ValueError:
        raise ValueError(
            f"{text!r} is not an IPv4 address such as 192.168.1.20, or 0.0.0.0 for all"
        ) from None


SECONDS = Parsed("time", parse_seconds)
SIZE = Parsed("WxH", parse_size)
RATE = Parsed("rate", parse_rate)
ADDRESS = Parsed("address", parse_address)


def threads_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --threads, which holds for all that the command computes."""

    def limit(context: click.Context, _: click.Parameter, threads: int | None) -> None:
        if not context.resilient_parsing:
            if threads is not None:
                context.with_resource(use_threads(threads))
            context.with_resource(limit_opencv())

    text = "Number of threads.  [default: the cores that this process may use]"
    return option("--threads", type=number(1, MAX_THREADS, whole=True), metavar="N", group=Group.DEVICE,
                  expose_value=False, callback=limit, help=text)(command)  # fmt: skip


def memory_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --memory, which limits how many frames are restyled at the same time."""

    def limit(context: click.Context, _: click.Parameter, size: int | None) -> None:
        if size is not None and not context.resilient_parsing:
            context.with_resource(use_memory(size))

    text = f"Maximum memory, such as 2G.  [default: 1/{DEFAULT_MEMORY_SHARE} of the free memory, for frames]"
    return option("--memory", type=Parsed("size", parse_memory), metavar="SIZE", group=Group.DEVICE,
                  expose_value=False, callback=limit, help=text)(command)  # fmt: skip


def device_option(text: str = "Device that runs the style.") -> Decorator:
    """Add --device, --list-devices and --threads; `text`: help of the first."""

    def show(context: click.Context, _: click.Parameter, is_wanted: bool) -> None:
        if is_wanted:
            from vidstyle.gpu.device.devices import list_devices

            devices = [f"{each} (software)" if each.software else f"{each}" for each in list_devices()]
            click.echo("\n".join(["cpu", *devices]))
            context.exit()

    names = "auto|cpu|gpu|gpu:N"
    group = Group.DEVICE
    device = option("-d", "--device", metavar=names, default="auto", group=group, help=text)
    listing = option("--list-devices", is_flag=True, is_eager=True, expose_value=False, callback=show,
                     group=group, help="List the devices that can run a style.")  # fmt: skip
    return lambda command: device(listing(threads_option(command)))


def style_options(**declared: Any) -> Decorator:
    """Add the options that choose a style and change its values; `declared`: of --style."""
    style = style_option(**declared)
    return lambda command: style(change_options(command))


def style_option(**declared: Any) -> Decorator:
    """Add --style; `declared`: of it."""
    text = "Name of a style, or a style file."
    own: dict[str, Any] = {"type": STYLE, "group": Group.STYLE, "help": text}
    return option("-s", "--style", "style_name", **(own | declared))


def change_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that change the values of a style."""
    group = Group.STYLE
    changes = option("--set", "changes", metavar="STEP.PARAMETER=VALUE", multiple=True, group=group,
                     help="Override a style parameter; may be repeated.")  # fmt: skip
    text = "Temporal smoothing, from 0 (off) to 1 (strongest).  [default: the style's]"
    steady = option("--steady", type=number(0, 1), group=group, help=text)
    text = (
        "Level of detail: 2 halves the size of lines and dots, 0.5 doubles it.  "
        "[default: 1; up to 2.5 in scenes with small faces, less below 480 lines]"
    )
    detail = option("--detail", type=number(0.125, 8), group=group, help=text)
    text = "Finer marks for small faces, and legible writing, from 0 (off) to 1.  [default: the style's]"
    focus = option("--focus", type=number(0, 1), group=group, help=text)
    return changes(steady(detail(focus(region_options(command)))))


def style_from_options(options: Mapping[str, Any]) -> Style:
    """Return the style that `style_options`, or an argument and `change_options`, describe."""
    from vidstyle.style import load_style, override, set_values, style_names

    if options["style_name"] is None:
        raise UsageError("--style", "is missing", f"choose one of {', '.join(style_names())}, or a file")
    style = override(load_style(options["style_name"]), options["changes"])
    names = "steady", "focus", "only", "keep"
    values = {name: options[name] for name in names if options[name] is not None}
    if options["detail"] is not None:
        if style.height is None:
            raise UsageError("--detail", f"{style.name} has no height; give one, such as --set height=720")
        values["height"] = style.height * options["detail"]
    style = set_values(style, values) if values else style
    return with_background(style, options)


def raw_video_options(rate_help: str, rate_name: str) -> Decorator:
    """Add the options for raw video input; the arguments are help and name of --input-fps."""
    group = Group.INPUT
    size = option(
        "--input-size", type=SIZE, group=group, help="Size of raw video; reads the input as raw video."
    )
    pix_fmt = option("--input-pix-fmt", metavar="NAME", default="yuv420p", group=group,
                     help="Pixel format of raw video.")  # fmt: skip
    rate = option("--input-fps", rate_name, type=RATE, group=group, help=rate_help)
    return lambda command: size(pix_fmt(rate(command)))


def from_options(kind: type[T], options: Mapping[str, Any], **more: Any) -> T:
    """Return a dataclass of options whose fields have the values of the command's options of the same names.

    Args:
        more: fields without an option; they take precedence.
    """
    assert dataclasses.is_dataclass(kind)
    names = [field.name for field in dataclasses.fields(kind) if field.name in options]
    return kind(**{name: options[name] for name in names} | more)


def raw_video(options: Mapping[str, Any]) -> RawVideo:
    """Return the values of `raw_video_options`."""
    from vidstyle.media.options import RawVideo

    return RawVideo(options["input_size"], options["input_pix_fmt"])
