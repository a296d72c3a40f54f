"""Page files of `comic`, cue files and configuration files, with odd values and edits."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from random import Random
from typing import Any

import click
import tomlkit

from tools.fuzzing.damage import ODD_VALUES, WORDS, edit_text
from vidstyle.cli import commands

PANEL = {
    "time": 1,
    "window": [20.0, 0.0, 120.0, 120.0],
    "place": [10, 40, 150, 230],
    "picture": [14, 44, 146, 226],
    "leans": [0, 16],
    "words": [
        {"text": "Good\nmorning.", "kind": "balloon", "size": 12, "place": [20, 50, 90, 90], "tip": [60, 120]}
    ],
}
LABEL = {"text": "A title", "at": [160.0, 30.0], "size": 20, "bold": True}
PAGE_FILE: dict[str, Any] = {
    "format": 1,
    "source": "pictures",
    "title": "A title",
    "styles": ["plain", "ink"],
    "dpi": 100.0,
    "reading": "ltr",
    "font": "built-in",
    "page": [
        {
            "size": [320, 240],
            "panel": [
                PANEL,
                PANEL | {"place": [160, 40, 310, 230], "picture": [164, 44, 306, 226], "time": 2},
            ],
            "label": [LABEL],
        }
    ],
}
"""A comic page of two panels, as written by `comic --save`."""
CUE_FILE: dict[str, Any] = {
    "format": 1,
    "rate": 24,
    "scenes": [0, 0.1, 0.2],
    "cue": [
        {"time": 0, "style": "ink", "values": {"strength": 0, "ink": "#101030"}, "curve": "ease"},
        {"time": "00:00:00:03", "values": {"strength": 1}, "transition": "fade", "seconds": 0.05},
        {"scene": 3, "style": "poster", "transition": "wipe", "seconds": 0.05},
    ],
}
"""Three cues of a film of 0.3 s."""
LONG_WORDS = ("w" * 5000, "w" * 100_000, "\x07", "\x00", "\x1b[31m", "\ud7ff", "a b " * 5000)
ODD_SIZES = (0, -1, 64, 65, 20_000, 2**14, 2**17, 200_000, 2**31, 10**30, 1e308)


def page_case(random: Random) -> tuple[str, bytes]:
    """Return the page file of a comic."""
    table = deepcopy(PAGE_FILE)
    _change_values(random, table, (*ODD_VALUES, *LONG_WORDS, *ODD_SIZES, [], [[]], [1, 2]))
    if random.random() < 0.1:
        table["page"] *= random.choice((2, 50))
    return ".page.toml", _written(random, table)


def cue_case(random: Random) -> tuple[str, bytes]:
    """Return a cue file."""
    table = deepcopy(CUE_FILE)
    odd: tuple[object, ...] = (
        0.05,
        0.1,
        0.15,
        1e-9,
        10**7,
        "0:0.1",
        "00:00:00:23",
        "9:9:9",
        "linear",
        "fade",
        "noir",
        [],
        [0],
    )
    _change_values(random, table, (*ODD_VALUES, *LONG_WORDS, *odd), (0, 0, 0, 0, 0.01, -0.01))
    if random.random() < 0.1:
        table["cue"] *= random.choice((2, 50, 400))
    return ".cues.toml", _written(random, table)


def config_case(random: Random) -> tuple[str, bytes]:
    """Return a configuration file with random options of random commands, some of another type."""
    context, table = click.Context(commands), dict[str, Any]()
    for name in ("render", *random.sample(commands.list_commands(context), random.choice((0, 0, 2)))):
        command = commands.get_command(context, name)
        assert command is not None
        options = {each[2:]: option for option in command.params for each in option.opts if each[:2] == "--"}
        chosen = random.sample(list(options), min(len(options), random.choice((1, 1, 2, 4))))
        table[name] = {key: _option_value(random, options[key].type) for key in chosen}
    return ".config.toml", _written(random, table)


def _option_value(random: Random, kind: click.ParamType) -> Any:
    if random.random() < 0.4:
        return random.choice((*ODD_VALUES, *LONG_WORDS, *WORDS, ["x=1"]))
    if isinstance(kind, click.Choice):
        return random.choice(kind.choices)
    return random.choice((0, 1, 2.5, 18, True, False, "plain", "none", "1", "64x48", "libx264"))


def _change_values(
    random: Random,
    table: dict[str, Any],
    odd: tuple[Any, ...],
    shifts: tuple[float, ...] = (-20, -1, 0, 1, 0.25, 5),
) -> None:
    """Shift numbers, and replace or repeat values, at any depth."""
    for _ in range(random.choice((1, 2, 10))):
        holder, key = random.choice(
            [place for place in _places(table) if isinstance(place[0][place[1]], float | int)]
        )
        holder[key] += random.choice(shifts)
    for _ in range(random.choice((0, 0, 1, 1, 2))):
        holder, key = random.choice(list(_places(table)))
        if random.random() < 0.1:
            holder[key] = [holder[key]] * random.choice((1, 3, 400))
        else:
            holder[key] = random.choice(odd)


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield the container and key of each value in a table, at any depth."""
    keys = list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield value, key
        yield from _places(value[key])


def _written(random: Random, table: dict[str, Any]) -> bytes:
    try:
        text = tomlkit.dumps(table)
    except RecursionError:  # tomlkit reads deeper nesting than it writes
        text = random.choice(_bombs(random))
    if random.random() < 0.1:
        text = random.choice(_bombs(random)) + text
    return edit_text(random, text) if random.random() < 0.25 else text.encode("utf-8", "replace")


def _bombs(random: Random) -> list[str]:
    """Return short texts that cost a parser much time, memory or stack."""
    depth = random.choice((50, 1000, 5000, 20_000, 400_000))
    return [
        f"x = {'[' * depth}{']' * depth}\n",
        f"x = {'{a=' * depth}1{'}' * depth}\n",
        f"{'.'.join('a' * min(depth, 20_000))} = 1\n",
        f"[{'.'.join('a' * min(depth, 20_000))}]\n",
        f"x = {'9' * depth}\n",
        f"x = 0x{'f' * depth}\n",
        f"x = 1e{'9' * min(depth, 400)}\n",
        f"x = 1979-05-27T07:32:00.{'9' * depth}Z\n",
        "".join(f"a{number}.b = 1\n" for number in range(min(depth, 5000))),
        f"# {'x' * 3 * depth}\n",
    ]
