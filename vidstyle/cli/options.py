"""Option types and groups of options that several commands share."""

from __future__ import annotations

import re
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import click

from vidstyle.media.options import RawVideo


class Seconds(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """A time: seconds, or [hours:]minutes:seconds."""

    name = "time"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Fraction:
        if isinstance(value, Fraction):
            return value
        if not re.fullmatch(r"(\d+:){0,2}\d+(\.\d*)?", value):
            self.fail(f"{value!r} is not a time such as 12.5 or 1:02:03.5", param, ctx)
        seconds = Fraction(0)
        for part in value.split(":"):
            seconds = seconds * 60 + Fraction(part)
        return seconds


class Size(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """Width and height in pixels, as 1280x720; -1 for one keeps the aspect ratio, -2 makes it even too."""

    name = "WxH"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        if isinstance(value, tuple):
            return value
        match = re.fullmatch(r"(-[12]|[1-9]\d{0,4})[xX](-[12]|[1-9]\d{0,4})", value)
        if match is None or match[1] + match[2] in ("-1-1", "-1-2", "-2-1", "-2-2"):
            self.fail(f"{value!r} is not a size such as 1280x720", param, ctx)
        return int(match[1]), int(match[2])


class Rate(click.ParamType):  # type: ignore[type-arg, unused-ignore]  # generic since click 8.5
    """Frames per second: an integer, a decimal number or a fraction."""

    name = "rate"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Fraction:
        if isinstance(value, Fraction):
            return value
        if not re.fullmatch(r"\d+(\.\d+|/0*[1-9]\d*)?", value) or not 0 < Fraction(value) <= 1000:
            self.fail(f"{value!r} is not a rate such as 25, 23.976 or 30000/1001", param, ctx)
        return Fraction(value)


def raw_video_options(rate_help: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Adds the options that describe raw video on standard input; `rate_help` is that of --input-fps."""
    size = click.option("--input-size", type=Size(), help="Size of raw video on '-'.")
    pix_fmt = click.option("--input-pix-fmt", metavar="NAME", default=RawVideo.pix_fmt, show_default=True,
                           help="Pixel format of raw video on '-'.")  # fmt: skip
    rate = click.option("--input-fps", type=Rate(), help=rate_help)
    return lambda command: size(pix_fmt(rate(command)))


def raw_video(options: dict[str, Any]) -> RawVideo:
    """The values of `raw_video_options`."""
    return RawVideo(options["input_size"], options["input_pix_fmt"])
