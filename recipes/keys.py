"""Which keys a recipe knows: the JSON schema of the model, asked by YAML path."""

import difflib
from collections.abc import Iterable
from functools import cache
from typing import Any, TypeAlias, cast

from recipes.located import YamlPath
from recipes.recipe import Recipe

Schema: TypeAlias = dict[str, Any]


@cache
def model_schema() -> Schema:
    """JSON schema of a complete recipe, as pydantic makes it."""
    return Recipe.model_json_schema(by_alias=True)


def known_keys(path: YamlPath, data: Any) -> dict[str, Schema]:
    """Give the keys of the specification at a path, by name; empty where names are free.

    Args:
        path: From the top of the recipe.
        data: The recipe's plain values, which say what path class a template is of.
    """
    node = _resolve(model_schema(), data)
    for key in path:
        data = _inner(data, key)
        node = _resolve(_member(node, str(key)), data)
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


def _resolve(node: Schema, data: Any) -> Schema:
    """Follow references and choose the branch of a union that the data is meant for."""
    if "discriminator" in node:
        choice = node["discriminator"]
        tag = cast(Any, data).get(choice["propertyName"]) if isinstance(data, dict) else None
        reference = choice["mapping"].get(tag) if isinstance(tag, str) else None
        return {} if reference is None else _resolve({"$ref": reference}, data)
    if "anyOf" in node and isinstance(data, dict):
        for branch in node["anyOf"]:
            if "$ref" in branch or branch.get("type") == "object":
                return _resolve(branch, data)
    if "$ref" in node:
        name = str(node["$ref"]).rsplit("/", 1)[-1]
        return _resolve(model_schema()["$defs"][name], data)
    return node
