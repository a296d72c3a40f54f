"""The options that say what raw video on standard input is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

from vidstyle.cli.values import Rate, Size
from vidstyle.media.raw_video import RawVideo


def raw_video_options(rate_help: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Adds them to a command; `rate_help`: what --input-fps is, which not only raw video may need."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(
            [
                click.option("--input-size", type=Size(), help="Size of raw video that comes in on '-'."),
                click.option(
                    "--input-pix-fmt",
                    metavar="NAME",
                    default=RawVideo.pix_fmt,
                    show_default=True,
                    help="Its pixel format.",
                ),
                click.option("--input-fps", type=Rate(), help=rate_help),
            ]
        ):
            command = option(command)
        return command

    return add


def raw_video(options: dict[str, Any]) -> RawVideo:
    """What they say."""
    return RawVideo(options["input_size"], options["input_pix_fmt"])
