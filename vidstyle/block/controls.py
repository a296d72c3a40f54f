"""Parameters of blocks and the base class of their controls."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from random import Random
from typing import Any, ClassVar, Literal


@dataclass(frozen=True)
class Labelled:
    """A value with a name in plain words.

    Attributes:
        label: the name, understandable without its block; empty for the name of the parameter.
        aliases: other words by which people search it.
    """

    _: KW_ONLY
    label: str = ""
    aliases: tuple[str, ...] = ()


def label_of_name(name: str) -> str:
    """Return the label of a parameter or block without one.

    >>> label_of_name("gap_color")
    'Gap color'
    """
    return name.replace("_", " ").capitalize()


def distinct_labels(labels: Sequence[str]) -> list[str]:
    """Number the labels that occur more than once.

    >>> distinct_labels(["Tile size", "Gap width", "Tile size"])
    ['Tile size 1', 'Gap width', 'Tile size 2']
    """
    return [
        f"{label} {labels[: place + 1].count(label)}" if labels.count(label) > 1 else label
        for place, label in enumerate(labels)
    ]


class Control(Labelled, ABC):
    """A kind of value; a new one needs a subclass, and a function in `export/modules/controls.js`.

    Attributes:
        help: one line, without a full stop.
        changes_structure: whether a change of value may require different passes, kernels or files.
        takes_text: whether a value is text, which needs no quotes on the command line.
        picks: the kind of its options if they depend on the style: saved pictures or files.
    """

    help: str
    changes_structure: ClassVar[bool] = True
    takes_text: ClassVar[bool] = True
    picks: ClassVar[Literal["", "picture", "file"]] = ""

    @property
    @abstractmethod
    def range_text(self) -> str:
        """The allowed values, as text."""

    @abstractmethod
    def check(self, value: object, is_integer: bool) -> Any:
        """Return the value in its proper type.

        Raises:
            ValueError: it is invalid; the message names the valid values.
        """

    @abstractmethod
    def schema(self, is_integer: bool) -> dict[str, Any]:
        """Return the JSON Schema of the values."""

    @abstractmethod
    def describe(self, is_integer: bool, saved: list[str]) -> dict[str, Any]:
        """Return what a page needs to show the control: its kind, and its range or options.

        Args:
            saved: the saved pictures that the parameter may name.
        """

    @abstractmethod
    def draw(self, random: Random, default: Any, is_integer: bool) -> Any:
        """Return a random value from the range for random styles, or the default if no range is declared."""

    @abstractmethod
    def is_drawn(self, value: Any) -> bool:
        """Whether `draw` can return the value."""

    @abstractmethod
    def draw_near(self, random: Random, value: Any, spread: float, is_integer: bool) -> Any:
        """Return a random value near another one.

        Args:
            spread: the standard deviation relative to the value.
        """

    def text(self, value: Any) -> str:
        """Return the value in the syntax of the command line."""
        return str(value)

    def argument(self, value: Any) -> Any:
        """Return the argument of the block's function for a value."""
        return value

    def scale(self, value: Any, growth: float, values: Mapping[str, Any], fineness: float = 1) -> Any:
        """Return the value for pictures that are larger by a factor.

        Args:
            value: the value.
            growth: the factor.
            values: all values of the step.
            fineness: level of detail (focus) by which lengths are divided, up to their own maximum.
        """
        return value

    def between(self, one: Any, other: Any, share: float, is_integer: bool) -> Any:
        """Return the value at a share of the way from one value to another; most kinds jump at its end."""
        return other if share >= 1 else one

    def own_file(self, value: Any) -> str:
        """Return the path of the user's file that a value names, or an empty text."""
        return ""


class OptionControl(Control):
    """A control whose random values are listed in `explore`."""

    explore: tuple[Any, ...] = ()

    def draw(self, random: Random, default: Any, is_integer: bool) -> Any:
        return random.choice(self.explore) if self.explore else default

    def is_drawn(self, value: Any) -> bool:
        return value in self.explore

    def draw_near(self, random: Random, value: Any, spread: float, is_integer: bool) -> Any:
        return random.choice(self.explore) if self.explore and random.random() < spread / 2 else value


@dataclass(frozen=True)
class Parameter:
    """A named value with its control and default."""

    name: str
    control: Control
    default: Any
    is_integer: bool = False

    @property
    def label(self) -> str:
        """Its name in plain words."""
        return self.control.label or label_of_name(self.name)

    def named(self, label: str, help: str = "") -> Parameter:
        """Return the parameter with another label, and other help if it is given."""
        control = replace(
            self.control,  # type: ignore[type-var]
            label=label,
            help=help or self.control.help,  # type: ignore[call-arg]
        )
        return replace(self, control=control)

    def check(self, value: object) -> Any:
        """Return the value in its proper type.

        Raises:
            ValueError: it is invalid; the message names the valid values.
        """
        return self.control.check(value, self.is_integer)

    def schema(self) -> dict[str, Any]:
        """Return its JSON Schema, with help and default."""
        described = {"title": self.label, "description": self.control.help, "default": self.default}
        return self.control.schema(self.is_integer) | described

    def between(self, one: Any, other: Any, share: float) -> Any:
        """Return the value at a share, 0..1, of the way from one value to another."""
        return self.control.between(one, other, share, self.is_integer)

    def describe(self, saved: list[str]) -> dict[str, Any]:
        """Return what a page needs to show the parameter; `saved`: the saved pictures that it may name."""
        described = self.control.describe(self.is_integer, saved)
        return described | {"label": self.label, "help": self.control.help}

    def draw(self, random: Random) -> Any:
        """Return a random value, from the range that suits random styles."""
        return self.control.draw(random, self.default, self.is_integer)

    def draw_near(self, random: Random, value: Any, spread: float) -> Any:
        """Return a random value near another one; `spread`: the standard deviation relative to it."""
        return self.control.draw_near(random, value, spread, self.is_integer) if spread else value
