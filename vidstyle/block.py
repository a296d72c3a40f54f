"""What a block is: a decorated function whose parameters declare themselves.

A parameter is annotated with its control (`Slider`, `Choice`, `Switch`, `Color`, `SavedRef` or
`Asset`), which holds its range, unit and help; its default is the function's own. A parameter
annotated with one of the `Given` types is filled in by the runner instead of the user.
Everything else, from the command line to the JSON Schema, is derived from here.
"""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NewType, cast, get_args, get_origin, get_type_hints

import numpy as np

Kind = Literal["pixel", "filter", "measured", "resize", "learned", "recipe"]
"""How a block reaches its result (docs/rules.md, Blocks).

The function of all but four takes an array and returns one. That of a recipe returns a list of blocks
with their values; that of a learned block a bank and how it is to run, an object with `radius`, `scale` and
`run(luma, margin)`; that of a resize block takes a (height, width) and returns the new one, while the
runner resamples as its parameters `method` and `back` say; a measured block's parameter `settle`, in
seconds, is how fast its numbers follow.
"""

On = Literal["luma", "color", "channels"]
"""What a block works on: luma alone; RGB; or "channels", each channel by itself, so that it runs on
luma while the picture is gray and on R, G and B otherwise."""


@dataclass(frozen=True)
class Slider:
    """A number between two ends; a whole one where the parameter is annotated `int`.

    Attributes:
        low, high: the ends, both allowed.
        help: one line, without a full stop.
        unit: "px" for lengths on the page, "s", "degrees", "levels of 255" and so on.
        explore: the ends between which a random style chooses; None: it keeps the default.
    """

    low: float
    high: float
    help: str
    unit: str = ""
    explore: tuple[float, float] | None = None

    def check(self, value: object, whole: bool) -> int | float:
        """The value as a number in range, or ValueError saying what would be right."""
        number = not isinstance(value, bool) and isinstance(value, int | float) and math.isfinite(value)
        if not number or (whole and value != int(cast(float, value))):
            raise ValueError(f"{value!r} is not a {'whole ' if whole else ''}number")
        value = cast(float, value)
        if not self.low <= value <= self.high:
            raise ValueError(f"{value:g} is outside {self.range_text}")
        return int(value) if whole else float(value)

    @property
    def range_text(self) -> str:
        """The range and unit, for people: "0.5 to 8 px"."""
        return f"{self.low:g} to {self.high:g} {self.unit}".rstrip()

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        kind = "integer" if whole else "number"
        return {"type": kind, "minimum": self.low, "maximum": self.high}


@dataclass(frozen=True)
class Choice:
    """One of a few words."""

    options: tuple[str, ...]
    help: str
    explore: tuple[str, ...] = ()

    def check(self, value: object, whole: bool) -> str:
        """The value if it is one of the options, or ValueError."""
        if value not in self.options:
            raise ValueError(f"{value!r} is not one of {self.range_text}")
        return str(value)

    @property
    def range_text(self) -> str:
        """The options, for people."""
        return ", ".join(self.options)

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        return {"enum": list(self.options)}


@dataclass(frozen=True)
class Switch:
    """On or off."""

    help: str
    explore: tuple[bool, ...] = ()
    range_text = "true or false"

    def check(self, value: object, whole: bool) -> bool:
        """The value if it is a truth value, or ValueError."""
        if not isinstance(value, bool):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        return {"type": "boolean"}


@dataclass(frozen=True)
class Color:
    """A colour written "#rrggbb"; the block gets it as three floats 0..1."""

    help: str
    explore: tuple[str, ...] = ()
    range_text = "#rrggbb"

    def check(self, value: object, whole: bool) -> str:
        """The value if it reads as a colour, or ValueError."""
        if not (isinstance(value, str) and re.fullmatch("#[0-9a-fA-F]{6}", value)):
            raise ValueError(f"{value!r} is not a colour such as #1a2b3c")
        return value.lower()

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        return {"type": "string", "pattern": "^#[0-9a-fA-F]{6}$"}


