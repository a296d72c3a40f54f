"""vidstyle styles: which looks there are, and what is in each."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import click

from vidstyle.cli.reporting import reporting_options


@click.command(short_help="List the styles; with a name, what is in it.")
@click.argument("name", required=False)
@click.option("--json", "as_json", is_flag=True, help="As JSON.")
@click.option("--schema", is_flag=True, help="Print the JSON Schema of style files, for editors.")
@reporting_options
def styles(name: str | None, as_json: bool, schema: bool) -> None:
    """List the styles; with a NAME or a style file, its steps and what can be set on them."""
    from vidstyle.style import describe, load_style, style_names, style_schema

    if schema:
        click.echo(json.dumps(style_schema(), indent=2))
    elif name is not None:
        described = describe(load_style(name))
        click.echo(json.dumps(described, indent=2) if as_json else "\n".join(_details(described)))
    elif as_json:
        click.echo(json.dumps([describe(load_style(each)) for each in style_names()], indent=2))
    else:
        for each in style_names():
            click.echo(f"{each:16} {load_style(each).note}".rstrip())


def _details(described: dict[str, Any]) -> Iterator[str]:
    layers = {key: value for key, value in described.items() if isinstance(value, list)}
    yield f"{described['name']}: {described['note']}" if described["note"] else described["name"]
    for key, value in described.items():
        if key not in layers and key not in ("name", "note"):
            yield f"  {key} = {json.dumps(value)}"
    for layer, steps in layers.items():
        for step in steps:
            yield from _step_details(layer, step)


def _step_details(layer: str, step: dict[str, Any]) -> Iterator[str]:
    names = "".join(f", {word} {step[word]}" for word in ("from", "save") if step[word])
    yield f"  {layer}: {step['block'] or 'no block'}{names}"
    for name, parameter in step["parameters"].items():
        value = json.dumps(parameter["value"])
        yield f"    {name} = {value:10} {parameter['help']} ({parameter['range']})"
