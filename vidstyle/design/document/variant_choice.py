"""The variants of a style: which one is chosen, and what choosing another one sets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from vidstyle.blocks import all_blocks
from vidstyle.design.document.content import Content, ValueRef
from vidstyle.style.model import FIELDS

STANDARD = ""
"""The name of the opened style without a variant."""


def variant_names(content: Content) -> list[str]:
    """Return the names to choose from; none if the style has no variants."""
    return [STANDARD, *content.variants] if content.variants else []


def variant_values(content: Content, name: str) -> Mapping[ValueRef, Any]:
    """Return the values that a variant sets."""
    return content.standard if name == STANDARD else dict(content.variants[name])


def chosen_variant(content: Content) -> str | None:
    """Return the variant whose values the style has, the one that sets most; None if there is none."""
    found = [name for name in variant_names(content) if _is_chosen(content, name)]
    return max(found, key=lambda name: (name != STANDARD, len(variant_values(content, name))), default=None)


def values_to_choose(content: Content, name: str) -> Mapping[ValueRef, Any]:
    """Return the values to set for a variant; those that only the variant before it sets become standard."""
    left = variant_values(content, chosen_variant(content) or STANDARD)
    return {**{ref: content.standard[ref] for ref in left}, **variant_values(content, name)}


def _is_chosen(content: Content, name: str) -> bool:
    values = variant_values(content, name)
    return bool(values) and all(_present(content, ref) == value for ref, value in values.items())


def _present(content: Content, ref: ValueRef) -> Any:
    if ref.step is None:
        return content.value_of(ref, FIELDS[ref.name])
    block = content.place_of(ref.step)[2].table["block"]
    return content.value_of(ref, all_blocks()[block].parameters[ref.name])
