"""vidstyle batch: restyle many films."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import Group, command, given_words, option
from vidstyle.cli.parsing.common_options import SECONDS, number, style_from_options, style_option
from vidstyle.cli.parsing.cue_options import by_options, look_from_options
from vidstyle.cli.parsing.film_options import film_option_names, film_options, read_options, write_options
from vidstyle.cli.parsing.path_arguments import PATH, PATH_TEXT
from vidstyle.cli.terminal.display import progress_option
from vidstyle.cli.terminal.reporting import event, reporting_options, say
from vidstyle.core.machine.cores import core_count
from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.batch.batch import BatchOptions
    from vidstyle.batch.batch_film import BatchFilm
    from vidstyle.batch.planner import FilmLook, Planner, Settings
    from vidstyle.batch.processes import Executor

MAX_JOBS = 1024


@command(
    "Restyle many films in parallel.",
    examples=(
        "vidstyle batch holiday/ -s ink -o 'restyled/{folder}/{name}.mp4'",
        "vidstyle batch '*.mov' list.txt -s ink -s noir -o 'out/{name}-{style}.mp4'",
        "vidstyle batch clips/ -s ink,noir,poster --by scene -o 'out/{name}.mp4'",
        "vidstyle batch --watch incoming/ -s comic -o 'done/{name}.mp4' --retry 2",
    ),
    epilog="Styles: vidstyle styles. Guide: docs/batch.md in the source folder.",
)
@click.argument("inputs", metavar="INPUT...", nargs=-1, type=PATH_TEXT)
@option("-o", "--output", "template", metavar="TEMPLATE", group=Group.OUTPUT,
        help="Names of the results, with the fields {name}, {folder} and {style}.")  # fmt: skip
@style_option(multiple=True, help="Name of a style, or a style file; may be repeated.")
@option("--cues", metavar="FILE", group=Group.STYLE,
        help="Cue file, such as 'cues/{name}.toml'; instead of --style.")  # fmt: skip
@by_options
@film_options
@option("-y", "--overwrite", is_flag=True, group=Group.OUTPUT,
        help="Replace existing files that are not finished results.")  # fmt: skip
@option("-j", "--jobs", type=number(1, MAX_JOBS, whole=True), metavar="N", group=Group.DEVICE,
        help="Number of parallel films.  [default: limited by cores and memory]")  # fmt: skip
@option("--on", "address", metavar="CLUSTER", group=Group.DEVICE,
        help="Run on a Ray cluster: ray://HOST:PORT, or ray for one on this machine.")  # fmt: skip
@option("--insecure", is_flag=True, group=Group.DEVICE,
        help="Allow a cluster on other machines that requires no token.")  # fmt: skip
@option("--segment", type=SECONDS, group=Group.OUTPUT,
        help="Divide long films into segments of at least this length.")  # fmt: skip
@option("--retry", type=number(0, whole=True), default=0, group=Group.OUTPUT,
        help="Number of further attempts for a film that failed.")  # fmt: skip
@option("--dry-run", is_flag=True, group=Group.OUTPUT, help="Print the planned work without rendering.")
@option("--emit", type=click.Choice(["openjd", "slurm", "shell"]), group=Group.OUTPUT,
        help="Print a job for a scheduler instead; finds the segments of --segment first.")  # fmt: skip
@option("--watch", type=PATH, metavar="FOLDER", group=Group.INPUT,
        help="Watch this folder, and render each new film when it is complete.")  # fmt: skip
@progress_option
@option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@option("--csv", "as_csv", is_flag=True, help="Print the summary as CSV.")
@reporting_options
@click.pass_context
def batch(
    context: click.Context,
    /,
    inputs: tuple[str, ...],
    template: str | None,
    style_name: tuple[str, ...],
    overwrite: bool,
    progress: str,
    as_json: bool,
    as_csv: bool,
    **options: Any,
) -> int:
    """Restyle many films; continue where an earlier run stopped.

    INPUT is a film, a folder (with its subfolders), a pattern such as 'clips/*.mp4', or a list: a .txt file
    with one name per line. Finished films are skipped, unless their source, style or options have changed. A
    film that fails is reported, and the others continue. --threads is per film.
    """
    from vidstyle.batch.film_checks import preview
    from vidstyle.batch.inputs import find_sources
    from vidstyle.batch.planner import Planner
    from vidstyle.batch.report import exit_code

    _check(inputs, template, options, as_json and as_csv)
    planner = Planner(str(template), _looks({**options, "style_name": style_name}))
    films = planner.films(find_sources(inputs))
    if options["segment"] is not None:
        _check_local(str(template), films)
    if options["dry_run"]:
        for film in films:
            preview(film, overwrite)
        _print(films, as_json, as_csv)
        return exit_code(films)
    processes = _processes(options["address"])
    work = _share_cores(context, options, processes, len(films))
    if options["emit"]:
        click.echo(_job(films, work, options["emit"]))
        return exit_code(films)
    code, films = _run(planner, films, work, processes, options["watch"], progress)
    _print(films, as_json, as_csv)
    return code


def _share_cores(
    context: click.Context, options: dict[str, Any], processes: Executor, films: int
) -> BatchOptions:
    """Decide how many films are rendered at the same time, and with how many threads each."""
    from vidstyle.batch.batch import BatchOptions
    from vidstyle.batch.resources import shared_cores

    every = options["segment"]
    most = MAX_JOBS if options["watch"] or every else films
    jobs, threads = shared_cores(options["jobs"], most, processes.room)
    if every and core_count().reason != "--threads":
        threads = 1  # the packets of an encoder depend on its number of threads
    words = given_words(context, (film_option_names() | {"by", "seed"}) - {"threads"})
    every_text = every and f"{float(every):g}"
    return BatchOptions(jobs, threads, words, context.params["overwrite"], options["retry"], every_text)


def _run(
    planner: Planner,
    films: list[BatchFilm],
    options: BatchOptions,
    processes: Executor,
    watched: Path | None,
    progress: str,
) -> tuple[int, list[BatchFilm]]:
    """Render all films, and those that come into the watched folder; return the exit code and all films."""
    from vidstyle.batch.batch import FilmBatch
    from vidstyle.batch.report import exit_code
    from vidstyle.batch.watch import WatchedFolder
    from vidstyle.cli.terminal.batch_display import batch_display
    from vidstyle.pipeline.stopping import stop_on_signals

    began = time.monotonic()
    with stop_on_signals() as stop, batch_display(progress) as show:
        work = FilmBatch(films, options, processes, show.notice, lambda film: show.end(film, work.films))
        folder = None if watched is None else WatchedFolder(watched)
        more = None if folder is None else lambda: planner.films(folder.complete_sources(), work.films)
        work.run(stop, lambda: show.update(work.films, time.monotonic() - began), more)
    event("summary", {"films": [film.as_dict() for film in work.films]})
    return stop.exit_code or exit_code(work.films), work.films


def _check(inputs: tuple[str, ...], template: str | None, options: dict[str, Any], both: bool) -> None:
    """Raise UsageError if an argument is missing or cannot be used, or two contradict each other."""
    from vidstyle.batch.division import check_options

    watched: Path | None = options["watch"]
    if options["segment"] is not None:
        check_options(options)
    if not inputs and watched is None:
        raise click.UsageError("INPUT is missing")
    if template is None:
        raise UsageError("--output", "is missing", "name the results, such as 'out/{name}-{style}.mp4'")
    if not (Path(template).suffix or template.endswith(("/", os.sep)) or Path(template).is_dir()):
        remedy = f"write '{template}/' for a folder, or '{template}.mp4'"
        raise UsageError("--output", f"{template} is not a folder and has no extension", remedy)
    if both:
        raise UsageError("--csv", "contradicts --json", "remove one of them")
    if watched is not None and not watched.is_dir():
        raise UsageError("--watch", f"{watched} is not a folder")
    if options["address"]:
        _check_cluster(options)


def _check_local(template: str, films: list[BatchFilm]) -> None:
    """Raise UsageError if a source or the results are in storage, where segments cannot be."""
    from vidstyle.batch.stored_path import StoredPath, film_path

    for path in (film_path(template), *(film.source.path for film in films)):
        if isinstance(path, StoredPath):
            raise UsageError(
                "--segment", f"needs files on this machine, and {path} is in storage", "remove it"
            )


def _check_cluster(options: dict[str, Any]) -> None:
    """Raise UsageError if --on cannot be used, or contradicts another option."""
    from vidstyle.batch.ray_cluster import check_address

    if options["emit"]:
        raise UsageError("--on", "contradicts --emit", "remove one of them")
    check_address(options["address"], options["insecure"])


def _processes(address: str | None) -> Executor:
    """What runs the processes of the films: this machine, or a cluster."""
    from vidstyle.batch.processes import Processes
    from vidstyle.batch.ray_cluster import RayCluster

    if address is None:
        return Processes()
    say("Ray starts" if address == "ray" else f"{address} is contacted")
    return RayCluster(address)


def _looks(options: dict[str, Any]) -> list[FilmLook]:
    """Return the looks of the films; raises an error if one cannot be read."""
    from vidstyle.batch.planner import FilmLook
    from vidstyle.pipeline.resume import setting_parts

    read, write = read_options(options), write_options(options)
    read.check()
    more = {name: options[name] for name in ("frames", "compare", "device")}

    def settings_of_cues(file: str) -> Settings:
        return setting_parts(look_from_options({**options, "cues": Path(file)}), read, write, **more)

    def settings_of_style(name: str) -> Settings:
        return setting_parts(look_from_options({**options, "style_name": name}), read, write, **more)

    if options["cues"] is not None:
        return [FilmLook("--cues", options["cues"], settings_of_cues)]
    if not options["style_name"]:
        style_from_options({"style_name": None})
    return [FilmLook("--style", name, settings_of_style) for name in options["style_name"]]


def _job(films: list[BatchFilm], options: BatchOptions, manager: str) -> str:
    """Return a job that renders these films on other machines."""
    from vidstyle.batch.emit import absolute_film, job_phases, job_text
    from vidstyle.batch.film_checks import preview

    films[:] = map(absolute_film, films)
    for film in films:
        preview(film, options.overwrite)
        if film.state == "failed":
            say(film.reason)
    phases = job_phases(films, options)
    if not phases:
        raise UsageError("--emit", "has no work: all films are finished")
    return job_text(phases, manager)


def _print(films: list[BatchFilm], as_json: bool, as_csv: bool) -> None:
    from vidstyle.batch.report import counts_text, csv_text
    from vidstyle.cli.terminal.batch_display import summary_table

    if as_json:
        click.echo(json.dumps({"films": [film.as_dict() for film in films]}))
    elif as_csv:
        click.echo(csv_text(films), nl=False)
    else:
        click.echo("\n".join([*summary_table(films), counts_text(films)]))
