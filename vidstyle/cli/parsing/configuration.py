"""The user's configuration file: defaults of options, one table for each command.

[render]
style = "ink"
crf = 18
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from click.core import ParameterSource

from vidstyle.assets import configuration_folder
from vidstyle.cli.parsing.command import option
from vidstyle.cli.parsing.path_arguments import PATH_TEXT
from vidstyle.core.file_checks import parse_toml, read_toml_text
from vidstyle.errors import UsageError, suggest

CONFIGURATION_FILE = "config.toml"
MAX_FILE_BYTES = 64 * 1024
"""The largest configuration file, in bytes."""


def configuration_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --config, and takes defaults of options from the user's file without it."""

    def read(context: click.Context, _: click.Parameter, given: str | None) -> None:
        path = configuration_folder() / CONFIGURATION_FILE if given is None else Path(given)
        if given != "none" and (given or os.path.lexists(path)) and not context.resilient_parsing:
            context.default_map = read_configuration(path, context)

    text = (
        f"File with defaults for options.  [default: {CONFIGURATION_FILE} in the user's configuration folder]"
    )
    return option("--config", metavar="FILE|none", type=PATH_TEXT, callback=read,
                  expose_value=False, help=text)(command)  # fmt: skip


def configured_options() -> frozenset[str]:
    """Return the names of the parameters of this command that the configuration file has set."""
    context = click.get_current_context()
    return frozenset(
        name for name in context.params if context.get_parameter_source(name) is ParameterSource.DEFAULT_MAP
    )


def read_configuration(path: Path, context: click.Context) -> dict[str, dict[str, Any]]:
    """Return the defaults in a configuration file: for each command, values by the names of its parameters.

    Args:
        path: the file.
        context: of the group of commands.

    Raises:
        UsageError: the file cannot be read, or names what does not exist or cannot be.
    """
    text, tables = _parse(path)
    group = context.command
    assert isinstance(group, click.Group)
    defaults: dict[str, dict[str, Any]] = {}
    for name, table in tables.items():
        command = group.get_command(context, name)
        if command is None:
            hint = suggest(name, group.list_commands(context))
            raise _mistake(path, text, name, "", f"there is no command '{name}'; {hint}")
        if not isinstance(table, dict):
            raise _mistake(path, text, "", name, f"{name} is a command; write [{name}] above its options")
        options, defaults[name] = _options(command), {}
        below = click.Context(command, context, name)
        for key, value in table.items():
            if key not in options:
                hint = suggest(key, options)
                raise _mistake(path, text, name, key, f"{name} has no option '{key}'; {hint}")
            try:
                defaults[name][str(options[key].name)] = _default(options[key], value, below)
            except click.BadParameter as error:
                raise _mistake(path, text, name, key, f"{key}: {error.message.rstrip('.')}") from None
    return defaults


def _default(option: click.Option, value: Any, context: click.Context) -> Any:
    """Return a value of a configuration file as on the command line; a truth value is for flags only.

    Raises:
        BadParameter: the option does not take it.
    """
    values = value if option.multiple and isinstance(value, list) else [value]
    if not all(isinstance(each, str | int | float) for each in values):
        raise click.BadParameter("is not a text, a number or a truth value")
    if any("\0" in str(each) for each in values):
        raise click.BadParameter("contains a NUL character")
    if wrong := [each for each in values if isinstance(each, bool) != option.is_flag]:
        expected = "true or false" if option.is_flag else "a text or a number"
        raise click.BadParameter(f"{wrong[0]!r} is not {expected}")
    words = [each if isinstance(each, bool) else str(each) for each in values]
    default = words if option.multiple else words[0]
    option.type_cast_value(context, default)
    return default


def _options(command: click.Command) -> dict[str, click.Option]:
    """Return the options of a command by their long names."""
    options = (each for each in command.params if isinstance(each, click.Option))
    return {name[2:]: each for each in options for name in each.opts if name.startswith("--")}


def _parse(path: Path) -> tuple[str, dict[str, Any]]:
    """Return the text of a configuration file, and its tables."""
    text = ""
    try:
        text = read_toml_text(path, MAX_FILE_BYTES)
        return text, parse_toml(text)
    except ValueError as error:
        from vidstyle.style.locate import correct_word

        mended = correct_word(text, str(error))
        raise UsageError(path, mended[1] if mended else str(error)) from None


def _mistake(path: Path, text: str, table: str, key: str, reason: str) -> UsageError:
    """Return the error with the line number of a key, or of the table if the key is empty."""
    current = ""
    for number, line in enumerate(text.splitlines(), 1):
        found = re.match(r"\s*(\[)?\s*[\"']?([\w-]+)", line)
        current = found[2] if found and found[1] else current
        if found and current == table and (found[2] == key or not key):
            return UsageError(path, f"line {number}: {reason}")
    return UsageError(path, reason)
