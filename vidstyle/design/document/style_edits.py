"""The edits of the style as a whole: pure functions that return new content, see `edits`."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

from vidstyle.design.document.content import Content, ValueRef
from vidstyle.design.document.edit_values import (
    EditResult,
    NewNumber,
    declaration_of,
    parameter_of,
    parse_value,
    value_text,
    with_value,
)
from vidstyle.design.document.variant_choice import values_to_choose, variant_names
from vidstyle.errors import UsageError, suggest
from vidstyle.style.check import TEXTS
from vidstyle.style.knobs import (
    LABEL_END,
    MAX_KNOBS,
    MAX_LABEL_LENGTH,
    MAX_LABELS,
    is_label,
    split_label,
)
from vidstyle.style.model import FIELDS
from vidstyle.web.messages import AnyValue, TextOrEmpty, text_between

NoteText = Annotated[str, text_between(0, 4 * TEXTS["note"])]
"""A note before its line breaks are joined."""


def set_field(content: Content, new: NewNumber, name: str, value: AnyValue | None) -> EditResult:
    """Set a field of the style; None resets it to its default."""
    if name not in FIELDS:
        raise UsageError(name, "is not a field of a style", suggest(name, FIELDS))
    default = FIELDS[name].default
    value = default if value is None else parse_value(FIELDS[name], value)
    return EditResult(
        _with_field(content, name, value, default), f"{FIELDS[name].label}: {value_text(value)}"
    )


def knob(content: Content, new: NewNumber, step: int | None, name: str, on: bool) -> EditResult:
    """Pin a value to the style panel, or unpin it."""
    ref = ValueRef(step, name)
    label = content.label_of(ref, declaration_of(content, ref))
    knobs = tuple(each for each in content.knobs if each != ref) if not on else content.knobs
    if on and ref not in knobs:
        knobs += (ref,)
    if len(knobs) > MAX_KNOBS:
        raise UsageError("knobs", f"are at most {MAX_KNOBS}", "remove one first")
    return EditResult(replace(content, knobs=knobs), f"{'Pin' if on else 'Unpin'} {label}")


def label(content: Content, new: NewNumber, step: int | None, name: str, text: TextOrEmpty) -> EditResult:
    """Set what a value is called in this style; an empty text restores the label of its parameter.

    Its own help, if any, stays under the new label.
    """
    ref = ValueRef(step, name)
    parameter = declaration_of(content, ref)
    text = " ".join(text.split())
    _, own_help = split_label(content.labels.get(ref, ""))
    if text and own_help and LABEL_END not in text:
        text += LABEL_END + own_help
    if text and not is_label(text):
        raise UsageError("label", f"is not a text of at most {MAX_LABEL_LENGTH} characters")
    labels = {each: old for each, old in content.labels.items() if each != ref}
    if text and text != parameter.label:
        labels[ref] = text
    if len(labels) > MAX_LABELS:
        raise UsageError("labels", f"are at most {MAX_LABELS}", "remove one first")
    shown = split_label(text)[0] or parameter.label
    return EditResult(replace(content, labels=labels), f"Rename {parameter.label}: {shown}")


def variant(content: Content, new: NewNumber, name: TextOrEmpty) -> EditResult:
    """Choose a variant; an empty name is the style without one. Values that no variant sets stay."""
    if name not in variant_names(content):
        raise UsageError(name, "is not a variant of this style", suggest(name, content.variants))
    for ref, value in values_to_choose(content, name).items():
        if ref.step is None:
            content = _with_field(content, ref.name, value, FIELDS[ref.name].default)
        else:
            step = content.place_of(ref.step)[2]
            content = with_value(content, step, parameter_of(step, ref.name), value)
    return EditResult(content, f"Variant: {name or 'standard'}")


def rename(content: Content, new: NewNumber, name: str) -> EditResult:
    """Set the name of the style."""
    return EditResult(_with_field(content, "name", _line("name", name), ""), f"Name: {name}")


def note(content: Content, new: NewNumber, text: NoteText) -> EditResult:
    """Set the note of the style."""
    return EditResult(_with_field(content, "note", _line("note", text), ""), "Note")


def _with_field(content: Content, name: str, value: Any, default: Any) -> Content:
    fields = {**content.fields, name: value}
    order = dict.fromkeys(("name", *TEXTS, *FIELDS, *fields))  # masks and others keep their place at the end
    kept = {key: fields[key] for key in order if key in fields and (key != name or value != default)}
    return replace(content, fields=kept)


def _line(key: str, text: str) -> str:
    line = " ".join(text.split())
    if len(line) > TEXTS[key] or not line.isprintable():
        raise UsageError(key, f"is not a text of at most {TEXTS[key]} characters")
    return line
