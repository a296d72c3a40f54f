"""Plans for the renderer in a page (`export/runner/runner.js`): numbers apart from what stays."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from vidstyle.gpu.compile.es import es_plan
from vidstyle.style import Style


def plan_message(style: Style, width: int, height: int) -> dict[str, Any]:
    """The plan of a style for 8-bit pictures of this size.

    Returns:
        `key`, a text that is the same for all plans that differ in `values` alone; `values`; and `plan`, the
        whole plan, values included.

    Raises:
        StyleError: the style cannot be used.
    """
    plan = es_plan(style, width, height)
    structure = {name: part for name, part in plan.items() if name != "values"}
    text = json.dumps(structure, sort_keys=True, separators=(",", ":"))
    key = hashlib.sha256(text.encode()).hexdigest()[:24]
    return {"key": key, "values": plan["values"], "plan": plan}


class PlanSender:
    """Remembers which plans a page has, so that each is sent once."""

    def __init__(self) -> None:
        self._sent: set[str] = set()

    def message(self, style: Style, width: int, height: int) -> dict[str, Any]:
        """As `plan_message`, without `plan` where the page has it already."""
        message = plan_message(style, width, height)
        if message["key"] in self._sent:
            del message["plan"]
        self._sent.add(message["key"])
        return message
