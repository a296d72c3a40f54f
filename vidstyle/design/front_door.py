"""What the page of `vidstyle open` may open besides itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

OpenPage = Callable[[str | None], str]
"""Opens another page on the file of the clip, or None for a camera; returns its address."""


@dataclass(frozen=True)
class FrontDoor:
    """The ways from the page to other programs.

    Attributes:
        pages: opens other pages of vidstyle, by name.
        reveal: shows a file in its folder; None without a desktop.
        cancel: stops making the documents that `pages` makes.
    """

    pages: Mapping[str, OpenPage] = field(default_factory=dict)
    reveal: Callable[[Path], None] | None = None
    cancel: Callable[[], None] = lambda: None

    def describe(self) -> dict[str, Any]:
        """Return the message for the page."""
        return {"pages": list(self.pages), "reveal": self.reveal is not None}
