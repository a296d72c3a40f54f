"""vidstyle doctor: versions and devices, for bug reports."""

from __future__ import annotations

import json
from typing import Any

import click

from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.parsing.common_options import threads_option
from vidstyle.cli.terminal.reporting import reporting_options

LINE_SEPARATOR = f"\n{'':21}"
"""Separator between the lines of an entry."""


@command("Print versions and devices, for bug reports.")
@option("--json", "as_json", is_flag=True, help="Print JSON.")
@threads_option
@reporting_options
def doctor(as_json: bool) -> None:
    """Print versions, cores, encoders, devices and cameras. Include the output in bug reports."""
    from vidstyle.doctor import diagnose

    facts = diagnose()
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        for name, fact in facts.items():
            click.echo(f"{name:20} {_text(fact)}")


def _text(fact: Any) -> str:
    if isinstance(fact, dict):
        return LINE_SEPARATOR.join(f"{name}: {_text(value)}" for name, value in fact.items())
    if isinstance(fact, list):
        separator = LINE_SEPARATOR if any(", " in str(value) for value in fact) else ", "
        return separator.join(map(str, fact)) or "none"
    return str(fact)
