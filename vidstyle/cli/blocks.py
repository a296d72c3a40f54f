"""vidstyle blocks: list the filter blocks, or describe one."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.parsing.common_options import BLOCK
from vidstyle.cli.terminal.display import list_entry
from vidstyle.cli.terminal.reporting import reporting_options
from vidstyle.errors import UsageError, suggest

if TYPE_CHECKING:
    from vidstyle.block import Block


@command("List the filter blocks, or describe one.", examples=("vidstyle blocks", "vidstyle blocks flow_dog"))
@click.argument("name", required=False, type=BLOCK)
@option("--json", "as_json", is_flag=True, help="Print JSON, with the JSON Schema of each parameter.")
@reporting_options
def blocks(name: str | None, as_json: bool) -> None:
    """List the filter blocks that styles consist of, or describe the parameters of NAME."""
    from vidstyle.blocks import all_blocks

    if name is not None:
        if name not in all_blocks():
            raise UsageError(name, f"there is no block '{name}'", suggest(name, all_blocks()))
        block = all_blocks()[name]
        click.echo(json.dumps(_as_dict(block), indent=2) if as_json else _details(block))
    elif as_json:
        click.echo(json.dumps([_as_dict(block) for block in all_blocks().values()], indent=2))
    else:
        for block in all_blocks().values():
            click.echo(list_entry(f"{block.name:16} {block.kind:8}", block.help))


def _details(block: Block) -> str:
    lines = [f"{block.name} ({block.kind}, works on {block.on})", block.help]
    for parameter in block.parameters.values():
        control = parameter.control
        lines.append(f"  {parameter.name} = {json.dumps(parameter.default)}")
        lines.append(f"      {control.help} ({control.range_text})")
    return "\n".join(lines)


def _as_dict(block: Block) -> dict[str, Any]:
    facts = {name: getattr(block, name) for name in ("name", "kind", "on", "help")}
    return facts | {"parameters": {name: each.schema() for name, each in block.parameters.items()}}
