"""What goes to standard error: notices, and the one line for what went wrong. The only place that catches."""

from __future__ import annotations

import errno
import logging
import sys
import traceback
from types import TracebackType
from typing import Any

import click

from vidstyle.cli.standard_streams import flush_output, open_missing, print_error
from vidstyle.errors import OutputError, UsageError, VidstyleError, output_error, printable

USAGE = UsageError.exit_code
BUG = VidstyleError.exit_code


class Reporting(logging.Handler):
    """Within the block, notices become lines on standard error, and what is raised one line and an exit code.

    Attributes:
        debug: whether to show tracebacks too.
        exit_code: what the program is to end with.
    """

    def __init__(self) -> None:
        super().__init__()
        self.debug = False
        self.exit_code = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Print a notice. Standard error is looked up each time: a progress bar puts itself in its place."""
        if not getattr(record, "only_on_terminal", False) or sys.stderr.isatty():
            say(record.getMessage())

    def __enter__(self) -> Reporting:
        open_missing()
        logger = logging.getLogger("vidstyle")
        logger.addHandler(self)
        logger.setLevel(logging.INFO)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool:
        logging.getLogger("vidstyle").removeHandler(self)
        # click makes SystemExit of a broken pipe, and hides it from further flushes.
        error = flush_output(abandoned=isinstance(error, SystemExit)) or error
        if error is None:
            return False
        if self.debug:
            traceback.print_exception(error)
        self.exit_code, line = conclusion(error)
        say("; ".join([line, *getattr(error, "__notes__", [])]))
        return True


def conclusion(error: BaseException) -> tuple[int, str]:
    """The exit code and the line for what was raised."""
    match error:
        case VidstyleError():
            return error.exit_code, str(error)
        case click.UsageError():
            command = error.ctx.command_path if error.ctx else "vidstyle"
            return USAGE, printable(f"{error.format_message().rstrip('.')}; see {command} --help")
        case click.ClickException():
            return USAGE, printable(error.format_message())
        case click.Abort() | KeyboardInterrupt():
            return 130, "stopped"
        case OSError(errno=errno.ENOSPC | errno.EPIPE | errno.EBADF, filename=None):
            # Of a command that prints: whatever writes a file names it in an error of its own.
            return OutputError.exit_code, str(output_error("standard output", error))
    reason = printable(f"{type(error).__name__}: {error}")
    return BUG, f"a bug of ours: {reason}; run again with --debug and send us what it says"


def say(line: str) -> None:
    """Print a message on standard error."""
    print_error(f"vidstyle: {line}")


def _set_debug(context: click.Context, _: click.Parameter, value: bool) -> None:
    context.obj.debug = value


def _set_level(context: click.Context, _: click.Parameter, value: str) -> None:
    logging.getLogger("vidstyle").setLevel(value.upper())


def reporting_options(command: Any) -> Any:
    """Adds --log-level and --debug to a command."""
    levels = click.Choice(["debug", "info", "warning", "error"])
    debug = click.option(
        "--debug",
        is_flag=True,
        expose_value=False,
        callback=_set_debug,
        help="Show where an error came from.",
    )
    level = click.option(
        "--log-level", type=levels, default="info", show_default=True, expose_value=False,
        callback=_set_level, help="Which notices to show.",
    )  # fmt: skip
    return level(debug(command))
