"""Characters that cannot be drawn, and that XML cannot hold."""

from __future__ import annotations

import re
from html import escape

from vidstyle.errors import printable

_CONTROL_PATTERN = re.compile(r"[\x00-\x08\x0a-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufffe\uffff]")
"""Control characters except tabs, ends of lines, lone surrogates, and noncharacters (XML 1.0, 2.2).

Pillow draws no line that holds an end of a line."""


def control_character(text: str) -> str:
    r"""Return the first control character of a text, escaped; empty if there is none.

    >>> print(control_character("a\x1b[31mb"))
    \x1b
    """
    found = _CONTROL_PATTERN.search(text)
    return printable(found[0]) if found else ""


def replace_control(text: str) -> str:
    """Return the text with U+FFFD in place of control characters."""
    return _CONTROL_PATTERN.sub("\ufffd", text)


def xml_text(text: str) -> str:
    """Return the text for an XML document: control characters replaced, marks escaped."""
    return escape(replace_control(text))
