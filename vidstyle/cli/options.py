"""Option types and groups of options that several commands share."""

from __future__ import annotations

import dataclasses
import ipaddress
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from fractions import Fraction
from functools import wraps
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
from click.shell_completion import CompletionItem

from vidstyle.errors import OutputError, StyleError, UsageError

if TYPE_CHECKING:
    from vidstyle.media.options import RawVideo
    from vidstyle.style import Style

T = TypeVar("T")
Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]


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
    """The type of a number from `low` to `high`; `whole`: an integer."""

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
    """The names of all styles that can be read, and of their variants."""
    from vidstyle.style import load_style, style_names

    for name in style_names():
        with suppress(StyleError):
            yield from (name, *(f"{name}:{variant}" for variant in load_style(name).variants))


def all_block_names() -> Iterable[str]:
    """The names of all blocks."""
    from vidstyle.blocks import all_blocks

    return all_blocks()


STYLE, BLOCK = Name(all_styles), Name(all_block_names)


def parse_seconds(text: str) -> Fraction:
    """A time: seconds, or [hours:]minutes:seconds."""
    if not re.fullmatch(r"(\d+:){0,2}\d+(\.\d*)?", text):
        raise ValueError(f"{text!r} is not a time such as 12.5 or 1:02:03.5")
    return sum((60**power * Fraction(part) for power, part in enumerate(text.split(":")[::-1])), Fraction(0))


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
    """An IPv4 address."""
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


PATH_OPTIONS = {"source": ("-i", "--input"), "target": ("-o", "--output")}
"""The options that give what the arguments of these names give."""


def path_arguments(**metavars: str) -> Decorator:
    """Adds arguments that may be given as options too, in any mixture.

    Args:
        metavars: how the help calls each argument, one of `PATH_OPTIONS`; in brackets it may be missing.
    """
    words = " ".join(metavars.values())

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def run(words_given: tuple[str, ...], **options: Any) -> Any:
            given = {name: options.pop(name) for name in metavars}
            open_names = [name for name in metavars if given[name] is None]
            given |= zip(open_names, words_given, strict=False)
            for word in words_given[len(open_names) :]:
                hint = "put a pattern such as 'frames/*.png' in quotes"
                raise click.UsageError(f"unexpected argument {word!r}; {hint}")
            for name, metavar in metavars.items():
                if given[name] is None and not metavar.startswith("["):
                    raise click.UsageError(f"{metavar} is missing")
            return command(**{name: path for name, path in given.items() if path is not None}, **options)

        for name, metavar in reversed(metavars.items()):
            text = f"Another way to give {metavar.strip('[]')}."
            run = click.option(*PATH_OPTIONS[name], name, metavar="PATH", type=click.Path(), help=text)(run)
        return click.argument("words_given", metavar=words, nargs=-1, type=click.Path())(run)

    return add


def parents_option(target: str) -> Decorator:
    """Adds --parents, which makes the folders of the paths in the command's parameter `target`."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def run(parents: bool, **options: Any) -> Any:
            given = options.get(target)
            paths = given if isinstance(given, tuple) else (given,)
            with made_folders([str(path) for path in paths if path is not None and parents]):
                return command(**options)

        return click.option("--parents", is_flag=True, help="Make missing folders of the output.")(run)

    return add


@contextmanager
def made_folders(targets: Iterable[str]) -> Iterator[None]:
    """Make the folders of the targets; those that nothing is written to are removed again.

    A target that ends in a slash is a folder itself; a URL has none.

    Raises:
        OutputError: one cannot be made.
    """
    made: list[Path] = []
    for target in targets:
        folder = Path(target) if target.endswith(("/", os.sep)) else Path(target).parent
        if "://" in target:
            continue
        made += [each for each in (folder, *folder.parents) if not each.exists()]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(folder, f"cannot be made ({error.strerror})") from None
    try:
        yield
    finally:
        for folder in made:
            with suppress(OSError):  # it holds something
                folder.rmdir()


def device_option(text: str = "Device that runs the style.") -> Decorator:
    """Adds --device and --list-devices; `text`: help of the first."""

    def show(context: click.Context, _: click.Parameter, is_wanted: bool) -> None:
        if is_wanted:
            from vidstyle.gpu.device.devices import list_devices

            devices = [f"{each} (software)" if each.software else f"{each}" for each in list_devices()]
            click.echo("\n".join(["cpu", *devices]))
            context.exit()

    names = "auto|cpu|gpu|gpu:N"
    device = click.option("-d", "--device", metavar=names, default="auto", help=text)
    listing = click.option("--list-devices", is_flag=True, is_eager=True, expose_value=False, callback=show,
                           help="List the devices that can run a style.")  # fmt: skip
    return lambda command: device(listing(command))


def style_options(**declared: Any) -> Decorator:
    """Adds the options that choose a style and change its values; `declared`: of --style."""
    declared |= {"type": STYLE, "help": "Name of a style or a file."}
    style = click.option("-s", "--style", "style_name", **declared)
    return lambda command: style(change_options(command))


def change_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Adds the options that change the values of a style."""
    changes = click.option("--set", "changes", metavar="STEP.PARAMETER=VALUE", multiple=True,
                           help="Override a style parameter; may be repeated.")  # fmt: skip
    text = "Temporal smoothing, from 0 (off) to 1 (strongest).  [default: the style's]"
    steady = click.option("--steady", type=number(0, 1), help=text)
    text = "How much finer the style draws: 2 halves its marks, 0.5 doubles them."
    detail = click.option("--detail", type=number(0.125, 8), help=text)
    return changes(steady(detail(command)))


def style_from_options(options: Mapping[str, Any]) -> Style:
    """The style that the values of `style_options`, or of an argument and `change_options`, describe."""
    from vidstyle.style import load_style, override, set_values, style_names

    if options["style_name"] is None:
        raise UsageError("--style", "is missing", f"choose one of {', '.join(style_names())}, or a file")
    style = override(load_style(options["style_name"]), options["changes"])
    values = {} if options["steady"] is None else {"steady": options["steady"]}
    if options["detail"] is not None:
        if style.height is None:
            raise UsageError("--detail", f"{style.name} has no height; give one, such as --set height=720")
        values["height"] = style.height * options["detail"]
    return set_values(style, values) if values else style


def raw_video_options(rate_help: str, rate_name: str) -> Decorator:
    """Adds the options that describe raw video as input; help and name are those of --input-fps."""
    size = click.option("--input-size", type=SIZE, help="Size of raw video, which makes INPUT raw.")
    pix_fmt = click.option("--input-pix-fmt", metavar="NAME", default="yuv420p",
                           help="Pixel format of raw video.")  # fmt: skip
    rate = click.option("--input-fps", rate_name, type=RATE, help=rate_help)
    return lambda command: size(pix_fmt(rate(command)))


def from_options(kind: type[T], options: Mapping[str, Any], **more: Any) -> T:
    """A dataclass of options whose fields have the values of the command's options of the same names.

    Args:
        more: fields that have no option of their own; they take precedence.
    """
    assert dataclasses.is_dataclass(kind)
    names = [field.name for field in dataclasses.fields(kind) if field.name in options]
    return kind(**{name: options[name] for name in names} | more)


def raw_video(options: Mapping[str, Any]) -> RawVideo:
    """The values of `raw_video_options`."""
    from vidstyle.media.options import RawVideo

    return RawVideo(options["input_size"], options["input_pix_fmt"])
