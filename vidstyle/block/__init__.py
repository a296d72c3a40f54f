"""Filter blocks: decorated functions whose parameters declare themselves.

A parameter is annotated with its control (`Slider`, `Choice`, `Switch`, `Color`, `SavedRef` or
`Asset`), which holds its range, unit and help; its default is the function's own. A parameter
annotated with one of the `INJECTED` types is filled in by the renderer instead of the user.
Everything else, from the command line to the JSON Schema, is derived from here.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NewType, get_args, get_origin, get_type_hints

import numpy as np

from vidstyle.block.controls import Control as Control
from vidstyle.block.controls import Parameter as Parameter
from vidstyle.block.option_controls import Choice as Choice
from vidstyle.block.option_controls import Color as Color
from vidstyle.block.option_controls import Switch as Switch
from vidstyle.block.option_controls import rgb_from_text as rgb_from_text
from vidstyle.block.reference_controls import NAME_PATTERN as NAME_PATTERN
from vidstyle.block.reference_controls import Asset as Asset
from vidstyle.block.reference_controls import SavedRef as SavedRef
from vidstyle.block.slider import Slider as Slider

BlockKind = Literal["pixel", "filter", "measured", "resize", "learned", "recipe"]
"""How a block computes its result: from the same pixel, a neighbourhood, measurements of the whole frame, at
another size, by a bank of learned filters, or by other blocks.

The function of a pixel, filter or measured block takes an array and returns one, or a
`core.deferred_color.Mixed`. RGB that is gray may come as a view of one plane (`core.kernels.gray_rgb`). That
of a recipe returns a list of blocks with their values; that of a learned block an object with `radius`,
`scale` and `run(luma, margin)`; that of a resize block takes a (height, width) and returns the one that its
parameter `factor` makes of it, while the renderer resamples as its parameters `method` and `back` say. A
measured block's parameter `settle`, in seconds, is the time constant by which its measurements are smoothed.
"""

On = Literal["luma", "color", "channels"]
"""What a block works on: luma alone; RGB; or "channels", each channel by itself: luma while the picture is
gray, else R, G and B."""

RadiusFunction = Callable[..., int]
"""From a filter's values to the number of rows above and below its own that it reads."""

PercentileFunction = Callable[..., Sequence[float]]
"""From those values of a measured block that it names to the percentiles of luma that the block needs."""


@dataclass(frozen=True)
class PageRegion:
    """Where the given rows lie on the page, for blocks whose result depends on the position.

    Attributes:
        top: rows of the page above the array's first row.
        height, width: size of the page in working pixels.
        margin: a filter's first and last rows that are only there to be read; its result is ignored there.
    """

    top: int
    height: int
    width: int
    margin: tuple[int, int] = (0, 0)


Margin = NewType("Margin", tuple[int, int])
"""Injected: a filter's first and last rows that are only there to be read; its result is ignored there."""
LumaWeights = NewType("LumaWeights", np.ndarray)
"""Injected: the weights of red, green and blue in luma, three float32, from the picture's own matrix."""
Measured = NewType("Measured", np.ndarray)
"""Injected into a measured block: the percentiles of luma that it asks for, smoothed over time."""
FrameTime = NewType("FrameTime", int)
"""Injected: the time of the frame in whole milliseconds, below 2**32; 0 for a picture that stands alone."""

Limits = NewType("Limits", tuple[float, float])
"""Injected into a block whose result may leave the range of its input and of 0..1: the ends of the range that
it has to clip it to, of `core.picture`."""

ResultRows = NewType("ResultRows", np.ndarray)
"""Injected: float32 rows for the result, without the margin. The function fills and returns them, or returns
another array, in which it has the margin."""

INJECTED: tuple[object, ...] = (PageRegion, Margin, LumaWeights, Measured, FrameTime, Limits, ResultRows)
"""The annotations of the parameters that the renderer fills in."""


def moment_of(time: float | None) -> int:
    """The `FrameTime` of a frame that is shown at a time in seconds."""
    return 0 if time is None else math.floor(time * 1000 + 0.5) & 0xFFFFFFFF


REDRAW_RATE = Slider(0, 60, "times a second that what is random is drawn anew; 0 for never")
"""The control of a block whose random parts may change with time; see `drawing_at`."""


def drawing_at(moment: int, rate: int) -> int:
    """Which drawing is shown if there are so many a second: a whole number, as a GPU has it in 32 bits."""
    return (moment * rate & 0xFFFFFFFF) // 1000


