"""Which keys a file knows: the JSON schema of its model, asked by YAML path."""

import difflib
from collections.abc import Iterable
from typing import Any, cast

from specs.yaml.document import Document, Schema
from specs.yaml.located import YamlPath


def known_keys(path: YamlPath, data: Any, document: Document) -> dict[str, Schema]:
    """Give the keys of the specification at a path, by name; empty where names are free.

    Args:
        path: From the top of the file.
        data: Its plain values, which say what kind something is of, such as the path class of a template.
        document: What kind of file it is.
    """
    whole = document.schema()
    node = _resolve(whole, data, whole)
    for key in path:
        data = _inner(data, key)
        node = _resolve(_member(node, str(key)), data, whole)
    return cast("dict[str, Schema]", node.get("properties", {}))


def name_nearest(name: str, known: Iterable[str]) -> str:
    """Say which known name was probably meant, and all that are known."""
    names = list(known)
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    listed = ", ".join(names) if names else "none"
    return f"did you mean {near[0]!r}? Known: {listed}" if near else f"known: {listed}"


def _inner(data: Any, key: str | int) -> Any:
    if isinstance(data, dict):
        return cast("dict[Any, Any]", data).get(key)
    if isinstance(data, list) and isinstance(key, int):
        items = cast("list[Any]", data)
        return items[key] if key < len(items) else None
    return None


def _member(node: Schema, key: str) -> Schema:
    properties = cast("dict[str, Schema]", node.get("properties", {}))
    if key in properties:
        return properties[key]
    for pattern in cast("dict[str, Schema]", node.get("patternProperties", {})).values():
        return pattern
    items = node.get("items", node.get("additionalProperties", {}))
    return cast(Schema, items) if isinstance(items, dict) else {}


def _resolve(node: Schema, data: Any, whole: Schema) -> Schema:
    """Follow references and choose the branch of a union that the data is meant for."""
    if "discriminator" in node:
        choice = node["discriminator"]
        tag = cast(Any, data).get(choice["propertyName"]) if isinstance(data, dict) else None
        reference = choice["mapping"].get(tag) if isinstance(tag, str) else None
        return {} if reference is None else _resolve({"$ref": reference}, data, whole)
    if "anyOf" in node and isinstance(data, dict):
        for branch in node["anyOf"]:
            if "$ref" in branch or branch.get("type") == "object":
                return _resolve(branch, data, whole)
    if "$ref" in node:
        name = str(node["$ref"]).rsplit("/", 1)[-1]
        return _resolve(whole["$defs"][name], data, whole)
    return node
