"""Commands and options with grouped help, examples, and one value for each option."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from enum import Enum
from typing import Any

import click
from click.core import ParameterSource

from vidstyle.cli.parsing.foreign_names import check_names
from vidstyle.errors import UsageError

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

MAX_UNGROUPED = 15
"""The most options whose help is one list."""
MAX_NAME_WIDTH = 30
"""Characters of an option's names, beyond which its help begins on the next line."""
_GIVEN_KEY = "vidstyle.given"
"""Where a context keeps the options that the user has given, with their values as they were written."""


class Group(Enum):
    """The groups of options, in the order of the help."""

    INPUT = "Input"
    STYLE = "Style"
    KEY_FRAMES = "Key frames"
    PAGE_LAYOUT = "Page layout"
    LETTERING = "Lettering"
    RANDOM_STYLES = "Random styles"
    REFERENCE = "Reference filter and training pictures"
    FILTERS = "Learned filters"
    MEASUREMENT = "Measurement"
    OUTPUT = "Output"
    VIDEO = "Video encoding"
    AUDIO = "Audio"
    CONTROL = "Browser page and keyboard"
    DEVICE = "Device and threads"
    MESSAGES = "Messages and help"


class Option(click.Option):
    """An option that may be given once, or with `multiple` several times.

    Attributes:
        group: where the help lists it.
    """

    def __init__(self, *arguments: Any, group: Group = Group.MESSAGES, **declared: Any) -> None:
        super().__init__(*arguments, **declared)
        self.group = group

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        """Keep all values: click keeps the last one and discards the others silently."""
        if self.is_flag or self.multiple or self.count:
            super().add_to_parser(parser, ctx)
        else:
            parser.add_option(self, self.opts, self.name, action="append", nargs=self.nargs)

    def consume_value(self, ctx: click.Context, opts: Mapping[str, Any]) -> Any:
        """See click; the value is kept for `given_words`."""
        value, source = super().consume_value(ctx, opts)
        if source in (ParameterSource.COMMANDLINE, ParameterSource.DEFAULT_MAP):
            ctx.meta.setdefault(_GIVEN_KEY, {})[self] = value
        return value, source

    def handle_parse_result(self, ctx: click.Context, opts: Mapping[str, Any], args: list[str]) -> Any:
        """See click.

        Raises:
            UsageError: the option is given more than once.
        """
        given = opts.get(str(self.name))
        if isinstance(given, list) and not self.multiple:
            if len(given) > 1:
                values = " and ".join(repr(value) for value in given)
                name = max(self.opts, key=len)
                raise UsageError(name, f"is given more than once: {values}", "keep one of them")
            opts = {**opts, str(self.name): given[0]}
        return super().handle_parse_result(ctx, opts, args)


class Command(click.Command):
    """A command whose help has examples and, if it has many options, groups of them."""

    def __init__(self, *arguments: Any, examples: Sequence[str] = (), **declared: Any) -> None:
        """`examples`: lines of a shell."""
        super().__init__(*arguments, **declared)
        self.examples = examples

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """See click; names of options that other programs use are answered with ours."""
        if not ctx.resilient_parsing:
            check_names(self, ctx, args)
        return super().parse_args(ctx, args)

    def format_help_text(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        super().format_help_text(ctx, formatter)
        if self.examples:
            with formatter.section("Examples"):
                for line in self.examples:
                    formatter.write(f"{'':{formatter.current_indent}}{line}\n")

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, in groups if there are many."""
        records: list[tuple[Group, tuple[str, str]]] = []
        for each in self.get_params(ctx):
            if isinstance(each, click.Option) and (record := each.get_help_record(ctx)) is not None:
                records.append((getattr(each, "group", Group.MESSAGES), record))
        groups = {group.value: [record for own, record in records if own is group] for group in Group}
        if len(records) <= MAX_UNGROUPED:
            groups = {"Options": [record for _, record in records]}
        # All groups share the width of the first column.
        width = min(MAX_NAME_WIDTH, max(len(names) for _, (names, _) in records))
        for title, entries in groups.items():
            if entries:
                with formatter.section(title):
                    formatter.write_dl([(names.ljust(width), text) for names, text in entries])


def command(
    short_help: str, *, examples: Sequence[str] = (), epilog: str | None = None, help: str | None = None
) -> Callable[[Callable[..., Any]], Command]:
    """Declare a command; see `Command`. `help`: in place of the docstring."""
    declared = {} if help is None else {"help": help}
    return click.command(cls=Command, short_help=short_help, examples=examples, epilog=epilog, **declared)


def option(*names: str, group: Group = Group.MESSAGES, **declared: Any) -> Callable[[Any], Any]:
    """Declare an option; see `Option`."""
    return click.option(*names, cls=Option, group=group, **declared)


def given_words(context: click.Context, names: Collection[str]) -> list[str]:
    """Return the options that the user has given, as words of a command line.

    Args:
        names: of the parameters that are wanted.
    """
    words = []
    for each, value in context.meta.get(_GIVEN_KEY, {}).items():
        name = max(each.opts, key=len)
        if each.name in names and each.is_flag:
            words += [name] * bool(value)
        elif each.name in names:
            words += [f"{name}={one}" for one in (value if each.multiple else [value])]
    return words
