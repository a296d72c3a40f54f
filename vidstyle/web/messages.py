"""Messages from a page, declared by methods: the signature of a method is the schema of its message."""

from __future__ import annotations

import inspect
import json
from collections.abc import Awaitable, Callable, Collection, Mapping
from dataclasses import dataclass
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints, overload

MAX_TEXT_CHARACTERS = 200
"""Default maximum length of a string."""
MAX_INTEGER = 2**53
"""Integers up to this are exact in JavaScript."""

Check = Callable[[object], bool]
"""Returns whether a field has the right type and range."""
Answer = dict[str, Any] | None
"""The fields of the answer to a message."""


class MessageError(Exception):
    """An invalid message, which no page of ours sends."""


def number_between(low: float, high: float) -> Check:
    """Return a check for numbers within low..high."""
    return lambda value: (
        isinstance(value, int | float) and not isinstance(value, bool) and low <= value <= high
    )


def integer_between(low: int, high: int) -> Check:
    """Return a check for integers within low..high."""
    return lambda value: isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def text_between(low: int, high: int) -> Check:
    """Return a check for strings of low..high characters."""
    return lambda value: isinstance(value, str) and low <= len(value) <= high


def one_of(options: Collection[object]) -> Check:
    """Return a check for the elements of a collection."""
    return lambda value: value in list(options)


def is_value(value: object) -> bool:
    """Whether it is a short string, a number or a boolean."""
    return isinstance(value, int | float) or (isinstance(value, str) and len(value) <= MAX_TEXT_CHARACTERS)


FractionField = Annotated[float, number_between(0, 1)]
TextOrEmpty = Annotated[str, text_between(0, MAX_TEXT_CHARACTERS)]
"""A string that may be empty; a field of type `str` may not."""
AnyValue = Annotated[Any, is_value]
"""A string, a number or a boolean; the parameter of a style checks its range later."""

CHECKS: Mapping[object, Check] = {
    int: integer_between(0, MAX_INTEGER - 1),
    float: number_between(-MAX_INTEGER, MAX_INTEGER),
    bool: lambda value: isinstance(value, bool),
    str: text_between(1, MAX_TEXT_CHARACTERS),
    type(None): lambda value: value is None,
}
"""The checks of fields without `Annotated`."""


def check_of(hint: Any) -> Check:
    """Return the check that the type of a field declares.

    Raises:
        KeyError: the type declares none.

    >>> check_of(Literal["a", "b"])("c"), check_of(int | None)(None), check_of(FractionField)(0.5)
    (False, True, True)
    """
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return hint.__metadata__[0]  # type: ignore[no-any-return]
    if origin is Literal:
        return lambda value: value in arguments
    if origin in (Union, UnionType):
        checks = [check_of(argument) for argument in arguments]
        return lambda value: any(check(value) for check in checks)
    return CHECKS[hint]


def fields_of(function: Callable[..., Any], first: int = 1) -> dict[str, Check]:
    """Return the fields that a function declares by its parameters, from number `first` on."""
    hints = get_type_hints(function, include_extras=True)
    return {name: check_of(hints[name]) for name in list(inspect.signature(function).parameters)[first:]}


@dataclass(frozen=True)
class Message:
    """A kind of message that a page may send.

    Attributes:
        handle: handles the message of a connection; its keyword arguments are the fields. A field named `id`
            is the number of the message.
        fields: the checks of the fields, all of which are required.
        in_background: whether later messages are handled before it is done.
    """

    handle: Callable[..., Awaitable[Answer]]
    fields: Mapping[str, Check]
    in_background: bool = False


Method = Callable[..., Awaitable[Answer]]


@overload
def message(method: Method) -> Message: ...
@overload
def message(*, in_background: bool) -> Callable[[Method], Message]: ...
def message(method: Method | None = None, *, in_background: bool = False) -> Any:
    """Declare a method of a `PageConnection` as the message of the same name.

    >>> @message
    ... async def bypass(self, on: bool) -> None: ...
    >>> list(bypass.fields)
    ['on']
    """
    if method is None:
        return lambda other: Message(other, fields_of(other), in_background)
    return Message(method, fields_of(method))


class RateLimit:
    """Limits the number of messages per second.

    >>> limit = RateLimit(1, lambda: 0.0)
    >>> limit.count()
    >>> limit.count()
    Traceback (most recent call last):
    vidstyle.web.messages.MessageError: more than 1 messages in a second
    """

    def __init__(self, most: int, now: Callable[[], float]) -> None:
        """`most`: maximum number of messages in each second of the clock `now`."""
        self._most, self._now = most, now
        self._second, self._count = int(now()), 0

    def count(self) -> None:
        """Count a message.

        Raises:
            MessageError: the limit of this second is exceeded.
        """
        second = int(self._now())
        self._count = self._count + 1 if second == self._second else 1
        self._second = second
        if self._count > self._most:
            raise MessageError(f"more than {self._most} messages in a second")


def read_message(text: str | bytes, kinds: Mapping[str, Message]) -> tuple[Message, int, dict[str, Any]]:
    """Parse and validate a message; return its kind, its number, and the arguments for its handler.

    Raises:
        MessageError: the text is not a message of one of these kinds.

    >>> kinds = {"bypass": Message(None, {"on": CHECKS[bool]})}
    >>> read_message('{"do": "bypass", "id": 1, "on": true}', kinds)[1:]
    (1, {'on': True})
    >>> read_message('{"do": "bypass", "id": 1, "on": 1}', kinds)
    Traceback (most recent call last):
    vidstyle.web.messages.MessageError: bypass: on has the wrong type or range
    """
    try:
        found = json.loads(text) if isinstance(text, str) else None
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise MessageError("not a JSON object")
    do = found.pop("do", None)
    if not isinstance(do, str) or do not in kinds:
        raise MessageError("unknown kind of message")
    checks = {**kinds[do].fields, "id": CHECKS[int]}
    if found.keys() != checks.keys():
        raise MessageError(f"{do}: takes {', '.join(checks)}")
    for name, check in checks.items():
        if not check(found[name]):
            raise MessageError(f"{do}: {name} has the wrong type or range")
    return kinds[do], found["id"], {name: found[name] for name in kinds[do].fields}
