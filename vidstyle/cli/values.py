"""Kinds of values on the command line."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import Any

import click


class Seconds(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """A time: seconds, or [hours:]minutes:seconds."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Fraction:
        """The time in seconds."""
        if isinstance(value, Fraction):
            return value
        if not re.fullmatch(r"(\d+:){0,2}\d+(\.\d*)?", value):
            self.fail(f"{value!r} is not a time such as 12.5 or 1:02:03.5", param, ctx)
        seconds = Fraction(0)
        for part in value.split(":"):
            seconds = seconds * 60 + Fraction(part)
        return seconds


class Size(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """A width and a height in pixels, as 1280x720; -1 for one keeps the shape, -2 makes it even too."""

    name = "WxH"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Width and height."""
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"(-[12]|[1-9]\d{0,4})[xX](-[12]|[1-9]\d{0,4})", value)
        if match is None or match[1] + match[2] in ("-1-1", "-1-2", "-2-1", "-2-2"):
            self.fail(f"{value!r} is not a size such as 1280x720", param, ctx)
        return int(match[1]), int(match[2])


class Rate(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """Frames per second, a whole, decimal or broken number."""

    name = "rate"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Fraction:
        """The exact rate."""
        if isinstance(value, Fraction):
            return value
        if not re.fullmatch(r"\d+(\.\d+|/0*[1-9]\d*)?", value) or not 0 < Fraction(value) <= 1000:
            self.fail(f"{value!r} is not a rate such as 25, 23.976 or 30000/1001", param, ctx)
        return Fraction(value)
