"""What the page of `vidstyle open` may open besides itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Report = Callable[[str], None]
"""Called with the progress of a document in words."""
OpenPage = Callable[[str | None, Report], str]
"""Opens another page, or makes a document, of the clip or a camera (None); returns its address."""


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
