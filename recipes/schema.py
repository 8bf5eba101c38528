"""The recipe's JSON schema for editors, and the table of its keys for people: both made from the model."""

import json
from typing import Any, cast

from recipes.document import Schema, model_schema

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
    """Write the JSON schema of a recipe file, with a line feed at the end.

    A file that extends another one states only what it changes, so nothing is required of it and ``null`` removes.
    """
    whole = model_schema()
    parts = {name: _require_kind(part) for name, part in cast("dict[str, Schema]", whole["$defs"]).items()}
    parts["Recipe"] = {key: value for key, value in whole.items() if key != "$defs"}
    overrides = {name + _OVERRIDE: _loosen(part) for name, part in parts.items()}
    schema = {
        "$schema": _DIALECT,
        "title": "Washboard recipe",
        "description": "What a process engineer asks for: functions, nozzles, classes, masks, templates, sequence.",
        "type": "object",
        "if": {"required": ["extends"], "properties": {"extends": {"type": "string"}}},
        "then": {"$ref": f"#/$defs/Recipe{_OVERRIDE}"},
        "else": {"$ref": "#/$defs/Recipe"},
        "$defs": {**parts, **overrides},
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def _require_kind(part: Schema) -> Schema:
    """Require the key that tells the kind: to pydantic it has a default, but a file must state it."""
    kinds = [key for key, schema in cast("dict[str, Schema]", part["properties"]).items() if "const" in schema]
    return {**part, "required": [*kinds, *part.get("required", [])]} if kinds else part


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
    parts = {name: _require_kind(part) for name, part in cast("dict[str, Schema]", model_schema()["$defs"]).items()}
    parts["Recipe"] = model_schema()
    lines = ["# Every key of a recipe", "", "Made by `washboard recipe keys`; units are in the names.", ""]
    for title, names in _SECTIONS.items():
        for name in names:
            part = parts[name]
            lines += [f"## {_entitle(title, part)}", "", str(part["description"]), ""]
            lines += ["| key | takes | default | meaning |", "|---|---|---|---|"]
            required = cast("list[str]", part.get("required", []))
            rows = cast("dict[str, Schema]", part["properties"])
            for key in sorted(rows, key=lambda key: "const" not in rows[key]):
                default = "needed" if key in required else _show_default(rows[key])
                lines.append(f"| `{key}` | {_takes(rows[key])} | {default} | {_describe(rows[key], parts)} |")
            lines.append("")
    return "\n".join(lines)


def _entitle(title: str, part: Schema) -> str:
    kinds = [schema["const"] for schema in cast("dict[str, Schema]", part["properties"]).values() if "const" in schema]
    return f"{title}: {kinds[0]}" if kinds else title


def _describe(schema: Schema, parts: dict[str, Schema]) -> str:
    """Pydantic drops the description of a key where the part it refers to has the same."""
    if "description" in schema:
        return str(schema["description"])
    return str(parts[str(schema["$ref"]).rsplit("/", 1)[-1]]["description"])


def _show_default(schema: Schema) -> str:
    default = schema.get("default")
    if default in (None, [], ""):
        return "none"
    if isinstance(default, dict):
        return "see there"
    return f"`{default:g}`" if isinstance(default, float) else f"`{json.dumps(default)}`".replace('"', "")


def _takes(schema: Schema) -> str:
    """Say in a few words what a key takes."""
    if "anyOf" in schema:
        return " or ".join(_takes(branch) for branch in schema["anyOf"] if branch.get("type") != "null")
    if "enum" in schema:
        return ", ".join(f"`{choice}`" for choice in schema["enum"])
    if "const" in schema:
        return f"`{schema['const']}`"
    if "$ref" in schema:
        return "mapping"
    match schema.get("type"):
        case "number" | "integer":
            return ("number" if schema["type"] == "number" else "whole number") + _bounds(schema)
        case "array":
            return "list"
        case "object":
            return "mapping by class" if "additionalProperties" in schema else "mapping by name"
        case "boolean":
            return "true or false"
        case _:
            return "text"


def _bounds(schema: Schema) -> str:
    words = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    bounds = [f"{sign} {schema[key]:g}" for key, sign in words.items() if key in schema]
    return " " + ", ".join(bounds) if bounds else ""
