"""The program `vidstyle`: each command is a module of this package, imported when it is called."""

from __future__ import annotations

import pkgutil
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import click

import vidstyle
from vidstyle.cli.browser import is_wanted
from vidstyle.cli.parsing.configuration import configuration_option
from vidstyle.cli.terminal.reporting import Reporting
from vidstyle.errors import UsageError, suggest
from vidstyle.pipeline.stopping import on_signals, raise_stopped

CONTEXT = {"help_option_names": ["-h", "--help"], "show_default": True}
"""Settings of all commands."""


class CommandGroup(click.Group):
    """Finds commands: modules of this package that declare a command with the name of the module."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        names = sorted(module.name for module in pkgutil.iter_modules(__path__))
        return [name for name in names if self.get_command(ctx, name) is not None]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        if not any(module.name == name for module in pkgutil.iter_modules(__path__)):
            return None
        command = getattr(import_module(f"{__name__}.{name}"), name, None)
        return command if isinstance(command, click.Command) else None

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """See click; the error has a suggestion."""
        name = args[0]
        if not (ctx.resilient_parsing or name.startswith("-")) and self.get_command(ctx, name) is None:
            raise UsageError(name, f"there is no command '{name}'", suggest(name, self.list_commands(ctx)))
        return super().resolve_command(ctx, args)


FIRST_STEPS = """\b
First steps:
  vidstyle demo                                 # makes a film and restyles it
  vidstyle render demo/film.mp4 ink.mp4 -s ink  # or any film or picture
"""


@click.command(cls=CommandGroup, context_settings=CONTEXT, invoke_without_command=True, epilog=FIRST_STEPS)
@click.version_option(vidstyle.__version__, prog_name="vidstyle")
@configuration_option
@click.pass_context
def commands(context: click.Context) -> None:
    """Restyle video in real time."""
    if context.invoked_subcommand is not None:
        return
    if is_wanted(no_open=False):
        click.echo("Opening a page in the browser; `vidstyle --help` lists the commands.", err=True)
        context.invoke(context.command.get_command(context, "open"))  # type: ignore[attr-defined]
    else:
        click.echo(context.get_help())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the program and return its exit code (docs/rules.md, Exit codes).

    Args:
        arguments: the command line without the program's name; None uses the command line of this process.
    """
    reporting = Reporting(sys.argv[1:] if arguments is None else arguments)
    with reporting, on_signals(raise_stopped):
        result = commands.main(
            None if arguments is None else list(arguments),
            prog_name="vidstyle",
            standalone_mode=False,
            obj=reporting,
        )
        reporting.exit_code = result or 0
    return reporting.exit_code
