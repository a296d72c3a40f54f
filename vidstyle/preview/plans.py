"""Plans for the renderer in a page (`export/runner/runner.js`): the structure once, then only numbers."""

from __future__ import annotations

from typing import Any

from vidstyle.gpu.compile.es import EsPlan
from vidstyle.style import Style


def plan_message(style: Style, width: int, height: int) -> dict[str, Any]:
    """Return the message with the whole plan of a style for 8-bit pictures of this size.

    Returns:
        `key`, a text that is the same for all plans that differ only in `values`; `values`; and `plan`.

    Raises:
        StyleError: the style cannot be used.
    """
    return PlanSender().message(style, width, height)


class PlanSender:
    """Remembers which plans a page has, so that each is sent once."""

    def __init__(self) -> None:
        self._sent: set[str] = set()

    def message(self, style: Style, width: int, height: int) -> dict[str, Any]:
        """Return `plan_message`, without `plan` where the page has it already."""
        plan = EsPlan.of(style, width, height)
        message = {"key": plan.key, "values": plan.values}
        if plan.key in self._sent:
            return message
        self._sent.add(plan.key)
        return message | {"plan": plan.data}
