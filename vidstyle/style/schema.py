"""JSON Schema of style files, and the description of a style as plain data."""

from __future__ import annotations

from typing import Any

from vidstyle.block import NAME_PATTERN, Block
from vidstyle.blocks import all_blocks
from vidstyle.style.check import FORMAT_VERSION, MAX_STEPS, NOT_BEHIND, TEXTS
from vidstyle.style.knobs import MAX_KNOBS, MAX_LABEL_TEXT_LENGTH, MAX_LABELS
from vidstyle.style.mask_declarations import BACKDROP, MASK_VALUES, MAX_MASKS, REGIONS
from vidstyle.style.model import FIELDS, KINDS, LAYERS, Step, Style, table_from_style
from vidstyle.style.variants import MAX_VARIANTS, VARIANT_PATTERN

LAYER_SCHEMA = {"type": "array", "maxItems": MAX_STEPS, "items": {"$ref": "#/$defs/step"}}


def style_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of a style file, derived from the declarations of the blocks.

    Relations between steps, such as that a picture is saved before it is used, are not in the schema.
    """
    steps = {name: _block_schema(block) for name, block in all_blocks().items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "vidstyle style",
        "type": "object",
        "required": ["format"],
        "additionalProperties": False,
        "properties": {
            "format": {"const": FORMAT_VERSION},
            **_text_schemas(),
            **_page_schemas(),
            **_field_schemas(),
            "masks": _masks_schema(),
            **dict.fromkeys(LAYERS, LAYER_SCHEMA),
            "behind": _behind_schema(),
            "variants": _variants_schema(),
        },
        "$defs": {
            "step": {"oneOf": [{"$ref": f"#/$defs/{name}"} for name in ("no_block", *steps)]},
            "no_block": _blockless_schema(),
            **steps,
        },
    }


def describe(style: Style) -> dict[str, Any]:
    """Return the style as plain data, with every value, its range and its help."""
    fields: dict[str, Any] = {key: getattr(style, key) for key in ("name", "note", "aliases", *FIELDS)}
    fields["kinds"] = list(style.kinds)
    fields["knobs"] = list(style.knobs)
    fields |= {"labels": dict(style.labels)} if style.labels else {}
    fields |= {"masks": dict(style.masks)} if style.masks else {}
    fields |= {"behind": table_from_style(style)["behind"]} if style.behind else {}
    fields["variants"] = {name: dict(values) for name, values in style.variants.items()}
    return fields | {layer: list(map(_describe_step, steps)) for layer, steps in style.layers.items()}


def _describe_step(step: Step) -> dict[str, Any]:
    block = all_blocks().get(step.block)
    values = {
        name: {
            "value": step.values.get(name, parameter.default),
            "default": parameter.default,
            "range": parameter.control.range_text,
            "label": parameter.label,
            "help": parameter.control.help,
        }
        for name, parameter in (block.parameters.items() if block else ())
    }
    return {
        "block": step.block,
        "help": block.help if block else "",
        "from": step.source,
        "save": step.save,
        "mute": step.mute,
        "parameters": values,
    }


def _text_schemas() -> dict[str, Any]:
    return {key: {"type": "string", "maxLength": longest} for key, longest in TEXTS.items()}


def _page_schemas() -> dict[str, Any]:
    """Return the schemas of the fields by which pages list a style and its values."""
    return {
        "kinds": {
            "type": "array",
            "description": "Kinds of looks under which pages list the style.",
            "uniqueItems": True,
            "items": {"enum": list(KINDS)},
        },
        "knobs": {
            "type": "array",
            "description": 'Paths of the values to adjust first, such as "posterize.levels".',
            "maxItems": MAX_KNOBS,
            "uniqueItems": True,
            "items": {"type": "string"},
        },
        "labels": {
            "type": "object",
            "description": 'What values do in this style, by their paths: "Label", or "Label: help".',
            "maxProperties": MAX_LABELS,
            "additionalProperties": {"type": "string", "minLength": 1, "maxLength": MAX_LABEL_TEXT_LENGTH},
        },
    }


def _field_schemas() -> dict[str, Any]:
    controls = {key: parameter.control for key, parameter in FIELDS.items()}
    return {key: control.schema(False) | {"description": control.help} for key, control in controls.items()}


def _masks_schema() -> dict[str, Any]:
    mask = {
        "type": "object",
        "additionalProperties": False,
        "oneOf": [{"required": ["color"]}, {"required": ["file"]}],
        "properties": {name: parameter.schema() for name, parameter in MASK_VALUES.items()},
    }
    return {
        "type": "object",
        "description": "Masks by the names under which steps read them.",
        "maxProperties": MAX_MASKS,
        "propertyNames": {"pattern": f"^{NAME_PATTERN}$", "not": {"enum": ["source", *REGIONS, BACKDROP]}},
        "additionalProperties": mask,
    }


def _behind_schema() -> dict[str, Any]:
    fields = {name: schema for name, schema in _field_schemas().items() if name not in NOT_BEHIND}
    return {
        "type": "object",
        "description": "The style of everything except people.",
        "additionalProperties": False,
        "properties": _text_schemas() | fields | dict.fromkeys(LAYERS, LAYER_SCHEMA),
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
        "description": "Selects a saved picture as input, or saves the current one.",
        "minProperties": 1,
        "additionalProperties": False,
        "properties": _name_schemas(),
    }


def _name_schemas() -> dict[str, Any]:
    name = {"type": "string", "pattern": f"^{NAME_PATTERN}$"}
    return {
        "from": name | {"description": "input of the step: a saved picture, or source"},
        "save": name | {"description": "name under which the result is saved"},
        "mute": {"type": "boolean", "description": "whether to bypass the step: its input passes through"},
    }
