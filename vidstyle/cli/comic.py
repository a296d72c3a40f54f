"""vidstyle comic: comic pages from a film."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from vidstyle.cli.options import Seconds
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.comic.layout.paper import DPI
from vidstyle.errors import printable


class Panels(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """A number of panels, or auto, which becomes 0."""

    name = "N|auto"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        """The number, or 0."""
        if isinstance(value, int) or value == "auto":
            return 0 if value == "auto" else value
        if not value.isdigit() or int(value) == 0:
            self.fail(f"{value!r} is neither a number of panels nor auto", param, ctx)
        return int(value)


class Times(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """Comma-separated times."""

    name = "T,T"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Seconds."""
        if isinstance(value, tuple):
            return value
        return tuple(float(Seconds().convert(part.strip(), param, ctx)) for part in value.split(","))


class Spans(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """Comma-separated parts of a film, each FROM-TO."""

    name = "T-T,T-T"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[tuple[float, float], ...]:
        """Start and end of each in seconds."""
        if isinstance(value, tuple):
            return value
        spans = []
        for part in value.split(","):
            first, dash, last = part.strip().partition("-")
            if not dash:
                self.fail(f"{part!r} is not a part of a film such as 0:10-0:25", param, ctx)
            spans.append(tuple(float(Seconds().convert(each, param, ctx)) for each in (first, last)))
        return tuple(spans)  # type: ignore[arg-type]


@click.command(short_help="Make comic pages from a film or a folder of pictures.")
@click.argument("source", metavar="INPUT")
@click.argument("target", metavar="OUTPUT")
@click.option("--panels", type=Panels(), default="auto", show_default=True, help="Number of panels.")
@click.option("--at", type=Times(), default=(), help="Times of the key frames, in seconds or as h:mm:ss.")
@click.option("--skip", type=Spans(), default=(), help="Exclude these time ranges.")
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True,
              help="Select another good layout.")  # fmt: skip
@click.option(
    "--size",
    metavar="NAME|WxH",
    help="a4, a5, a3, letter, square, strip, 1200x1800 or 210x297mm.  [default: a4; for .html strip]",
)
@click.option("--landscape", is_flag=True, help="Landscape orientation, for named sizes.")
@click.option("--dpi", type=float, default=DPI, show_default=True, help="Pixels per inch.")
@click.option(
    "--pages", type=click.IntRange(min=1), metavar="N", help="Number of pages.  [default: automatic]"
)
@click.option(
    "--bleed", "bleeding", is_flag=True, help="Full bleed: extend full-width panels to the page edge."
)
@click.option("--right-to-left", is_flag=True, help="Right-to-left reading order.")
@click.option("--style", "styles", metavar="A,B,C",
              help="Styles of the panels, in rotation.  [default: comic]")  # fmt: skip
@click.option("--subtitles", metavar="FILE|none", help="Subtitles, .srt or .vtt.  [default: the film's]")
@click.option("--title", default="", help="Title above the first page.")
@click.option("--font", type=click.Path(path_type=Path), metavar="FILE",
              help="Font, .ttf or .otf.  [default: built-in, or an installed one if needed]")  # fmt: skip
@click.option("--frames", type=click.Path(path_type=Path), metavar="FOLDER",
              help="Save the key frames, with a table of their times.")  # fmt: skip
@click.option("--storyboard", is_flag=True, help="Make a contact sheet with times instead.")
@click.option("--face-model", type=click.Path(path_type=Path), metavar="FILE",
              help="Face detection model: an OpenCV cascade (.xml) or YuNet (.onnx).")  # fmt: skip
@click.option("-y", "--overwrite", is_flag=True, help="Overwrite existing files.")
@click.option("--device", metavar="auto|cpu|gpu|gpu:N", default="auto", show_default=True,
              help="Device that runs the style.")  # fmt: skip
@reporting_options
def comic(source: str, target: str, styles: str | None, **options: Any) -> None:
    """Make comic pages of INPUT, a film or a folder of pictures.

    OUTPUT ends in .png, .jpg or .svg (several pages become NAME-1.png and so on), .pdf, .cbz or .html.
    """
    from vidstyle.comic.make import ComicOptions, make_comic
    from vidstyle.comic.select.moments import KeyFrameOptions

    key_frames = KeyFrameOptions(options.pop("panels") or None, options.pop("at"), options.pop("skip"))
    names = tuple(name.strip() for name in styles.split(",")) if styles else None
    with _steps() as show:
        made = make_comic(source, target, ComicOptions(key_frames=key_frames, styles=names, **options), show)
    panels, pages = (_counted(*each) for each in ((len(made.moments), "panel"), (made.pages, "page")))
    say(printable(f"{', '.join(map(str, made.files))}: {panels} on {pages}"))


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


@contextmanager
def _steps() -> Iterator[Callable[[str, int, int], None]]:
    """A function that shows progress on a terminal, and nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda *_: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), redirect_stdout=False, transient=True) as bar:
        task = bar.add_task("", total=None)

        def show(step: str, done: int, total: int) -> None:
            bar.update(task, description=step, completed=done, total=total or None)

        yield show
