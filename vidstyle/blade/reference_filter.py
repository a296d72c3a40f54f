"""Reference filters that banks approximate: built-in filters, functions, or pairs of pictures."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.blade import references
from vidstyle.blade.photographs import Photograph, luma_of
from vidstyle.errors import InputError, UsageError

_BUILT_IN: dict[str, tuple[Callable[..., Any], tuple[str, ...], tuple[int, ...]]] = {
    "edge_tangent_flow": (references.edge_tangent_flow, ("all",), (1,)),
    "tv_flow": (references.tv_flow, ("all",), (1,)),
    "detail_base": (references.detail_base, ("all",), (1,)),
    "flow_dog": (references.flow_dog_parts, ("smooth", "difference"), (1, 0)),
}


@dataclass(frozen=True)
class ReferenceFilter:
    """The filter that a bank approximates.

    Attributes:
        name: its name in the bank.
        apply: maps RGB, H x W x 3 float32 0..1, and its photograph to the target of each part, float32: RGB,
            or luma, H x W.
        parts: names of the bank's parts; a bank has filters for each.
        sums: the response of each part to a constant 1: 1 if a constant is kept, 0 if it vanishes.
        settings: settings of the filter, for the record in the bank.
        is_testable: whether `apply` accepts any picture, not only training pictures.
    """

    name: str
    apply: Callable[[np.ndarray, Photograph], list[np.ndarray]]
    parts: tuple[str, ...] = ("all",)
    sums: tuple[int, ...] = (1,)
    settings: Mapping[str, Any] = field(default_factory=dict)
    is_testable: bool = True


def reference_by_name(name: str, **settings: float) -> ReferenceFilter:
    """Return a built-in reference filter; settings override the defaults of its function.

    Raises:
        UsageError: the reference filter or one of its settings does not exist.
    """
    if name not in _BUILT_IN:
        raise UsageError(name, "is not a reference", f"choose one of {', '.join(_BUILT_IN)}")
    function, parts, sums = _BUILT_IN[name]
    _, *known = inspect.signature(function).parameters
    for unknown in settings.keys() - known:
        raise UsageError(name, f"has no setting '{unknown}'", f"its settings are {', '.join(known)}")

    def apply(color: np.ndarray, _: Photograph) -> list[np.ndarray]:
        result = function(luma_of(color), **settings)
        return list(result) if len(parts) > 1 else [result]

    return ReferenceFilter(name, apply, parts, sums, settings)


def join_references(references: Sequence[ReferenceFilter]) -> ReferenceFilter:
    """Combine several settings of one reference filter, whose parts are trained together."""

    def apply(color: np.ndarray, photograph: Photograph) -> list[np.ndarray]:
        return [target for each in references for target in each.apply(color, photograph)]

    parts = tuple(f"{part}{_settings_text(each)}" for each in references for part in each.parts)
    sums = tuple(total for each in references for total in each.sums)
    return ReferenceFilter(references[0].name, apply, parts, sums)


def _settings_text(reference: ReferenceFilter) -> str:
    return "".join(f", {name} {value:g}" for name, value in reference.settings.items())


def reference_by_function(name: str, sliders: Sequence[str] = ()) -> ReferenceFilter:
    """Return a filter that calls a Python function, "module:function", on RGB, H x W x 3 uint8.

    Args:
        sliders: names of the additional pictures that it returns: floats that are weighted by a slider and
            added to the first picture, 0 for no change.

    Raises:
        UsageError: the function does not exist.
    """
    module, _, attribute = name.partition(":")
    try:
        function = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise UsageError(name, f"is not a function ({error})", "write module:function") from None

    def apply(color: np.ndarray, photograph: Photograph) -> list[np.ndarray]:
        try:
            results = function((color * 255 + 0.5).astype(np.uint8))
            results = [np.asarray(each) for each in (results if sliders else [results])]
        except Exception as error:  # the user's function may raise any exception
            reason = f"failed on {photograph.path.name} ({type(error).__name__}: {error})"
            raise InputError(name, reason, "try it by hand") from error
        if len(results) != 1 + len(sliders):
            reason = f"returned {len(results)} pictures, not one and {len(sliders)} for sliders"
            raise InputError(name, reason, "return one for each --slider in addition to the first")
        scales = (np.float32(1 / 255 if each.dtype == np.uint8 else 1) for each in results)
        scaled = (each.astype(np.float32) * scale for each, scale in zip(results, scales, strict=True))
        return [check_size(each, color, name, "function") for each in scaled]

    sums = (1, *[0] * len(sliders))
    return ReferenceFilter(name, apply, ("result", *sliders) if sliders else ("all",), sums)


def reference_by_pairs(folder: Path) -> ReferenceFilter:
    """Return a filter that reads filtered pictures, named like the training pictures, from a folder."""

    def apply(color: np.ndarray, photograph: Photograph) -> list[np.ndarray]:
        target = folder / photograph.path.name
        return [check_size(Photograph(target, photograph.long_side).color(), color, str(target), "pair")]

    return ReferenceFilter(f"the pictures in {folder.name}", apply, is_testable=False)


def check_size(result: np.ndarray, color: np.ndarray, name: str, what: str) -> np.ndarray:
    """Return the result, RGB or luma; raise InputError if its size differs from the original."""
    if result.shape[:2] != color.shape[:2]:
        returned, given = (f"{each.shape[1]}x{each.shape[0]}" for each in (result, color))
        reason = f"'{name}' returned {returned} for a picture of {given}"
        raise InputError(name, reason, f"the {what} must keep the size")
    return np.asarray(result[..., :3] if result.ndim == 3 else result, np.float32)
