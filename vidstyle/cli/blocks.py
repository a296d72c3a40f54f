"""vidstyle blocks: list the filter blocks, or describe one."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import click

from vidstyle.cli.parsing.command import command, option
from vidstyle.cli.parsing.common_options import BLOCK
from vidstyle.cli.terminal.display import list_entry
from vidstyle.cli.terminal.reporting import reporting_options
from vidstyle.errors import UsageError

if TYPE_CHECKING:
    from vidstyle.block import Block
    from vidstyle.block.absent_effects import AbsentEffect


@command(
    "List the filter blocks, or describe one.",
    examples=("vidstyle blocks", "vidstyle blocks flow_dog", "vidstyle blocks outline"),
)
@click.argument("name", required=False, type=BLOCK)
@option("--json", "as_json", is_flag=True, help="Print JSON, with the JSON Schema of each parameter.")
@reporting_options
def blocks(name: str | None, as_json: bool) -> None:
    """List the filter blocks that styles consist of, or describe the parameters of NAME.

    Any other word lists the blocks that it describes, best match first.
    """
    from vidstyle.block.absent_effects import find_absent_effect
    from vidstyle.block.search import find_blocks, suggest_block
    from vidstyle.blocks import all_blocks

    if name is not None and name in all_blocks():
        block = all_blocks()[name]
        click.echo(json.dumps(_as_dict(block), indent=2) if as_json else _details(block))
        return
    found = [all_blocks()[each] for each in find_blocks(name or "", all_blocks())]
    if not found:
        absent = find_absent_effect(str(name))
        hint = _advice(absent) if absent else suggest_block(str(name), all_blocks())
        raise UsageError(name, f"there is no block '{name}'", hint)
    if as_json:
        click.echo(json.dumps([_as_dict(block) for block in found], indent=2))
    else:
        click.echo("\n".join(_list(found) if name else _list_by_category(found)))


def _advice(effect: AbsentEffect) -> str:
    from vidstyle.blocks import all_blocks
    from vidstyle.style.model import FIELDS

    labels = [all_blocks()[name].label for name in effect.nearest]
    fields = [FIELDS[name].label for name in effect.values]
    return f"{effect.advice} Closest: {', '.join(labels + fields)}"


def _list_by_category(found: Sequence[Block]) -> Iterator[str]:
    from vidstyle.block import CATEGORIES

    for category, heading in CATEGORIES.items():
        yield f"\n{heading}"
        yield from _list([block for block in found if block.category == category])


def _list(found: Sequence[Block]) -> Iterator[str]:
    for block in found:
        yield list_entry(f"{block.name:16} {block.label:22}", block.help)


def _details(block: Block) -> str:
    lines = [f"{block.label}: {block.name} ({block.kind}, works on {block.on})", block.help]
    if block.aliases:
        lines.append(f"Also found as: {', '.join(block.aliases)}.")
    for parameter in block.parameters.values():
        control = parameter.control
        lines.append(f"  {parameter.name} = {json.dumps(parameter.default)}")
        lines.append(f"      {parameter.label}: {control.help} ({control.range_text})")
    return "\n".join(lines)


def _as_dict(block: Block) -> dict[str, Any]:
    facts = {
        name: getattr(block, name) for name in ("name", "label", "category", "aliases", "kind", "on", "help")
    }
    return facts | {"parameters": {name: each.schema() for name, each in block.parameters.items()}}
