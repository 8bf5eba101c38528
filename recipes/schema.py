"""The recipe's JSON schema for editors, and the table of its keys for people: both made from the model."""

import json
from typing import Any, cast

from recipes.document import model_schema
from specs.yaml.document import Schema
from specs.yaml.key_tables import require_kind, write_tables

_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_OVERRIDE = "Override"
_SECTIONS = {
    "The recipe": ("Recipe",),
    "functions": ("Function",),
    "nozzles": ("HollowCone", "FullCone", "FlatFan", "AirKnife"),
    "nozzles: wavefront of a hollow_cone": ("Wavefront",),
    "classes": ("ComponentClass",),
    "classes: pins, area_mm2, height_mm, standoff_mm, neighbour_mm": ("Range",),
    "masks": ("Mask",),
    "templates": ("BoardPerimeter", "Raster", "ComponentPerimeter", "FinalFlush", "StepFunction", "StraightLine"),
    "templates: near of a component_perimeter": ("Near",),
    "limits": ("Limits",),
    "sequence": ("Step",),
    "sequence: until": ("Until",),
}


def recipe_schema() -> str:
    """Write the JSON schema of a recipe file, with a line feed at the end."""
    means = "What a process engineer asks for: functions, nozzles, classes, masks, templates, sequence."
    return extending_schema("Recipe", model_schema(), "Washboard recipe", means)


def extending_schema(name: str, whole: Schema, title: str, description: str) -> str:
    """Write the JSON schema of a kind of file of which one may extend another.

    A file that extends another one states only what it changes, so nothing is required of it and ``null`` removes.

    Args:
        name: Of the model of the whole file.
        whole: JSON schema of a complete file, as pydantic makes it.
        title: Of the schema.
        description: What such a file says.
    """
    parts = {part: require_kind(schema) for part, schema in cast("dict[str, Schema]", whole["$defs"]).items()}
    parts[name] = {key: value for key, value in whole.items() if key != "$defs"}
    overrides = {part + _OVERRIDE: _loosen(schema) for part, schema in parts.items()}
    schema = {
        "$schema": _DIALECT,
        "title": title,
        "description": description,
        "type": "object",
        "if": {"required": ["extends"], "properties": {"extends": {"type": "string"}}},
        "then": {"$ref": f"#/$defs/{name}{_OVERRIDE}"},
        "else": {"$ref": f"#/$defs/{name}"},
        "$defs": {**parts, **overrides},
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def _loosen(value: Any) -> Any:
    """Make the schema of what overrides something inherited: every key may be left out, or be null."""
    if isinstance(value, list):
        return [_loosen(item) for item in cast("list[Any]", value)]
    if not isinstance(value, dict):
        return value
    node = cast(Schema, value)
    if "discriminator" in node:  # the key that tells the kind may be inherited: any kind that fits will do
        return {"anyOf": [_loosen(branch) for branch in node["oneOf"]]}
    loose = {key: _loosen(item) for key, item in node.items() if key != "required"}
    if "$ref" in loose:
        loose["$ref"] += _OVERRIDE
    for key in ("properties", "patternProperties"):
        if key in loose:
            loose[key] = {name: _or_null(inner) for name, inner in loose[key].items()}
    if isinstance(loose.get("additionalProperties"), dict):
        loose["additionalProperties"] = _or_null(loose["additionalProperties"])
    return loose


def _or_null(schema: Schema) -> Schema:
    """Allow null too, with the description outside, where editors look for it."""
    description = {"description": schema["description"]} if "description" in schema else {}
    return {**description, "anyOf": [schema, {"type": "null"}]}


def recipe_keys() -> str:
    """Write every key of a recipe as Markdown: one table for each part, with defaults and what each key means."""
    parts = {name: require_kind(part) for name, part in cast("dict[str, Schema]", model_schema()["$defs"]).items()}
    parts["Recipe"] = model_schema()
    heading = "# Every key of a recipe\n\nMade by `washboard recipe keys`; units are in the names."
    return write_tables(heading, parts, _SECTIONS)
