"""The table of a file's keys for people, made from the JSON schema of its model."""

import json
from collections.abc import Mapping
from typing import cast

from specs.yaml.document import Schema


def write_tables(heading: str, parts: Mapping[str, Schema], sections: Mapping[str, tuple[str, ...]]) -> str:
    """Write every key as Markdown: one table for each part, with defaults and what each key means.

    Args:
        heading: First lines of the page.
        parts: JSON schemas of the parts, by the name of their model.
        sections: Which parts come under which title, in order.
    """
    lines = [heading, ""]
    for title, names in sections.items():
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


def require_kind(part: Schema) -> Schema:
    """Require the key that tells the kind: to pydantic it has a default, but a file must state it."""
    kinds = [key for key, schema in cast("dict[str, Schema]", part["properties"]).items() if "const" in schema]
    return {**part, "required": [*kinds, *part.get("required", [])]} if kinds else part


def _entitle(title: str, part: Schema) -> str:
    kinds = [schema["const"] for schema in cast("dict[str, Schema]", part["properties"]).values() if "const" in schema]
    return f"{title}: {kinds[0]}" if kinds else title


def _describe(schema: Schema, parts: Mapping[str, Schema]) -> str:
    """Pydantic drops the description of a key where the part it refers to has the same."""
    if "description" in schema:
        return str(schema["description"])
    return str(parts[str(schema["$ref"]).rsplit("/", 1)[-1]]["description"])


def _show_default(schema: Schema) -> str:
    default = schema.get("default")
    if default in (None, [], "", {}):
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
            values = schema.get("additionalProperties", {"$ref": ""})
            return "mapping by name" if "$ref" in values else "mapping by class"
        case "boolean":
            return "true or false"
        case _:
            return "text"


def _bounds(schema: Schema) -> str:
    words = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    bounds = [f"{sign} {schema[key]:g}" for key, sign in words.items() if key in schema]
    return " " + ", ".join(bounds) if bounds else ""
