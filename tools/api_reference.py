"""Makes the API reference out of docstrings: `python -m tools.api_reference [FOLDER]`.

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


def block_section(block: Block) -> str:
    """A block as Markdown: what it does, and a row for each parameter."""
    rows = [
        f"| `{name}` | {parameter.default!r} | {parameter.control.range_text} | {parameter.control.help} |"
        for name, parameter in block.parameters.items()
    ]
    table = ["", "| parameter | default | range | |", "|---|---|---|---|", *rows] if rows else []
    return "\n".join([f"## {block.name}", "", block.help, *table, ""])


def block_list() -> ModuleType:
    """A module without names, whose docstring is the list of blocks."""
    sections = [block_section(block) for block in all_blocks().values()]
    module = ModuleType("blocks", "\n".join(["Filter blocks, the steps of a style.", "", *sections]))
    module.__spec__ = ModuleSpec("blocks", None)
    return module


def make(folder: Path) -> None:
    """Write the pages; a warning, such as a link to nothing, is an error."""
    sys.modules["blocks"] = block_list()
    # pdoc leaves out what has underscores unless it is told so.
    vidstyle.Renderer.__call__.__doc__ = f"{vidstyle.Renderer.__call__.__doc__}\n\n@public"
    pdoc.render.configure(
        docformat="google", show_source=False, footer_text=f"vidstyle {vidstyle.__version__}"
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pdoc.pdoc("vidstyle", "!vidstyle.", "blocks", output_directory=folder)


if __name__ == "__main__":
    folder = Path(*sys.argv[1:]) if sys.argv[1:] else DEFAULT_FOLDER
    make(folder)
    print(folder / "index.html")
