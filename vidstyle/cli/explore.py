"""vidstyle explore: random styles, to choose from on a page or as files."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli import browser
from vidstyle.cli import options as common
from vidstyle.cli.display import display, progress_option
from vidstyle.cli.reporting import reporting_options, say
from vidstyle.errors import UsageError, printable
from vidstyle.pipeline.progress import StepProgress
from vidstyle.pipeline.stopping import stop_on_signals

if TYPE_CHECKING:
    from vidstyle.style import Style


@click.command(short_help="Find styles that nobody has designed.")
@common.path_arguments(source="INPUT")
@click.option("-o", "--output", type=click.Path(path_type=Path), metavar="FOLDER",
              help="Write style files, a sheet and styles.json instead of opening a page.")  # fmt: skip
@click.option(
    "--count", type=common.number(1, 2000, whole=True), default=200, help="Number of styles for -o."
)
@click.option("--tries", type=common.number(1, 100_000, whole=True),
              help="Draw so many styles and write the best.  [default: until enough pass]")  # fmt: skip
@click.option("--seed", type=common.number(0, whole=True), default=0, help="Other styles for each number.")
@click.option("--rules", type=click.Choice(["open", "paper"]), default="open",
              help="Build styles of parts of the shipped ones, or by the rules of the paper.")  # fmt: skip
@click.option("--judge", type=click.Path(path_type=Path), metavar="MODEL",
              help="Rank by a model (.onnx) that scores pictures, such as NIMA.")  # fmt: skip
@click.option(
    "--at", "start", type=common.SECONDS, help="Time of the picture in a film.  [default: the middle]"
)
@click.option("--allow-url", is_flag=True, help="Allow INPUT to be a URL.")
@click.option("-y", "--overwrite", is_flag=True, help="Write into FOLDER even if it is not empty.")
@common.parents_option("output")
@click.option("--port", type=common.number(0, 65535, whole=True), default=0, show_default=False,
              help="Port of the page.  [default: any free port]")  # fmt: skip
@browser.open_option
@progress_option
@reporting_options
def explore(source: str, output: Path | None, progress: str, **options: Any) -> int:
    """Find styles for INPUT, a picture or a film, that nobody has designed.

    On a page in the browser you choose from nine at a time, and the next nine follow from what you took.
    With -o they are written to a folder instead, with a sheet of them all.

    Random styles are drawn and measured; what is blank, muddy, blurred, cluttered, flickering, or like the
    source or another one is thrown out.
    """
    if output is None:
        return _show_page(source, options)
    from vidstyle.explore.write_styles import explore_to_folder
    from vidstyle.media.read.reader import ReadOptions

    read = common.from_options(ReadOptions, options)
    names = ("count", "seed", "rules", "tries", "judge", "overwrite")
    chosen = {name: options[name] for name in names}
    with stop_on_signals() as stop, display(progress) as show:
        found = explore_to_folder(source, output, **chosen, read=read, on_step=StepProgress(show), stop=stop)
    passed, wanted = len(found.chosen), options["count"]
    text = f"{printable(str(output))}: {passed} styles of {found.tried} that were drawn"
    if stop.is_set():
        text += "; stopped before its end"
    elif passed < wanted:
        text += f", fewer than {wanted}: no more of them make anything of this picture"
    faults = {reason or "passed": number for reason, number in found.faults.items()}
    say(text, {"folder": str(output), "styles": passed, "tried": found.tried, "reasons": faults})
    return stop.exit_code


def _show_page(source: str, options: dict[str, Any]) -> int:
    """Show the page until the user ends it."""
    unused = [name for name in ("tries", "judge", "start", "allow_url", "overwrite") if options[name]]
    if unused or options["rules"] != "open":
        option = "rules" if not unused else "at" if unused[0] == "start" else unused[0].replace("_", "-")
        raise UsageError(f"--{option}", "belongs to -o FOLDER", "leave it out, or name a folder")
    from vidstyle.explore.page import explore

    browse = browser.open_page if browser.is_wanted(options["no_open"]) else None
    with stop_on_signals() as stop:
        seed, port = options["seed"], options["port"]
        explore(source, stop=stop, seed=seed, port=port, browse=browse, designer=designer_until(stop))
    return stop.exit_code


def designer_until(stop: threading.Event) -> Callable[[str | None, Style], str]:
    """What opens the designer with a style, on a page of its own, until `stop` is set."""

    def opened(source: str | None, style: Style) -> str:
        from vidstyle.design import serve

        pages = serve(source, style, Path.cwd(), 0, "auto", None, stop)
        address = next(pages)
        threading.Thread(target=lambda: list(pages), name="vidstyle designer", daemon=True).start()
        return address

    return opened
