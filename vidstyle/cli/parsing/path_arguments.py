"""Paths of inputs and outputs, as arguments and as options."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from itertools import combinations
from pathlib import Path
from typing import Any

import click

from vidstyle.cli.parsing.command import Decorator, Group, option
from vidstyle.errors import OutputError

PATH = click.Path(path_type=Path, readable=False)
PATH_TEXT = click.Path(readable=False)
"""Types of names of files. What cannot be read is reported where it is opened, as an unusable input."""

PATH_OPTIONS = {"source": (Group.INPUT, "-i", "--input"), "target": (Group.OUTPUT, "-o", "--output")}
"""The group and the names of the options that give what the arguments of these names give."""


def path_arguments(several_films: str = "", **metavars: str) -> Decorator:
    """Add arguments that may be given as options too, in any mixture.

    Args:
        several_films: a hint for a user who gives too many arguments, which are films.
        metavars: how the help calls each argument, one of `PATH_OPTIONS`; in brackets it may be missing.
    """
    words = " ".join(metavars.values())

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def run(words_given: tuple[str, ...], **options: Any) -> Any:
            given = {name: options.pop(name) for name in metavars}
            open_names = [name for name in metavars if given[name] is None]
            given |= zip(open_names, words_given, strict=False)
            for word in words_given[len(open_names) :]:
                hint = several_films if _are_films(words_given[:2]) else ""
                raise click.UsageError(f"unexpected argument {word!r}; {hint or _quoting_hint(words_given)}")
            for name, metavar in metavars.items():
                if given[name] is None and not metavar.startswith("["):
                    raise click.UsageError(f"{metavar} is missing")
            return command(**{name: path for name, path in given.items() if path is not None}, **options)

        for name, metavar in reversed(metavars.items()):
            text, (group, *names) = f"Same as the {metavar.strip('[]')} argument.", PATH_OPTIONS[name]
            run = option(*names, name, metavar="PATH", type=PATH_TEXT, group=group, help=text)(run)
        return click.argument("words_given", metavar=words, nargs=-1, type=PATH_TEXT)(run)

    return add


def _are_films(words: Sequence[str]) -> bool:
    from vidstyle.batch.inputs import is_film_name

    return all(os.path.isfile(word) and is_film_name(os.path.basename(word)) for word in words)


def _quoting_hint(words: Sequence[str]) -> str:
    """Return a hint about words that the shell split or expanded, based on existing files."""
    for first, last in combinations(range(len(words) + 1), 2):
        name = " ".join(words[first:last])
        if last - first > 1 and os.path.lexists(name):
            return f"put a name with spaces in quotes: '{name}'"
    if all(os.path.lexists(word) for word in words[:2]):
        return "put a pattern such as 'frames/*.png' in quotes"
    return "put a name with spaces in quotes, such as 'my film.mp4'"


def parents_option(*targets: str) -> Decorator:
    """Add --parents, which makes the folders of the paths in these parameters of the command."""

    def add(command: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(command)
        def run(parents: bool, **options: Any) -> Any:
            given = [options.get(target) for target in targets]
            paths = [path for each in given for path in (each if isinstance(each, tuple) else (each,))]
            with made_folders([str(path) for path in paths if path is not None and parents]):
                return command(**options)

        text = "Create missing folders of the output."
        return option("--parents", is_flag=True, group=Group.OUTPUT, help=text)(run)

    return add


@contextmanager
def made_folders(targets: Iterable[str]) -> Iterator[None]:
    """Create the folders of the targets, and remove those that remain empty.

    A target that ends in a slash is a folder itself; a URL has none.

    Raises:
        OutputError: one cannot be made.
    """
    made: list[Path] = []
    for target in targets:
        folder = Path(target) if target.endswith(("/", os.sep)) else Path(target).parent
        if "://" in target:
            continue
        made += [each for each in (folder, *folder.parents) if not each.exists()]
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise OutputError(folder, f"cannot be created ({error.strerror})") from None
    try:
        yield
    finally:
        for folder in made:
            with suppress(OSError):  # it holds something
                folder.rmdir()
