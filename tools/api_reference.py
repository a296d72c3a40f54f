"""Make the API reference from docstrings: `python -m tools.api_reference [FOLDER]`.

One page for the public names of `vidstyle`, one for the filter blocks.
"""

from __future__ import annotations

import sys
import warnings
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType

import pdoc

import vidstyle
from vidstyle.block import Block
from vidstyle.blocks import all_blocks

DEFAULT_FOLDER = Path("build/api")


def format_block(block: Block) -> str:
    """Return a block as Markdown: its description, and a row for each parameter."""
    rows = [
        f"| `{name}` | {parameter.default!r} | {parameter.control.range_text} | {parameter.control.help} |"
        for name, parameter in block.parameters.items()
    ]
    table = ["", "| parameter | default | range | |", "|---|---|---|---|", *rows] if rows else []
    return "\n".join([f"## {block.name}", "", block.help, *table, ""])


def make_block_module() -> ModuleType:
    """Return an empty module whose docstring is the list of blocks."""
    sections = [format_block(block) for block in all_blocks().values()]
    module = ModuleType("blocks", "\n".join(["Filter blocks, the steps of a style.", "", *sections]))
    module.__spec__ = ModuleSpec("blocks", None)
    return module


def write_reference_pages(folder: Path) -> None:
    """Write the pages; warnings, such as broken links, are errors."""
    sys.modules["blocks"] = make_block_module()
    # pdoc omits names with underscores that are not marked as public.
    vidstyle.Renderer.__call__.__doc__ = f"{vidstyle.Renderer.__call__.__doc__}\n\n@public"
    pdoc.render.configure(
        docformat="google", show_source=False, footer_text=f"vidstyle {vidstyle.__version__}"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pdoc.pdoc("vidstyle", "!vidstyle.", "blocks", output_directory=folder)


if __name__ == "__main__":
    folder = Path(*sys.argv[1:]) if sys.argv[1:] else DEFAULT_FOLDER
    write_reference_pages(folder)
    print(folder / "index.html")
