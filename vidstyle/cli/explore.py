"""vidstyle explore: random styles, to choose from on a page or as files."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli import browser
from vidstyle.cli.parsing import common_options as common
from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.path_arguments import PATH, parents_option, path_arguments
from vidstyle.cli.terminal.display import display, progress_option
from vidstyle.cli.terminal.reporting import reporting_options, say
from vidstyle.errors import UsageError, printable
from vidstyle.pipeline.progress import StepProgress
from vidstyle.pipeline.stopping import stop_on_signals

if TYPE_CHECKING:
    from vidstyle.style import Style


@command(
    "Explore randomly generated styles.",
    examples=("vidstyle explore photograph.jpg", "vidstyle explore in.mp4 -o found --count 20 --seed 7"),
)
@path_arguments(source="INPUT")
@option("-o", "--output", type=PATH, metavar="FOLDER", group=Group.OUTPUT,
        help="Write style files, a sheet and styles.json instead of opening a page.")  # fmt: skip
@option("--count", type=common.number(1, 2000, whole=True), default=200, group=Group.RANDOM_STYLES,
        help="Number of styles for -o.")  # fmt: skip
@option("--tries", type=common.number(1, 100_000, whole=True), group=Group.RANDOM_STYLES,
        help="Generate N candidates and keep the best.  [default: until enough pass]")  # fmt: skip
@option("--seed", type=common.number(0, whole=True), default=0, group=Group.RANDOM_STYLES,
        help="Random seed.")  # fmt: skip
@option("--rules", type=click.Choice(["open", "paper"]), default="open", group=Group.RANDOM_STYLES,
        help="Combine parts of the shipped styles, or follow the rules of the paper.")  # fmt: skip
@option("--judge", type=PATH, metavar="MODEL", group=Group.RANDOM_STYLES,
        help="Rank by a model (.onnx) that scores pictures, such as NIMA.")  # fmt: skip
@option("--at", "start", type=common.SECONDS, group=Group.INPUT,
        help="Time of the frame in a film.  [default: the middle]")  # fmt: skip
@option("--allow-url", is_flag=True, group=Group.INPUT, help="Allow INPUT to be a URL.")
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT,
        help="Write into FOLDER even if it is not empty.")  # fmt: skip
@parents_option("output")
@browser.port_option
@browser.open_option
@common.threads_option
@progress_option
@reporting_options
def explore(source: str, output: Path | None, progress: str, **options: Any) -> int:
    """Explore randomly generated styles for INPUT, a picture or a film.

    The page in the browser shows nine styles at a time; the next nine are based on your choice. With -o, the
    styles are written to a folder, with an overview sheet.

    Results that are blank, muddy, blurred, cluttered, flickering, near-duplicates or similar to INPUT are
    discarded.
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
    text = f"{printable(str(output))}: {passed} styles from {found.tried} candidates"
    if stop.is_set():
        text += "; stopped early"
    elif passed < wanted:
        text += f", fewer than {wanted}: the other candidates were discarded"
    faults = {reason or "passed": number for reason, number in found.faults.items()}
    say(text, {"folder": str(output), "styles": passed, "tried": found.tried, "reasons": faults})
    return stop.exit_code


def _show_page(source: str, options: dict[str, Any]) -> int:
    """Show the page until the user ends it."""
    unused = [name for name in ("tries", "judge", "start", "allow_url", "overwrite") if options[name]]
    if unused or options["rules"] != "open":
        option = "rules" if not unused else "at" if unused[0] == "start" else unused[0].replace("_", "-")
        raise UsageError(f"--{option}", "needs -o FOLDER", "remove it, or add -o")
    from vidstyle.explore.page import explore

    is_wanted = browser.is_wanted(options["no_open"])
    browse, reveal = (browser.open_page, browser.show_in_folder) if is_wanted else (None, None)
    with stop_on_signals() as stop:
        seed, port = options["seed"], options["port"]
        designer = designer_until(stop)
        explore(source, stop=stop, seed=seed, port=port, browse=browse, designer=designer, reveal=reveal)
    return stop.exit_code


def designer_until(stop: threading.Event) -> Callable[[str | None, Style], str]:
    """Return a function that opens the designer with a style on a separate page, until `stop` is set."""

    def opened(source: str | None, style: Style) -> str:
        from vidstyle.design import serve

        pages = serve(source, style, Path.cwd(), 0, "auto", None, stop)
        address = next(pages)
        threading.Thread(target=lambda: list(pages), name="vidstyle designer", daemon=True).start()
        return address

    return opened
