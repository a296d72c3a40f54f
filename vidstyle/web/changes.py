"""Incremental updates: the difference between two JSON values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

Path = tuple[str | int, ...]


def changes(before: Any, after: Any, path: Path = ()) -> Iterator[tuple[Path, Any]]:
    """Yield the differences between `before` and `after`: path and new value.

    A shortened list yields a change of its "length", as in JavaScript.

    >>> list(changes({"a": [1, 2, 3], "b": 0}, {"a": [1, 5], "b": 0}))
    [(('a', 'length'), 2), (('a', 1), 5)]
    """
    if isinstance(before, dict) and isinstance(after, dict) and before.keys() == after.keys():
        for key, value in after.items():
            yield from changes(before[key], value, (*path, key))
    elif isinstance(before, list) and isinstance(after, list):
        if len(after) < len(before):
            yield (*path, "length"), len(after)
        for index, value in enumerate(after):
            if index < len(before):
                yield from changes(before[index], value, (*path, index))
            else:
                yield (*path, index), value
    elif before != after or type(before) is not type(after):
        yield path, after
