"""vidstyle doctor: versions and devices, for bug reports."""

from __future__ import annotations

import json
from typing import Any

import click

from vidstyle.cli.reporting import reporting_options

LINE = f"\n{'':21}"
"""Separator between the lines of an entry."""


@click.command(short_help="Print versions and devices, for bug reports.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
@reporting_options
def doctor(as_json: bool) -> None:
    """Print versions, encoders, devices and cameras. Include this in bug reports."""
    from vidstyle.doctor import diagnose

    facts = diagnose()
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
