"""JSON schemas of YAML files: the keys known at a path, the schema for editors, the tables of keys for people."""

import difflib
import json
from collections.abc import Iterable, Mapping
from typing import Any, cast

from specs.spec import Spec, write_number
from specs.yaml.file_kind import FileKind, Schema
from specs.yaml.located import YamlPath

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_OVERRIDE = "Override"
_BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def name_nearest(name: str, known: Iterable[str]) -> str:
    """Suggest the known name that is nearest, and list all that are known."""
    names = list(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    listed = ", ".join(names) if names else "none"
    return f"did you mean {near[0]!r}? Known: {listed}" if near else f"known: {listed}"


def known_keys(path: YamlPath, data: Any, kind: FileKind[Spec]) -> dict[str, Schema]:
    """Give the schemas of the keys at a path, by name; empty where names are free.

    Args:
        path: From the top of the file.
        data: Its plain values, which choose among variants, such as the path class of a template.
        kind: Kind of the file.
    """
    whole = kind.schema()
    node, data = _node_at(path, data, whole)
    return cast("dict[str, Schema]", _resolve(node, data, whole).get("properties", {}))


def kinds_with(name: str, path: YamlPath, data: Any, kind: FileKind[Spec]) -> str:
    """Name the other variants at a path that have a key, such as path classes; empty where none has it."""
    whole = kind.schema()
    node, data = _node_at(path, data, whole)
    if "discriminator" not in node:
        return ""
    tag = str(node["discriminator"]["propertyName"])
    mapping = cast("dict[str, str]", node["discriminator"]["mapping"])
    variants = [each for each in mapping if name in _resolve(node, {tag: each}, whole).get("properties", {})]
    *first, last = variants or [""]
    listed = f"{', '.join(first)} and {last} have" if first else f"{last} has"
    return f"no key of {_value_at(data, tag)}; {listed} it" if variants else ""


def _node_at(path: YamlPath, data: Any, whole: Schema) -> tuple[Schema, Any]:
    """Follow a path through schema and data; a union at its end is not resolved."""
    node = whole
    for key in path:
        node = _resolve(node, data, whole)
        # A key of the model, a name of a mapping of named entries, or an index of a list.
        patterns = list(node.get("patternProperties", {}).values())
        others = patterns[0] if patterns else node.get("items", node.get("additionalProperties", {}))
        inner = node.get("properties", {}).get(str(key), others)
        node = cast(Schema, inner) if isinstance(inner, dict) else {}
        data = _value_at(data, key)
    return node, data


def _value_at(data: Any, key: str | int) -> Any:
    if isinstance(data, dict):
        return cast("dict[Any, Any]", data).get(key)
    items = cast("list[Any]", data) if isinstance(data, list) else []
    return items[key] if isinstance(key, int) and key < len(items) else None


def _resolve(node: Schema, data: Any, whole: Schema) -> Schema:
    """Follow references, and choose the branch of a union by the data."""
    if "discriminator" in node:
        choice = node["discriminator"]
        tag = _value_at(data, choice["propertyName"])
        reference = choice["mapping"].get(tag) if isinstance(tag, str) else None
        return {} if reference is None else _resolve({"$ref": reference}, data, whole)
    if "anyOf" in node and isinstance(data, dict):
        for branch in node["anyOf"]:
            if "$ref" in branch or branch.get("type") == "object":
                return _resolve(branch, data, whole)
    if "$ref" in node:
        return _resolve(whole["$defs"][_referred(node)], data, whole)
    return node


def _referred(node: Schema) -> str:
    return str(node["$ref"]).rsplit("/", 1)[-1]


def schema_parts(kind: FileKind[Spec]) -> dict[str, Schema]:
    """JSON schemas of the parts of a file by the name of their model.

    A constant key that identifies a variant is required: to pydantic it has a default, but a file must state it.
    """
    parts = dict(cast("dict[str, Schema]", kind.schema()["$defs"]))
    for name, part in parts.items():
        if constants := _constants(part):
            parts[name] = {**part, "required": [*constants, *part.get("required", [])]}
    return parts


def _constants(part: Schema) -> dict[str, Any]:
    """Keys with the one value that they may have."""
    properties = cast("dict[str, Schema]", part["properties"])
    return {key: schema["const"] for key, schema in properties.items() if "const" in schema}


def extending_schema(kind: FileKind[Spec], description: str) -> str:
    """Write the JSON schema of a kind of file of which one may extend another.

    A file that extends another one states only what it changes, so nothing is required of it and ``null`` removes.
    """
    name = kind.model.__name__
    parts = {**schema_parts(kind), name: {key: value for key, value in kind.schema().items() if key != "$defs"}}
    overrides = {part + _OVERRIDE: _loosen(schema) for part, schema in parts.items()}
    schema = {
        "$schema": DIALECT,
        "title": f"Washboard {kind.noun}",
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
    if "discriminator" in node:  # the key of the variant may be inherited: any variant that fits will do
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


def key_tables(kind: FileKind[Spec], sections: Mapping[str, tuple[str, ...]]) -> str:
    """Write every key of a kind of file as Markdown: one table for each part, with defaults and descriptions.

    Args:
        kind: Kind of the file.
        sections: Which parts come under which title, in order, by the name of their model.
    """
    parts = {**schema_parts(kind), kind.model.__name__: kind.schema()}
    lines = [f"# Every key of a {kind.noun}", "", f"Made by `{kind.command} keys`; units are in the names.", ""]
    for title, part in ((title, parts[name]) for title, names in sections.items() for name in names):
        constants = _constants(part)
        heading = ": ".join([title, *(str(value) for value in constants.values())][:2])
        lines += [f"## {heading}", "", str(part["description"]), ""]
        lines += ["| key | takes | default | meaning |", "|---|---|---|---|"]
        rows = cast("dict[str, Schema]", part["properties"])
        for key in sorted(rows, key=lambda key: key not in constants):
            default = "needed" if key in part.get("required", []) else _default(rows[key])
            # Pydantic drops the description of a key where the part it refers to has the same.
            meaning = rows[key] if "description" in rows[key] else parts[_referred(rows[key])]
            lines.append(f"| `{key}` | {_takes(rows[key])} | {default} | {meaning['description']} |")
        lines.append("")
    return "\n".join(lines)


def _default(schema: Schema) -> str:
    default = schema.get("default")
    if default in (None, [], "", {}):
        return "none"
    if isinstance(default, dict):
        return "see there"
    return f"`{default:g}`" if isinstance(default, float) else f"`{json.dumps(default)}`".replace('"', "")


def _takes(schema: Schema) -> str:
    """Describe the values of a key in a few words."""
    if "anyOf" in schema:
        return " or ".join(_takes(branch) for branch in schema["anyOf"] if branch.get("type") != "null")
    if "enum" in schema:
        return ", ".join(f"`{choice}`" for choice in schema["enum"])
    if "const" in schema:
        return f"`{schema['const']}`"
    if "$ref" in schema:
        return "mapping"
    match schema.get("type"):
        case "number" | "integer" as number:
            bounds = ", ".join(f"{sign} {write_number(schema[key])}" for key, sign in _BOUNDS.items() if key in schema)
            return f"{'number' if number == 'number' else 'whole number'} {bounds}".rstrip()
        case "array":
            return "list"
        case "object":
            values = schema.get("additionalProperties", {"$ref": ""})
            return "mapping by name" if "$ref" in values else "mapping by class"
        case "boolean":
            return "true or false"
        case _:
            return "text"