@dataclass(frozen=True)
class SavedRef:
    """The name of a picture that an earlier step saved, or "source"; the block gets the picture's array.

    Attributes:
        on: what the block wants of it: "luma" for H x W, "same" for the channels of its own input,
            "chroma" when the runner is to put that picture's chroma to the result and the block gets None.
        optional: an empty name means none; the block gets None.
    """

    help: str
    on: Literal["luma", "same", "chroma"] = "same"
    optional: bool = False
    range_text = "the name of a saved picture, or source"

    def check(self, value: object, whole: bool) -> str:
        """The value if it can be a name, or ValueError. Whether it was saved is the style's to check."""
        if value == "" and self.optional:
            return ""
        if not (isinstance(value, str) and re.fullmatch(NAME_PATTERN, value)):
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        return {"type": "string", "pattern": f"^({NAME_PATTERN})?$" if self.optional else f"^{NAME_PATTERN}$"}


@dataclass(frozen=True)
class Asset:
    """A file or folder inside the style's own folder; empty means none, and the block gets None.

    Attributes:
        read: turns the checked path into what the block gets; called once for each style, and
            raises ValueError with a reason when the content will not do.
        shipped: names the files that come with vidstyle, which a style may name without their ending.
    """

    help: str
    read: Callable[[Path], object]
    shipped: Callable[[], dict[str, Path]] = dict
    range_text = "a path inside the style's folder"

    def check(self, value: object, whole: bool) -> str:
        """The value if it is a plain relative path, or ValueError. Existence is the style's to check."""
        if not isinstance(value, str):
            raise ValueError(f"{value!r} is not {self.range_text}")
        parts = Path(value).parts
        if Path(value).is_absolute() or ".." in parts or "\\" in value or ":" in value or "\0" in value:
            raise ValueError(f"{value!r} is not {self.range_text}")
        return value

    def schema(self, whole: bool) -> dict[str, Any]:
        """Its JSON Schema."""
        return {"type": "string"}


Radius = Callable[..., int]
"""Takes a filter's values and returns how many rows above and below its own it reads."""

Percentiles = Callable[..., Sequence[float]]
"""Takes those of a measured block's values that it names and returns which percentiles of luma it wants."""

Control = Slider | Choice | Switch | Color | SavedRef | Asset
NAME_PATTERN = "[A-Za-z_][A-Za-z0-9_-]{0,63}"
"""What a style's saved pictures may be called."""


@dataclass(frozen=True)
class PageRegion:
    """Where the given rows lie on the page, for blocks whose result depends on the position.

    Attributes:
        top: how many rows of the page lie above the array's first row.
        height, width: the size of the page in working pixels.
        margin: how many of a filter's first and last rows are there only to be read from; what it
            returns in them is thrown away.
    """

    top: int
    height: int
    width: int
    margin: tuple[int, int] = (0, 0)


LumaWeights = NewType("LumaWeights", np.ndarray)
"""Given: the weights of red, green and blue in luma, three float32, from the picture's own matrix."""
Measured = NewType("Measured", np.ndarray)
"""Given to a measured block: the percentiles of luma that it asks for, smoothed over time."""

INJECTED: tuple[object, ...] = (PageRegion, LumaWeights, Measured)
"""The annotations that the runner fills in."""


@dataclass(frozen=True)
class Parameter:
    """One parameter of a block, read off its function."""

    name: str
    control: Control
    default: Any
    whole: bool

    def check(self, value: object) -> Any:
        """The value in its proper type, or ValueError saying what would be right."""
        return self.control.check(value, self.whole)

    def schema(self) -> dict[str, Any]:
        """Its JSON Schema, with help and default."""
        described = {"description": self.control.help, "default": self.default}
        return self.control.schema(self.whole) | described


