"""Filter blocks: decorated functions whose parameters declare themselves.

A parameter is annotated with its control (`Slider`, `Choice`, `Switch`, `Color`, `SavedRef` or
`Asset`), which holds its range, unit and help; its default is the default of the function's
parameter. The renderer, not the user, supplies parameters annotated with one of the `INJECTED_TYPES`.
Everything else, from the command line to the JSON Schema, is derived from these declarations.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NewType, get_args, get_origin, get_type_hints

import numpy as np

from vidstyle.block.controls import Control as Control
from vidstyle.block.controls import Parameter as Parameter
from vidstyle.block.controls import distinct_labels as distinct_labels
from vidstyle.block.controls import label_of_name
from vidstyle.block.option_controls import Choice as Choice
from vidstyle.block.option_controls import Color as Color
from vidstyle.block.option_controls import Switch as Switch
from vidstyle.block.option_controls import rgb_from_text as rgb_from_text
from vidstyle.block.reference_controls import NAME_PATTERN as NAME_PATTERN
from vidstyle.block.reference_controls import Asset as Asset
from vidstyle.block.reference_controls import SavedRef as SavedRef
from vidstyle.block.slider import Slider as Slider

BlockKind = Literal["pixel", "filter", "measured", "resize", "learned", "network", "recipe"]
"""How a block computes its result: from the same pixel, a neighbourhood, measurements of the whole frame, at
another size, by a bank of learned filters, by a neural network, or by other blocks.

- A pixel, filter or measured block takes an array and returns one, or a `core.deferred_color.Mixed`. Gray RGB
  may be passed as a view of one plane (`core.kernels.gray_rgb`). The parameter `settle` of a measured block
  is the time constant, in seconds, of the smoothing of its measurements.
- A recipe returns a list of blocks with their values.
- A learned block returns an object with `radius`, `scale` and `run(luma, margin)`.
- A network block returns an object with `run(color, out)`, or None for no change. It runs on the CPU only.
- A resize block takes a (height, width) and returns it scaled by its parameter `factor`. The renderer
  resamples with the methods in its parameters `method` and `back`.
"""

CATEGORIES = {
    "tone": "Light and contrast",
    "color": "Colour",
    "lines": "Lines and hatching",
    "smooth": "Blur, smooth and sharpen",
    "paint": "Paint",
    "print": "Print, dots and tiles",
    "texture": "Texture and effects",
    "combine": "Combine pictures",
    "size": "Size",
    "parts": "Building parts",
}
"""The headings of the categories of blocks, in the order of lists."""

On = Literal["luma", "color", "channels"]
"""What a block works on: luma only; RGB; or "channels", each channel separately: luma while the picture is
gray, else R, G and B."""

RadiusFunction = Callable[..., int]
"""Maps a filter's values to the number of rows that it reads above and below each row."""

Wave = tuple[float, float]
"""Periods per working pixel, across and down."""


@dataclass(frozen=True)
class Raster:
    """The positions of the dots, squares or lines of a block on the page.

    Attributes:
        waves: waves that begin at the first pixel of the page, and have the same periods.
        cell: height and width of squares in whole working pixels; None without squares.
        has_points: whether its marks are points, squares or letters of one tone each, which may be small.
        has_dots: whether its marks are dots that grow with the tone.
    """

    waves: tuple[Wave, ...]
    cell: tuple[int, int] | None = None
    has_points: bool = False
    has_dots: bool = False

    @classmethod
    def of_cells(cls, height: int, width: int) -> Raster:
        """Return the raster of squares of this size."""
        return cls(((1 / width, 0.0), (0.0, 1 / height)), (height, width), True)

    @classmethod
    def of_screens(cls, pitch: float, degrees: Iterable[float]) -> Raster:
        """Return the raster of dots on square lattices, turned by angles."""
        turns = [math.radians(each + side) for each in degrees for side in (0, 90)]
        waves = tuple((math.cos(turn) / pitch, math.sin(turn) / pitch) for turn in turns)
        return cls(waves, has_dots=True)


NO_PERIOD = Raster(())
"""The raster of lines that follow the picture."""
SCATTERED_POINTS = Raster((), has_points=True)
"""The raster of points in a pattern."""

RasterFunction = Callable[..., "Raster | None"]
"""Maps the values of a block that it takes as parameters to its raster; None: with these, it has none."""

MovesFunction = Callable[..., bool]
"""Maps the values of a block that takes `Drift` to whether its marks move."""

PercentileFunction = Callable[..., Sequence[float]]
"""Maps the values of a measured block that it takes as parameters to the percentiles of luma that the block
needs."""


