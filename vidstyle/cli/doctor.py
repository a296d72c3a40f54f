"""vidstyle doctor: what this machine has."""

from __future__ import annotations

import json
from typing import Any

import click

from vidstyle.cli.reporting import reporting_options

LINE = f"\n{'':21}"
"""Between the lines of a fact that has several."""


@click.command(short_help="Say what this machine has: for bug reports.")
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@reporting_options
def doctor(as_json: bool) -> None:
    """Say which versions, encoders, devices and cameras are here: put it into a bug report."""
    from vidstyle.doctor import examine

    facts = examine()
    if as_json:
        click.echo(json.dumps(facts, indent=2))
    else:
        for name, fact in facts.items():
            click.echo(f"{name:20} {_text(fact)}")


def _text(fact: Any) -> str:
    if isinstance(fact, dict):
        return LINE.join(f"{name}: {_text(value)}" for name, value in fact.items())
    if isinstance(fact, list):
        separator = LINE if any(", " in str(value) for value in fact) else ", "
        return separator.join(map(str, fact)) or "none"
    return str(fact)
