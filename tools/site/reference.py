"""Generated pages of the site: styles, blocks and commands."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

import click

from tools.api_reference import format_block
from tools.pictures.gallery import PHOTOGRAPHS
from tools.site.documents import ROOT, copy_picture
from vidstyle.block import Block
from vidstyle.blocks import all_blocks
from vidstyle.cli import commands
from vidstyle.errors import VidstyleError
from vidstyle.export.page import page_data
from vidstyle.gallery.style_samples import style_of_block
from vidstyle.style import PLAIN, Style, describe, load_style, style_names

SAMPLE_WIDTH_PX = 240
STEPS_WIDTH_PX = 640
GALLERY_FOLDER = ROOT / "docs" / "gallery"


def write_reference(pages: Path) -> list[dict[str, Any]]:
    """Write a page for each style, each block and the commands, and return their navigation entries."""
    names = [name for name in style_names() if name != PLAIN]
    for folder in ("styles", "blocks"):
        (pages / folder).mkdir()
    for name in names:
        _write(pages / "styles" / f"{name}.md", _style_page(load_style(name), pages))
    _write(pages / "styles" / "index.md", _style_list(names))
    examples = {style.name for style in block_examples()}
    for block in all_blocks().values():
        _write(pages / "blocks" / f"{block.name}.md", _block_page(block, examples))
    _write(pages / "blocks" / "index.md", _block_list())
    _write(pages / "options.md", _command_page())
    return [
        {"Styles": ["styles/index.md", *({name: f"styles/{name}.md"} for name in names)]},
        {"Blocks": ["blocks/index.md", *({name: f"blocks/{name}.md"} for name in all_blocks())]},
        {"Reference": [{"Options of all commands": "options.md"}, {"Python": "api/index.html"}]},
    ]


def block_examples() -> list[Style]:
    """Return a style for each block that runs in a browser; all parameters are knobs."""
    return [style for block in all_blocks().values() if _is_exportable(style := _example_of(block))]


def _example_of(block: Block) -> Style:
    style = style_of_block(block)
    knobs = tuple(f"{block.name}.{name}" for name in block.parameters)
    return replace(style, name=f"block-{block.name}", knobs=knobs, steady=0.0, note=block.help)


def _is_exportable(style: Style) -> bool:
    try:
        return bool(page_data(style)["controls"])
    except VidstyleError:
        return False


def _write(path: Path, lines: Iterator[str]) -> None:
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _sample(style: str, photograph: str, pages: Path) -> str:
    address = copy_picture(GALLERY_FOLDER / f"{style}-{photograph}.jpg", pages, SAMPLE_WIDTH_PX)
    return f'<img src="../{address}" alt="{style}: {photograph}" loading="lazy">'


def _style_page(style: Style, pages: Path) -> Iterator[str]:
    name = style.name
    yield f"# {name}\n\n{style.note}\n"
    yield f"[Try it on your own picture](../try/index.html#{name}){{ .md-button }}\n"
    yield f"```sh\nvidstyle render in.mp4 out.mp4 --style {name}\n```\n"
    yield '<div class="pictures">'
    yield from (_sample(name, photograph, pages) for photograph in PHOTOGRAPHS)
    yield "</div>\n"
    if style.variants:
        yield "## Variants\n\n" + ", ".join(f"`{name}:{variant}`" for variant in style.variants) + "\n"
    steps = copy_picture(GALLERY_FOLDER / f"{name}-steps.jpg", pages, STEPS_WIDTH_PX)
    graph = copy_picture(GALLERY_FOLDER / f"{name}.svg", pages)
    yield f"## Step by step\n\n![{name}, step by step](../{steps})\n"
    yield f"## Graph\n\n![The graph of {name}](../{graph})\n"
    yield "## Steps\n\n| layer | block | values |\n|---|---|---|"
    described = describe(style)
    for layer in style.layers:
        for step in described[layer]:
            values = ", ".join(f"{key} = {each['value']}" for key, each in step["parameters"].items())
            block = f"[{step['block']}](../blocks/{step['block']}.md)" if step["block"] else ""
            yield f"| {layer} | {block} | {escape(values).replace('|', '&#124;')} |"


def _style_list(names: list[str]) -> Iterator[str]:
    yield "# Styles\n\n[Try all of them on your own picture](../try/index.html){ .md-button }\n"
    yield '<div class="styles" markdown>'
    for name in names:
        picture = f"../pictures/{name}-astronaut-small.webp"
        yield f"[![{name}]({picture})]({name}.md) [**{name}**]({name}.md) {load_style(name).summary}\n"
    yield "</div>"


def _block_page(block: Block, examples: set[str]) -> Iterator[str]:
    yield format_block(block).replace("## ", "# ", 1)
    if (name := f"block-{block.name}") in examples:
        address = f"../try/index.html?embed#{name}"
        yield f'<iframe class="example" src="{address}" loading="lazy" title="{block.name}"></iframe>\n'
    used = [name for name in style_names() if block.name in {step.block for step in load_style(name).steps}]
    if used:
        yield "Used in " + ", ".join(f"[{name}](../styles/{name}.md)" for name in used) + "."


def _block_list() -> Iterator[str]:
    yield "# Blocks\n\nStyles consist of these filter blocks.\n\n| block | |\n|---|---|"
    for name, block in all_blocks().items():
        yield f"| [{name}]({name}.md) | {block.help} |"


def _command_page() -> Iterator[str]:
    yield "# Options of all commands\n"
    context = click.Context(commands, info_name="vidstyle")
    for name in commands.list_commands(context):
        command = commands.get_command(context, name)
        if command is None or command.hidden:
            continue
        shown = command.get_help(click.Context(command, info_name=name, parent=context))
        yield f"## {name}\n\n```text\n{shown}\n```\n"