@dataclass(frozen=True)
class PageRegion:
    """The position of the given rows on the page, for blocks whose result depends on it.

    Attributes:
        top: rows of the page above the array's first row.
        height, width: size of the page in working pixels.
        margin: numbers of first and last rows that a filter may read; its result for them is ignored.
    """

    top: int
    height: int
    width: int
    margin: tuple[int, int] = (0, 0)


Margin = NewType("Margin", tuple[int, int])
"""Injected: the numbers of first and last rows that a filter may read; its result for them is ignored."""
LumaWeights = NewType("LumaWeights", np.ndarray)
"""Injected: the weights of red, green and blue in luma, three float32, from the picture's matrix."""
Percentiles = NewType("Percentiles", np.ndarray)
"""Injected into a measured block: the percentiles of luma that it requests, smoothed over time."""
FrameTime = NewType("FrameTime", int)
"""Injected: the time of the frame in whole milliseconds, below 2**32; 0 for a single picture."""
Drift = NewType("Drift", np.ndarray)
"""Injected: how far marks have moved with a film, see `core.drift`; None for none. The marks of a block that
takes it move with the objects of the film."""

Limits = NewType("Limits", tuple[float, float])
"""Injected into a block whose result may exceed the range of its input and 0..1: the range, from
`core.picture`, that it must clip the result to."""

ResultRows = NewType("ResultRows", np.ndarray)
"""Injected: float32 rows for the result, without the margin. The function fills and returns them, or returns
another array that includes the margin."""

INJECTED_TYPES: tuple[object, ...] = (
    PageRegion,
    Margin,
    LumaWeights,
    Percentiles,
    FrameTime,
    Drift,
    Limits,
    ResultRows,
)
"""The annotations of the parameters that the renderer fills in."""


def moment_of(time: float | None) -> int:
    """Return the `FrameTime` of a frame that is shown at a time in seconds."""
    return 0 if time is None else math.floor(time * 1000 + 0.5) & 0xFFFFFFFF


REDRAW_RATE = Slider(0, 60, "changes of the random parts per second; 0 for none", label="Redraws per second")
"""The control of a block whose random parts may change with time; see `drawing_at`."""


def drawing_at(moment: int, rate: int) -> int:
    """Return the number of the drawing shown at a moment, at `rate` drawings per second.

    Computed in 32 bits, as on a GPU.
    """
    return (moment * rate & 0xFFFFFFFF) // 1000


@dataclass(frozen=True)
class Block:
    """A filter block: a function with its declaration. Call it like the function.

    Attributes:
        saves: the name under which each of its steps saves the input.
        is_identity: whether its function returns luma unchanged, so that only the chroma changes.
        exact: whether a GPU must store its input, and the results of filters on its output, as float32.
        label: its name in plain words.
        category: a key of `CATEGORIES`.
        aliases: other words by which people search it.
        moves: for a block that takes `Drift`, whether its marks then move; None: always.
    """

    name: str
    kind: BlockKind
    on: On
    function: Callable[..., Any]
    parameters: dict[str, Parameter]
    injected: dict[str, object]
    percentiles: PercentileFunction | None
    radius: RadiusFunction | None = None
    raster: RasterFunction | None = None
    chroma: Literal["kept", "dropped"] = "kept"
    saves: str = ""
    is_identity: bool = False
    exact: bool = False
    label: str = ""
    category: str = "parts"
    aliases: tuple[str, ...] = ()
    moves: MovesFunction | None = None

    @property
    def overshoots(self) -> bool:
        """Whether its result may exceed the range of its input and 0..1, up to `Limits`."""
        return Limits in self.injected.values()

    @cached_property
    def saved_refs(self) -> dict[str, SavedRef]:
        """Controls of the parameters that name saved pictures."""
        controls = {name: parameter.control for name, parameter in self.parameters.items()}
        return {name: control for name, control in controls.items() if isinstance(control, SavedRef)}

    @property
    def help(self) -> str:
        """The first line of the docstring."""
        return (inspect.getdoc(self.function) or "").partition("\n")[0]

    @property
    def explanation(self) -> str:
        """The first paragraph of the docstring after its first line, which is for everybody, on one line."""
        after = (inspect.getdoc(self.function) or "").partition("\n")[2]
        return " ".join(after.strip().partition("\n\n")[0].split())

    def __call__(self, *arrays: Any, **values: Any) -> Any:
        """Run the function, with its defaults; colours may be given as text."""
        return self.function(*arrays, **self.arguments_for(values))

    def arguments_for(self, values: dict[str, Any]) -> dict[str, Any]:
        """Return the function's keyword arguments, with defaults; colours as floats, empty names as None."""
        arguments = {name: parameter.default for name, parameter in self.parameters.items()} | values
        for name, parameter in self.parameters.items():
            arguments[name] = parameter.control.argument(arguments[name])
        return arguments

    def radius_for(self, values: dict[str, Any]) -> int:
        """Return the number of rows that it reads above and below each row with these values."""
        return 0 if self.radius is None else _call_with_known(self.radius, values)

    def raster_for(self, values: dict[str, Any]) -> Raster | None:
        """Return where its dots, squares or lines lie with these values; None if it has none."""
        return None if self.raster is None else _call_with_known(self.raster, values)

    def moves_for(self, values: dict[str, Any]) -> bool:
        """Return whether its marks move with the objects of a film with these values."""
        if Drift not in self.injected.values():
            return False
        return self.moves is None or bool(_call_with_known(self.moves, values))

    def percentiles_for(self, values: dict[str, Any]) -> tuple[float, ...]:
        """Return the percentiles of luma that it needs with these values; none unless it is measured."""
        return () if self.percentiles is None else tuple(_call_with_known(self.percentiles, values))


