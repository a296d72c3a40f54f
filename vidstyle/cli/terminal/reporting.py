"""Messages on standard error, exit codes, and standard streams that are closed, full or abandoned.

The only place that catches all exceptions.
"""

from __future__ import annotations

import errno
import json
import logging
import os
import sys
import traceback
from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import TracebackType
from typing import Any, TextIO

import click

from vidstyle.cli.parsing.command import option
from vidstyle.errors import (
    OutputError,
    StyleError,
    UsageError,
    VidstyleError,
    is_out_of_memory,
    log,
    output_error,
    printable,
)
from vidstyle.pipeline.stopping import StoppedError

USAGE_EXIT_CODE = UsageError.exit_code
BUG_EXIT_CODE = VidstyleError.exit_code

_LACK_OF_MEMORY = (
    "not enough memory; close other programs, use a smaller picture, "
    "or raise the limits (ulimit -v, ulimit -u)"
)

ALWAYS_SHOWN_LEVEL = logging.CRITICAL + 1
"""The level of what the user has asked for, which --log-level does not hide."""


class Reporting(logging.Handler):
    """Within the block, notices are printed on standard error; exceptions become one line and an exit code.

    Attributes:
        as_json: whether to print objects of JSON, a line each, with `event` and `text`.
        debug: whether to show tracebacks too.
        exit_code: exit code of the program.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        super().__init__()
        # Also where the command line cannot be read further.
        self.as_json = ("--progress", "json") in pairwise(arguments) or "--progress=json" in arguments
        self.debug = False
        self.exit_code = 0
        self._once: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Print a notice.

        Args:
            record: with `only_on_terminal` or `only_for_people` if it is of use to a waiting person or to a
                reader of a log only, `once` if the command does not repeat it, or `event` and `facts` if
                it is more than a text.
        """
        text = record.getMessage()
        if getattr(record, "only_on_terminal", False) and not sys.stderr.isatty():
            return
        if getattr(record, "only_for_people", False) and self.as_json:
            return
        if getattr(record, "once", False):
            if text in self._once:
                return
            self._once.add(text)
        self._print(getattr(record, "event", "notice"), text, getattr(record, "facts", {}))

    def _print(self, event: str, text: str, facts: Mapping[str, object]) -> None:
        if self.as_json:
            print_error(json.dumps({"event": event} | ({"text": text} if text else {}) | dict(facts)))
        elif text:
            print_error(f"vidstyle: {text}")

    def __enter__(self) -> Reporting:
        open_missing()
        log.addHandler(self)
        log.setLevel(logging.INFO)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        log.removeHandler(self)
        # click makes SystemExit of a broken pipe, which it hides from further flushes, and of a completion.
        completed = isinstance(error, SystemExit) and not error.code
        abandoned = isinstance(error, SystemExit) and not completed
        error = flush_output(abandoned) or (None if completed else error)
        if error is None:
            return completed
        self.exit_code, lines = conclusion(error)
        if self.debug:
            self._print_trace("".join(traceback.format_exception(error)))
        for line in [*lines[:-1], "; ".join([lines[-1], *getattr(error, "__notes__", [])])]:
            self._print("error", line, {"exit_code": self.exit_code})
        return True

    def _print_trace(self, trace: str) -> None:
        print_error(json.dumps({"event": "traceback", "text": trace}) if self.as_json else trace.rstrip())


def conclusion(error: BaseException) -> tuple[int, list[str]]:
    """Return the exit code and the message for an exception: one line, or one for each mistake of a style."""
    if is_out_of_memory(error) and not isinstance(error, OutputError):
        return OutputError.exit_code, [_LACK_OF_MEMORY]
    match error:
        case StyleError():
            return error.exit_code, [str(StyleError(error.subject, [each])) for each in error.mistakes]
    exit_code, line = _conclusion(error)
    return exit_code, [line]


