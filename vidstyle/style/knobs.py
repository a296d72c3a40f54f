"""The knobs of a style, and its own labels of values.

A knob is a value to adjust first. A label says what a value does in this style where the label of its
parameter is too general: "Solid ink" for the amount of a blend. Its own help may follow a colon:
"Solid ink: how dark the regions are that become solid".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from vidstyle.block import Parameter, distinct_labels
from vidstyle.style.model import Style, table_from_style
from vidstyle.style.paths import find_value, steps_by_path
from vidstyle.style.values import to_text

MAX_KNOBS = 16
MAX_LABELS = 64
MAX_LABEL_LENGTH, MAX_HELP_LENGTH = 40, 120
LABEL_END = ": "
"""Separates a label from its help."""
MAX_LABEL_TEXT_LENGTH = MAX_LABEL_LENGTH + len(LABEL_END) + MAX_HELP_LENGTH


def read_knobs(style: Style, given: object, mistakes: list[str]) -> tuple[str, ...]:
    """Return the paths of the knobs, each of which must name a value.

    Args:
        given: the content of the file under `knobs`.
        mistakes: a line is appended for each mistake.
    """
    if not isinstance(given, list | tuple) or not all(isinstance(path, str) for path in given):
        mistakes.append('knobs is not a list of paths; write knobs = ["step.parameter", "ink"]')
        return ()
    if len(given) > MAX_KNOBS:
        mistakes.append(f"knobs: a style has at most {MAX_KNOBS} knobs")
        return ()
    _find_values(style, given, "knobs", mistakes)
    return tuple(given)


def read_labels(style: Style, given: object, mistakes: list[str]) -> dict[str, str]:
    """Return the labels of values by their paths, as given in the file under `labels`."""
    if not isinstance(given, Mapping):
        mistakes.append('labels is not a table; write [labels], and below it "step.parameter" = "Label"')
        return {}
    if len(given) > MAX_LABELS:
        mistakes.append(f"labels: a style has at most {MAX_LABELS} labels")
        return {}
    mistakes += [
        f"labels: {to_text(label)} is not a text of 1 to {MAX_LABEL_LENGTH} characters, with at most"
        f" {MAX_HELP_LENGTH} of help after a colon"
        for label in given.values()
        if not is_label(label)
    ]
    _find_values(style, given, "labels", mistakes)
    return {path: str(label) for path, label in given.items()}


def is_label(label: object) -> bool:
    """Whether a value is a text on one line that fits next to a slider, with or without help."""
    if not isinstance(label, str) or not label.isprintable():
        return False
    words, help = split_label(label)
    return label == label.strip() and 0 < len(words) <= MAX_LABEL_LENGTH and len(help) <= MAX_HELP_LENGTH


def split_label(text: str) -> tuple[str, str]:
    """Return a label without its help, and the help or "".

    >>> split_label("Solid ink: how dark it is"), split_label("Solid ink")
    (('Solid ink', 'how dark it is'), ('Solid ink', ''))
    """
    words, _, help = text.partition(LABEL_END)
    return words, help


def knobs_of(style: Style, table: dict[str, Any]) -> dict[str, Parameter]:
    """Return the declarations of the knobs by their shortest paths; equal labels are numbered.

    Args:
        table: the table of the style.
    """
    own = _labelled(style, table)
    found = {path: own.get(path, each) for path, each in _declarations(table, style.knobs).items()}
    labels = distinct_labels([parameter.label for parameter in found.values()])
    return {path: each.named(label) for (path, each), label in zip(found.items(), labels, strict=True)}


def labelled_values(style: Style, table: dict[str, Any]) -> dict[str, Parameter]:
    """Return the declarations of knobs and other values with a label, by their shortest paths."""
    return _labelled(style, table) | knobs_of(style, table)


def _labelled(style: Style, table: dict[str, Any]) -> dict[str, Parameter]:
    found = _declarations(table, style.labels).items()
    labels = map(split_label, style.labels.values())
    return {path: each.named(*label) for (path, each), label in zip(found, labels, strict=True)}


def _declarations(table: dict[str, Any], paths: Iterable[str]) -> dict[str, Parameter]:
    """Return the declarations of values by their shortest paths, in order."""
    steps = {id(step): f"{path}." for path, step in steps_by_path(table).items()}
    places = [find_value(table, path) for path in paths]
    return {f"{steps.get(id(place.table), '')}{place.parameter.name}": place.parameter for place in places}


def with_valid_paths(style: Style) -> Style:
    """Return the style without the knobs and labels of values that no longer exist."""
    table = table_from_style(replace(style, knobs=(), labels={}))
    knobs = tuple(path for path in style.knobs if _exists(table, path))
    return replace(
        style,
        knobs=knobs,
        labels={path: label for path, label in style.labels.items() if _exists(table, path)},
    )


def _exists(table: dict[str, Any], path: str) -> bool:
    try:
        find_value(table, path)
    except ValueError:
        return False
    return True


def _find_values(style: Style, paths: Iterable[str], where: str, mistakes: list[str]) -> None:
    """Append a mistake for each path that names no value, or the value of an earlier one."""
    table, found = table_from_style(style), set()
    for path in paths:
        try:
            value = find_value(table, path)
        except ValueError as error:
            mistakes.append(f"{where}: {error}")
            continue
        if (key := (id(value.table), value.parameter.name)) in found:
            mistakes.append(f"{where}: {to_text(path)} is there twice")
        found.add(key)
