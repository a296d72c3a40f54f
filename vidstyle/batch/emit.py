"""Writes a batch as a job for another scheduler: OpenJD, Slurm or a shell."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from vidstyle.batch.batch import BatchOptions, film_words
from vidstyle.batch.batch_film import BatchFilm
from vidstyle.batch.division import Division
from vidstyle.batch.film_checks import parts_of
from vidstyle.batch.processes import Processes
from vidstyle.batch.stored_path import argument_of
from vidstyle.errors import OutputError, UsageError

OPENJD_VERSION = "jobtemplate-2023-09"

Phases = list[list[str]]
"""Phases of shell commands: the commands of a phase may run in parallel, after the previous phase."""


def job_phases(films: Sequence[BatchFilm], options: BatchOptions) -> Phases:
    """Find the segments of long films, and return the commands that render all films.

    Args:
        films: films with absolute paths; finished films are skipped.

    Raises:
        VidstyleError: a film cannot be read, or its name cannot be written in a job.
    """
    segments, films_to_end = [], []
    for film in films:
        if film.has_ended:
            continue
        words = film_words(film, options)
        if options.every is not None:
            segments += _segment_commands(film, options, words)
        every = [] if options.every is None else [f"--segment={options.every}"]
        replaces = ["--overwrite"] * options.overwrite
        # It skips finished films, joins segments, and updates the journal.
        films_to_end.append(
            ["batch", argument_of(film.source.path), *words[1:], *every, *replaces, "--jobs=1"]
        )
    phases = [[_command(words) for words in phase] for phase in (segments, films_to_end)]
    return [phase for phase in phases if phase]


def job_text(phases: Phases, manager: str) -> str:
    """Return a job with these phases for a scheduler: "openjd", "slurm" or "shell"."""
    if manager == "openjd":
        return json.dumps(_openjd_job(phases), indent=2)
    if manager == "slurm":
        return _slurm_script(phases)
    return "\n".join(command for phase in phases for command in phase)


def _segment_commands(film: BatchFilm, options: BatchOptions, words: list[str]) -> list[list[str]]:
    """Return the commands for the missing segments; none if the film cannot be divided."""
    division = Division(film, {**parts_of(film), "threads": str(options.threads)}, str(options.every), 1)
    division.scratch.parent.mkdir(parents=True, exist_ok=True)
    with division.locked():
        outcome = division.prepare(words, Processes().run)
        if outcome.exit_code:
            raise OutputError(film.target, outcome.error)
        missing = division.missing_segments()
        if not missing:
            division.remove()
    return [division.segment_words(words, segment) for segment in missing]


def _command(words: Sequence[str]) -> str:
    command = shlex.join(["vidstyle", "--config=none", *words])
    if "{" in command or "\n" in command:  # braces are fields of --output, and of OpenJD
        raise UsageError("--emit", f"{command!r} cannot be a line of a job", "rename the film")
    return command


def _cases(phase: Sequence[str], number: str) -> str:
    """Return a script that runs the command with this number, a shell expression."""
    cases = [f"  {index}) exec {command} ;;" for index, command in enumerate(phase)]
    return "\n".join([f'case "{number}" in', *cases, "esac", ""])


def _openjd_job(phases: Phases) -> dict[str, Any]:
    names = ["Segments", "Films"][-len(phases) :]
    steps = [
        {
            "name": name,
            **({"dependencies": [{"dependsOn": names[0]}]} if name != names[0] else {}),
            "parameterSpace": {
                "taskParameterDefinitions": [
                    {"name": "Number", "type": "INT", "range": f"0-{len(phase) - 1}"}
                ]
            },
            "script": {
                "embeddedFiles": [{"name": "Commands", "type": "TEXT", "data": _cases(phase, "$1")}],
                "actions": {
                    "onRun": {
                        "command": "sh",
                        "args": ["{{Task.File.Commands}}", "{{Task.Param.Number}}"],
                    }
                },
            },
        }
        for name, phase in zip(names, phases, strict=True)
    ]
    return {"specificationVersion": OPENJD_VERSION, "name": "vidstyle batch", "steps": steps}


def _slurm_script(phases: Phases) -> str:
    """Return a script that submits one array per phase, which waits for the previous array."""
    lines = ["#!/bin/sh", "# Run this script: it submits the jobs.", "set -e"]
    for index, phase in enumerate(phases):
        after = ' --dependency="afterok:$job"' if index else ""
        lines += [
            f"job=$(sbatch --parsable --array=0-{len(phase) - 1}{after} <<'END'",
            "#!/bin/sh",
            _cases(phase, "$SLURM_ARRAY_TASK_ID") + "END",
            ")",
        ]
    return "\n".join(lines)


def absolute_film(film: BatchFilm) -> BatchFilm:
    """Return a film with absolute paths, for a job that runs in another folder."""
    source = replace(film.source, path=film.source.path.absolute())
    style = ",".join(_absolute_style(each) for each in film.style.split(","))
    return replace(film, source=source, target=film.target.absolute(), style=style)


def _absolute_style(style: str) -> str:
    path, ending, variant = style.strip().partition(".toml")
    return os.path.abspath(path) + ending + variant if ending else style
