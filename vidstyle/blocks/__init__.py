"""The filter blocks: each module of this package declares a block of its own name."""

from __future__ import annotations

import pkgutil
from functools import cache
from importlib import import_module

from vidstyle.block import Block


@cache
def all_blocks() -> dict[str, Block]:
    """Every block by name, in the order of the names."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    return {name: getattr(import_module(f"{__name__}.{name}"), name) for name in names}
