"""The filter blocks: each module of this package declares the block of the same name."""

from __future__ import annotations

import pkgutil
from collections import UserDict
from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Any

from vidstyle.block import Block


class _Blocks(UserDict[str, Any]):
    """Imports a block at first access, so that a style loads only the blocks that it uses."""

    def __getitem__(self, name: str) -> Block:
        block: Block = self.data[name] or getattr(import_module(f"{__name__}.{name}"), name)
        self.data[name] = block
        return block


@cache
def all_blocks() -> Mapping[str, Block]:
    """Return all blocks by name, sorted by name."""
    return _Blocks(dict.fromkeys(sorted(module.name for module in pkgutil.iter_modules(__path__))))
