"""Hints for the names of options that users of FFmpeg and HandBrake know."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence

import click

from vidstyle.errors import UsageError

FOREIGN_NAMES = {
    "--start 1:30": "-ss --start-at",
    "--end 1:40": "-to -t --stop-at",
    "--duration 10": "-t",
    "--frames 100": "-frames:v -frames -vframes",
    "--codec libx265": "-c:v -c -codec:v -codec -vcodec -e --encoder",
    "--bitrate 4000000": "-b:v -b -vb --vb",
    "--crf 20": "-crf -cq -qp -q -q:v -qscale -qscale:v --quality -b:v -b -vb --vb",
    "--preset slow": "-preset --encoder-preset",
    "--pix-fmt yuv420p": "-pix_fmt",
    "--audio none": "-an",
    "--audio aac": "-c:a -codec:a -acodec -E --aencoder",
    "--fps 25": "-r -r:v --rate",
    "--input-fps 25": "-framerate",
    "--size 1280x-2": "-w -l -X -Y --width --height --maxWidth --maxHeight",
    "--style ink": "-vf -filter:v -filter -filter_complex -lavfi",
    "--format nut": "-f",
    "--loop": "-loop -stream_loop",
    "--rotate 90": "-display_rotation",
    "--rotate 0": "-noautorotate",
    "--hwaccel cuda": "-hwaccel",
    "--threads 2": "-threads",
    "--log-level warning": "-loglevel -v -hide_banner",
    "--progress none": "-nostats",
    "--progress plain": "-stats",
}
"""Our options, with a value, and the names of FFmpeg and HandBrake for what they do, the best match first."""
KNOWN_FOREIGN_NAMES = frozenset(name for names in FOREIGN_NAMES.values() for name in names.split())


def check_names(command: click.Command, context: click.Context, arguments: Sequence[str]) -> None:
    """Reject names of options that the command does not have, with the option to use instead.

    click would read `-ss` as the option -s with the value "s".

    Raises:
        UsageError: the command has an option for what the name means in FFmpeg or HandBrake.
        click.NoSuchOption: it has none, or a word such as `-movflags` begins with no option.
    """
    declared = [each for each in command.get_params(context) if isinstance(each, click.Option)]
    options = {name: each for each in declared for name in each.opts}
    for word, following in _option_words(options, arguments):
        name = word.partition("=")[0]
        if name == "-s" and "--size" in options and _is_size(following):
            raise UsageError(name, "is for styles", f"use --size {following}")
        if name in options:
            continue
        if ours := _our_option(name, options):
            raise UsageError(name, f"there is no option '{name}'", f"use {ours}")
        if name in KNOWN_FOREIGN_NAMES or word[1] != "-" and word[:2] not in options:
            raise click.NoSuchOption(name, ctx=context)


def _our_option(name: str, options: Mapping[str, click.Option]) -> str:
    """Our option for a name of another program, with a value and its help; "" if the command has none."""
    for ours, names in FOREIGN_NAMES.items():
        option = options.get(ours.split()[0])
        if option is not None and name in names.split():
            text = (option.help or "").partition("  [")[0].rstrip(".")
            return f"{ours} ({text[:1].lower()}{text[1:]})"
    return ""


def _option_words(options: Mapping[str, click.Option], arguments: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield the words that begin with a dash and are not values, each with the word after it."""
    is_value = False
    for word, following in zip(arguments, [*arguments, ""][1:], strict=True):
        if is_value or not word.startswith("-") or word == "-":
            is_value = False
            continue
        if word == "--":
            return
        option = options.get(word)
        is_value = option is not None and not option.is_flag
        yield word, following


def _is_size(text: str) -> bool:
    return re.fullmatch(r"-?\d+[xX]-?\d+", text) is not None and not os.path.lexists(text)
