"""vidstyle bench: speed of blocks and styles on this machine."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import Group, command, option
from vidstyle.cli.parsing.common_options import BLOCK, SIZE, STYLE, device_option, number
from vidstyle.cli.parsing.path_arguments import PATH, parents_option
from vidstyle.cli.terminal.reporting import reporting_options, say

if TYPE_CHECKING:
    from vidstyle.bench import Timed

FORMS = ("compute", "fragment")
"""The kinds of shaders that run a pass."""


def both_sides(_: click.Context, parameter: click.Parameter, value: Any) -> Any:
    """Reject sizes with only one side given: there is no picture to derive the other one from."""
    for size in [value] if isinstance(value, tuple) and isinstance(value[0], int) else value or ():
        if min(size) < 1:
            raise click.BadParameter("give both sides, such as 1280x720", param=parameter)
    return value


@command(
    "Measure the speed of blocks and styles.",
    examples=("vidstyle bench -s ink", "vidstyle bench --film in.mp4 -o film.md"),
)
@option("--size", "sizes", type=SIZE, multiple=True, default=["1920x1080"], group=Group.MEASUREMENT,
        callback=both_sides, help="Picture size; may be repeated.")  # fmt: skip
@option("-s", "--style", "styles", type=STYLE, multiple=True, group=Group.MEASUREMENT,
        help="Measure only this style; may be repeated.")  # fmt: skip
@option("--block", "blocks", type=BLOCK, multiple=True, group=Group.MEASUREMENT,
        help="Measure only this block; may be repeated.")  # fmt: skip
@device_option("GPU to measure in addition to the CPU.")
@option("--form", type=click.Choice(["best", *FORMS, "both"]), default="best", group=Group.DEVICE,
        help="Kind of shaders on the GPU.")  # fmt: skip
@option("--seconds", type=number(0, 3600), default=1.0, group=Group.MEASUREMENT,
        help="Approximate time of each measurement.")  # fmt: skip
@option("--bandwidth", type=number(0.001), metavar="GB/S", group=Group.DEVICE,
        help="Memory bandwidth of the GPU; adds the fraction of it that is used.")  # fmt: skip
@option("--film", type=PATH, metavar="FILM", group=Group.MEASUREMENT,
        help="Measure a whole film instead: decode, style, steady, encode.")  # fmt: skip
@option("--frames", type=number(3, 100_000, whole=True), default=48, group=Group.MEASUREMENT,
        help="Number of frames of FILM.")  # fmt: skip
@option("--json", "as_json", is_flag=True, group=Group.OUTPUT, help="Print JSON, with the time of each pass.")
@option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False, readable=False), metavar="FILE",
        group=Group.OUTPUT, help="Write the tables or the JSON to FILE.")  # fmt: skip
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT, help="Overwrite FILE if it exists.")
@parents_option("output")
@reporting_options
def bench(
    sizes: tuple[tuple[int, int], ...],
    film: Path | None,
    frames: int,
    bandwidth: float | None,
    as_json: bool,
    output: Path | None,
    overwrite: bool,
    **options: Any,
) -> None:
    """Measure the speed of every block and style on this machine, next to the paper's figures."""
    from vidstyle.media.write.atomic import atomic_file

    def measured() -> str:
        return (
            _film(film, frames, as_json, **options) if film else _parts(sizes, bandwidth, as_json, **options)
        )

    if output is None:
        click.echo(measured(), nl=False)
        return
    with atomic_file(output, film, overwrite) as write:
        write(measured().encode())


def _parts(sizes: tuple[tuple[int, int], ...], bandwidth: float | None, as_json: bool, **options: Any) -> str:
    """Return the tables, or JSON, of blocks and styles."""
    from vidstyle.bench import set_up
    from vidstyle.bench.results import as_dict, markdown

    prepared = set_up(sizes, **options)
    timed = []
    for each in prepared.run():
        timed.append(each)
        _report(each)
    data = as_dict(prepared, timed, bandwidth)
    return json.dumps(data, indent=2) + "\n" if as_json else markdown(data)


def _film(film: Path, frames: int, as_json: bool, **options: Any) -> str:
    """Return the table, or JSON, of a film."""
    from vidstyle.bench.films import FilmBench
    from vidstyle.bench.results import film_markdown
    from vidstyle.bench.subjects import subjects

    wanted = [each for each in subjects(options["styles"], options["blocks"]) if each.kind == "style"]
    prepared, timed = FilmBench(film, frames), []
    for each in prepared.run(wanted, options["device"]):
        timed.append(each)
        say(f"{each.name}: {1 / each.whole:.1f} frames a second")
    return json.dumps([vars(each) for each in timed], indent=2) + "\n" if as_json else film_markdown(timed)


def _report(timed: Timed) -> None:
    gpu = "".join(
        f", {times.plan.form} passes {sum(times.passes) * 1e3:.3g} ms" for times in timed.gpu if times.passes
    )
    say(f"{timed.subject.name}, {timed.size[0]}x{timed.size[1]}: CPU {timed.cpu * 1e3:.3g} ms{gpu}")
