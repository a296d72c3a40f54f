"""What a style file may hold, as JSON Schema for editors, and what one holds, for listings."""

from __future__ import annotations

from typing import Any

from vidstyle.block import NAME_PATTERN, Block
from vidstyle.blocks import all_blocks
from vidstyle.style.check import FORMAT, TEXTS
from vidstyle.style.model import FIELDS, LAYERS, Step, Style
from vidstyle.style.steps import MAX_STEPS
from vidstyle.style.variants import MAX_VARIANTS, VARIANT_PATTERN


def style_schema() -> dict[str, Any]:
    """The JSON Schema (draft 2020-12) of a style file, derived from the declarations of the blocks.

    What lies between steps, such as that a picture was saved before it is used, is beyond a schema.
    """
    steps = {name: _block_schema(block) for name, block in all_blocks().items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "vidstyle style",
        "type": "object",
        "required": ["format"],
        "additionalProperties": False,
        "properties": _text_schemas()
        | _field_schemas()
        | {layer: _layer_schema() for layer in LAYERS}
        | {"variants": _variants_schema()},
        "$defs": {
            "step": {"oneOf": [{"$ref": f"#/$defs/{name}"} for name in ("no_block", *steps)]},
            "no_block": _blockless_schema(),
            **steps,
        },
    }


def describe(style: Style) -> dict[str, Any]:
    """The style as data for people and programs, with every value and what it may be."""
    fields = {key: getattr(style, key) for key in ("name", "note", *FIELDS)}
    fields["variants"] = {name: dict(values) for name, values in style.variants.items()}
    return fields | {layer: [_describe_step(step) for step in getattr(style, layer)] for layer in LAYERS}


def _describe_step(step: Step) -> dict[str, Any]:
    block = all_blocks().get(step.block)
    values = {
        name: {
            "value": step.values.get(name, parameter.default),
            "default": parameter.default,
            "range": parameter.control.range_text,
            "help": parameter.control.help,
        }
        for name, parameter in (block.parameters.items() if block else ())
    }
    help_text = block.help if block else ""
    return {
        "block": step.block,
        "help": help_text,
        "from": step.source,
        "save": step.save,
        "parameters": values,
    }


def _text_schemas() -> dict[str, Any]:
    texts = {key: {"type": "string", "maxLength": longest} for key, longest in TEXTS.items()}
    return {"format": {"const": FORMAT}} | texts


def _field_schemas() -> dict[str, Any]:
    return {
        key: control.schema(whole=False) | {"description": control.help} for key, control in FIELDS.items()
    }


def _variants_schema() -> dict[str, Any]:
    values = {
        "type": "object",
        "additionalProperties": False,
        "properties": _field_schemas(),
        "patternProperties": {"[.]": {"type": ["string", "number", "boolean"]}},
    }
    return {
        "type": "object",
        "description": 'Values by their paths, such as "posterize.levels", under a name for each variant.',
        "maxProperties": MAX_VARIANTS,
        "propertyNames": {"pattern": f"^{VARIANT_PATTERN}$"},
        "additionalProperties": values,
    }


def _layer_schema() -> dict[str, Any]:
    return {"type": "array", "maxItems": MAX_STEPS, "items": {"$ref": "#/$defs/step"}}


def _block_schema(block: Block) -> dict[str, Any]:
    parameters = {name: parameter.schema() for name, parameter in block.parameters.items()}
    return {
        "type": "object",
        "description": block.help,
        "required": ["block"],
        "additionalProperties": False,
        "properties": {"block": {"const": block.name}} | _name_schemas() | parameters,
    }


def _blockless_schema() -> dict[str, Any]:
    return {
        "type": "object",
        "description": "Only starts from a picture, or keeps the present one.",
        "minProperties": 1,
        "additionalProperties": False,
        "properties": _name_schemas(),
    }


def _name_schemas() -> dict[str, Any]:
    name = {"type": "string", "pattern": f"^{NAME_PATTERN}$"}
    return {
        "from": name | {"description": "the saved picture that this step starts from, or source"},
        "save": name | {"description": "the name under which the result is kept"},
    }