def _call_with_known(function: Callable[..., Any], values: dict[str, Any]) -> Any:
    known = inspect.signature(function).parameters
    return function(**{name: value for name, value in values.items() if name in known})


def block(
    kind: BlockKind,
    on: On,
    percentiles: PercentileFunction | None = None,
    radius: RadiusFunction | None = None,
    raster: RasterFunction | None = None,
    chroma: Literal["kept", "dropped"] = "kept",
    saves: str = "",
    is_identity: bool = False,
    exact: bool = False,
    label: str = "",
    category: str = "parts",
    aliases: str = "",
    moves: MovesFunction | None = None,
) -> Callable[[Callable[..., Any]], Block]:
    """Declare a function as a block of the same name.

    Args:
        kind: how it computes its result.
        on: the channels that it works on.
        percentiles: for a measured block, the percentiles of luma that the function gets as `Percentiles`:
            one to four numbers from 0 to 100.
        radius: for a filter, the number of rows that it reads above and below; it may then run on bands of
            rows.
        raster: where its dots, squares or lines lie, if they have one period over the whole page.
        chroma: "dropped" if a luma block outputs a gray picture.
        saves: a name under which each of its steps saves the input.
        is_identity: True for a luma block that only changes the chroma; a style does not call its function.
        exact: whether the result shows differences that are too small for 16-bit textures of a GPU.
        label: its name in plain words; by default the name of the function.
        category: a key of `CATEGORIES`.
        aliases: other words by which people search it, separated by commas.
        moves: for a block that takes `Drift`, whether its marks then move; None: always.

    Raises:
        TypeError: at import, for an invalid declaration, such as a default out of range.
    """

    def declare(function: Callable[..., Any]) -> Block:
        name = function.__name__
        if (kind == "measured") != (percentiles is not None):
            raise TypeError(f"{name}: measured blocks, and no others, declare `percentiles`")
        if (kind == "filter") != (radius is not None):
            raise TypeError(f"{name}: filters, and no other blocks, declare `radius`")
        if not inspect.getdoc(function):
            raise TypeError(f"{name}: a block needs a docstring that describes it")
        if category not in CATEGORIES:
            raise TypeError(f"{name}: its category is one of {', '.join(CATEGORIES)}")
        parameters, injected = _read_signature(
            function, skip=0 if kind in ("recipe", "learned", "network") else 1
        )
        return Block(
            name, kind, on, function, parameters, injected, percentiles, radius, raster, chroma, saves,
            is_identity, exact, label or label_of_name(name), category,
            tuple(aliases.split(", ")) if aliases else (), moves,
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
        if hint in INJECTED_TYPES:
            injected[name] = hint
        else:
            parameters[name] = _read_parameter(f"{function.__name__}.{name}", parameter, hint)
    return parameters, injected


def _read_parameter(where: str, parameter: inspect.Parameter, hint: object) -> Parameter:
    annotations: Sequence[object] = get_args(hint)
    controls = [item for item in annotations[1:] if isinstance(item, Control)]
    if get_origin(hint) is None or len(controls) != 1:
        raise TypeError(f"{where}: needs the annotation Annotated[type, control]")
    if parameter.default is inspect.Parameter.empty:
        raise TypeError(f"{where}: needs a default")
    read = Parameter(parameter.name, controls[0], parameter.default, annotations[0] is int)
    try:
        read.check(read.default)
    except ValueError as error:
        raise TypeError(f"{where}: its default {error}") from None
    return read