def _conclusion(error: BaseException) -> tuple[int, str]:
    match error:
        case VidstyleError():
            return error.exit_code, str(error)
        case click.UsageError():
            return USAGE_EXIT_CODE, printable(_usage(error))
        case click.ClickException():
            return USAGE_EXIT_CODE, printable(error.format_message())
        case StoppedError() | KeyboardInterrupt():
            return getattr(error, "exit_code", 130), "stopped"
        case OSError(errno=errno.ENOSPC | errno.EPIPE | errno.EBADF, filename=None):
            # Only commands that print get here: a function that writes a file names it in its error.
            return OutputError.exit_code, str(output_error("standard output", error))
    reason = printable(f"{type(error).__name__}: {error}")
    return BUG_EXIT_CODE, f"internal error: {reason}; please report this as a bug, with the output of --debug"


def _usage(error: click.UsageError) -> str:
    """Return the message of an error in the command line."""
    command = f"see {error.ctx.command_path if error.ctx else 'vidstyle'} --help"
    match error:
        case click.NoSuchOption():
            near = " or ".join(f"'{each}'" for each in error.possibilities or ())
            hint = f"did you mean {near}?" if near else command
            return f"there is no option '{error.option_name}'; {hint}"
        case click.BadOptionUsage():
            return f"{error.option_name} needs a value; {command}"
        case click.MissingParameter(param=click.Argument() as argument, ctx=click.Context() as context):
            return f"{argument.make_metavar(context)} is missing; {command}"
        case click.BadParameter(param=click.Option() as option):
            return f"{max(option.opts, key=len)}: {error.message.rstrip('.')}"
    return f"{error.format_message().rstrip('.')}; {command}"


def say(line: str, summary: Mapping[str, object] | None = None) -> None:
    """Print a message on standard error; with --progress json a summary, if there is one, in its place."""
    if summary is None:
        log.log(ALWAYS_SHOWN_LEVEL, "%s", line)
    else:
        event("summary", summary, line)


def event(name: str, facts: Mapping[str, object], text: str = "") -> None:
    """Print an event as JSON with --progress json, else its text."""
    log.log(ALWAYS_SHOWN_LEVEL, "%s", text, extra={"event": name, "facts": facts})


def reporting_options(command: Any) -> Any:
    """Add --log-level and --debug to a command."""

    def set_debug(context: click.Context, _: click.Parameter, value: bool) -> None:
        context.obj.debug = value

    def set_level(context: click.Context, _: click.Parameter, value: str) -> None:
        log.setLevel(value.upper())

    levels = click.Choice(["debug", "info", "warning", "error"])
    debug = option("--debug", is_flag=True, expose_value=False, callback=set_debug,
                   help="Show a traceback on errors.")  # fmt: skip
    level = option("--log-level", type=levels, default="info", expose_value=False,
                   callback=set_level, help="Lowest level of notices to show.")  # fmt: skip
    return level(debug(command))


def open_missing() -> None:
    """Open the streams that the caller closed (`>&-`).

    Otherwise the next file to be opened would get a standard descriptor, and FFmpeg's messages would end up
    in a film. Reading gives nothing, writing standard output is an error, and messages are lost.
    """
    for number, (name, mode, flags) in enumerate(
        [("stdin", "r", os.O_RDONLY), ("stdout", "w", os.O_RDONLY), ("stderr", "w", os.O_WRONLY)]
    ):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
            setattr(sys, name, open(number, mode, encoding="utf-8", closefd=False))


def flush_output(abandoned: bool = False) -> OutputError | None:
    """Flush standard output; return the error if that fails.

    Python would do it after `main` has returned, and turn any failure into exit code 120.

    Args:
        abandoned: whether its reader is known to have gone.
    """
    try:
        if abandoned:
            raise BrokenPipeError(errno.EPIPE, os.strerror(errno.EPIPE))
        sys.stdout.flush()
    except OSError as error:
        _discard(sys.stdout)
        return output_error("standard output", error)
    return None


def print_error(line: str) -> None:
    """Print a line on standard error; if that fails, there is nobody to tell.

    `sys.stderr` is looked up each time: a progress bar replaces it.
    """
    try:
        print(line, file=sys.stderr, flush=True)
    except OSError:
        _discard(sys.stderr)


def _discard(stream: TextIO) -> None:
    """Discard what the stream still holds and all that follows."""
    with open(os.devnull, "wb") as nowhere:
        os.dup2(nowhere.fileno(), stream.fileno())
    stream.flush()