@dataclass(frozen=True)
class Block:
    """A filter block: a function with what its declaration says about it. Call it like the function.

    Attributes:
        saves: the name under which every step of it keeps the picture that it was given.
    """

    name: str
    kind: Kind
    on: On
    function: Callable[..., Any]
    parameters: dict[str, Parameter]
    injected: dict[str, object]
    percentiles: Percentiles | None
    radius: Radius | None = None
    chroma: Literal["kept", "dropped"] = "kept"
    saves: str = ""

    @property
    def reads_neighbors(self) -> bool:
        """Whether a pixel of its result depends on others of its input."""
        return self.kind in ("filter", "learned")

    @property
    def help(self) -> str:
        """What it does: the first line of the docstring."""
        return (inspect.getdoc(self.function) or "").partition("\n")[0]

    def __call__(self, *arrays: Any, **values: Any) -> Any:
        """Run the function itself, with its defaults; colours may be given as text."""
        return self.function(*arrays, **self.complete(values))

    def complete(self, values: dict[str, Any]) -> dict[str, Any]:
        """The values and the defaults of the rest; colours as three floats 0..1, empty names as None."""
        complete = {name: parameter.default for name, parameter in self.parameters.items()} | values
        for name, parameter in self.parameters.items():
            text = complete[name] if isinstance(complete[name], str) else None
            if isinstance(parameter.control, Color) and text is not None:
                complete[name] = rgb_from_text(text)
            elif isinstance(parameter.control, SavedRef | Asset) and text == "":
                complete[name] = None
        return complete

    def radius_for(self, values: dict[str, Any]) -> int:
        """How many rows above and below its own it reads with these values; 0 unless it reads any."""
        if self.kind == "learned":
            return int(self.function(**values).radius)
        return 0 if self.radius is None else _call_with_named(self.radius, values)

    def percentages(self, values: dict[str, Any]) -> tuple[float, ...]:
        """Which percentiles of luma it is given with these values; none unless it is measured."""
        return () if self.percentiles is None else tuple(_call_with_named(self.percentiles, values))


def _call_with_named(function: Callable[..., Any], values: dict[str, Any]) -> Any:
    named = inspect.signature(function).parameters
    return function(**{name: value for name, value in values.items() if name in named})


def rgb_from_text(text: str) -> tuple[float, float, float]:
    """The colour "#rrggbb" as red, green and blue, 0..1.

    >>> rgb_from_text("#ff8000")
    (1.0, 0.5019607843137255, 0.0)
    """
    red, green, blue = bytes.fromhex(text[1:])
    return red / 255, green / 255, blue / 255


def block(
    kind: Kind,
    on: On,
    percentiles: Percentiles | None = None,
    radius: Radius | None = None,
    chroma: Literal["kept", "dropped"] = "kept",
    saves: str = "",
) -> Callable[[Callable[..., Any]], Block]:
    """Declare a function as a block of its name.

    Args:
        kind: how it reaches its result.
        on: which planes it works on.
        percentiles: for a measured block, which percentiles of luma the function gets as `Measured`:
            one to four numbers from 0 to 100.
        radius: for a filter, how far it reads; it may then be run on bands of rows.
        chroma: "dropped" where a luma block leaves a gray picture.
        saves: a name under which its steps keep the picture that they were given, without being told.

    Raises:
        TypeError: at import, when the declaration itself is wrong, a default out of range included.
    """

    def declare(function: Callable[..., Any]) -> Block:
        name = function.__name__
        if (kind == "measured") != (percentiles is not None):
            raise TypeError(f"{name}: `percentiles` belong to measured blocks, and to all of them")
        if (kind == "filter") != (radius is not None):
            raise TypeError(f"{name}: `radius` belongs to filters, and to all of them")
        if not inspect.getdoc(function):
            raise TypeError(f"{name}: a block says in its docstring what it does")
        parameters, given = _read_signature(function, skip=0 if kind in ("recipe", "learned") else 1)
        return Block(name, kind, on, function, parameters, given, percentiles, radius, chroma, saves)

    return declare


def _read_signature(
    function: Callable[..., Any], skip: int
) -> tuple[dict[str, Parameter], dict[str, object]]:
    hints = get_type_hints(function, include_extras=True)
    parameters: dict[str, Parameter] = {}
    given: dict[str, object] = {}
    for name, parameter in list(inspect.signature(function).parameters.items())[skip:]:
        hint = hints.get(name)
        if hint in INJECTED:
            given[name] = hint
        else:
            parameters[name] = _read_parameter(f"{function.__name__}.{name}", parameter, hint)
    return parameters, given


def _read_parameter(where: str, parameter: inspect.Parameter, hint: object) -> Parameter:
    annotations: Sequence[object] = get_args(hint)
    controls = [item for item in annotations[1:] if isinstance(item, get_args(Control))]
    if get_origin(hint) is None or len(controls) != 1:
        raise TypeError(f"{where}: annotate it as Annotated[type, control]")
    if parameter.default is inspect.Parameter.empty:
        raise TypeError(f"{where}: give it a default")
    read = Parameter(parameter.name, cast(Control, controls[0]), parameter.default, annotations[0] is int)
    try:
        read.check(read.default)
    except ValueError as error:
        raise TypeError(f"{where}: its default {error}") from None
    return read