@dataclass(frozen=True)
class Block:
    """A filter block: a function with its declaration. Call it like the function.

    Attributes:
        saves: the name under which every step of it saves its input.
        is_identity: whether its function returns luma as it is, so that only the chroma changes.
        exact: whether a GPU has to store its input and what filters make of its result as float32.
    """

    name: str
    kind: BlockKind
    on: On
    function: Callable[..., Any]
    parameters: dict[str, Parameter]
    injected: dict[str, object]
    percentiles: PercentileFunction | None
    radius: RadiusFunction | None = None
    chroma: Literal["kept", "dropped"] = "kept"
    saves: str = ""
    is_identity: bool = False
    exact: bool = False

    @property
    def overshoots(self) -> bool:
        """Whether its result may leave the range of its input and of 0..1, but for `Limits`."""
        return Limits in self.injected.values()

    @cached_property
    def saved_refs(self) -> dict[str, SavedRef]:
        """The parameters that name saved pictures."""
        controls = {name: parameter.control for name, parameter in self.parameters.items()}
        return {name: control for name, control in controls.items() if isinstance(control, SavedRef)}

    @property
    def help(self) -> str:
        """The first line of the docstring."""
        return (inspect.getdoc(self.function) or "").partition("\n")[0]

    def __call__(self, *arrays: Any, **values: Any) -> Any:
        """Run the function, with its defaults; colours may be given as text."""
        return self.function(*arrays, **self.arguments_for(values))

    def arguments_for(self, values: dict[str, Any]) -> dict[str, Any]:
        """The function's keyword arguments: values and defaults, colours as floats, empty names as None."""
        arguments = {name: parameter.default for name, parameter in self.parameters.items()} | values
        for name, parameter in self.parameters.items():
            arguments[name] = parameter.control.argument(arguments[name])
        return arguments

    def radius_for(self, values: dict[str, Any]) -> int:
        """The rows above and below its own that it reads with these values."""
        return 0 if self.radius is None else _call_with_known(self.radius, values)

    def percentiles_for(self, values: dict[str, Any]) -> tuple[float, ...]:
        """The percentiles of luma that it needs with these values; none unless it is measured."""
        return () if self.percentiles is None else tuple(_call_with_known(self.percentiles, values))


def _call_with_known(function: Callable[..., Any], values: dict[str, Any]) -> Any:
    known = inspect.signature(function).parameters
    return function(**{name: value for name, value in values.items() if name in known})


def block(
    kind: BlockKind,
    on: On,
    percentiles: PercentileFunction | None = None,
    radius: RadiusFunction | None = None,
    chroma: Literal["kept", "dropped"] = "kept",
    saves: str = "",
    is_identity: bool = False,
    exact: bool = False,
) -> Callable[[Callable[..., Any]], Block]:
    """Declare a function as a block of its name.

    Args:
        kind: how it computes its result.
        on: the channels that it works on.
        percentiles: for a measured block, the percentiles of luma that the function gets as `Measured`:
            one to four numbers from 0 to 100.
        radius: for a filter, the rows above and below that it reads; it may then run on bands of rows.
        chroma: "dropped" where a luma block leaves a gray picture.
        saves: a name under which each of its steps saves its input.
        is_identity: for a luma block that only changes the chroma; a style does not call its function.
        exact: the result shows differences that are smaller than a GPU's textures of 16 bits keep.

    Raises:
        TypeError: at import, for an invalid declaration, such as a default out of range.
    """

    def declare(function: Callable[..., Any]) -> Block:
        name = function.__name__
        if (kind == "measured") != (percentiles is not None):
            raise TypeError(f"{name}: `percentiles` belong to measured blocks, and to all of them")
        if (kind == "filter") != (radius is not None):
            raise TypeError(f"{name}: `radius` belongs to filters, and to all of them")
        if not inspect.getdoc(function):
            raise TypeError(f"{name}: a block says in its docstring what it does")
        parameters, injected = _read_signature(function, skip=0 if kind in ("recipe", "learned") else 1)
        return Block(
            name, kind, on, function, parameters, injected, percentiles, radius, chroma, saves, is_identity,
            exact,
        )  # fmt: skip

    return declare


def _read_signature(
    function: Callable[..., Any], skip: int
) -> tuple[dict[str, Parameter], dict[str, object]]:
    hints = get_type_hints(function, include_extras=True)
    parameters: dict[str, Parameter] = {}
    injected: dict[str, object] = {}
    for name, parameter in list(inspect.signature(function).parameters.items())[skip:]:
        hint = hints.get(name)
        if hint in INJECTED:
            injected[name] = hint
        else:
            parameters[name] = _read_parameter(f"{function.__name__}.{name}", parameter, hint)
    return parameters, injected


def _read_parameter(where: str, parameter: inspect.Parameter, hint: object) -> Parameter:
    annotations: Sequence[object] = get_args(hint)
    controls = [item for item in annotations[1:] if isinstance(item, Control)]
    if get_origin(hint) is None or len(controls) != 1:
        raise TypeError(f"{where}: annotate it as Annotated[type, control]")
    if parameter.default is inspect.Parameter.empty:
        raise TypeError(f"{where}: give it a default")
    read = Parameter(parameter.name, controls[0], parameter.default, annotations[0] is int)
    try:
        read.check(read.default)
    except ValueError as error:
        raise TypeError(f"{where}: its default {error}") from None
    return read
