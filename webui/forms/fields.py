"""A specification as a form: what can be typed and what stands there."""

import re
import types
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeAlias, Union, cast, get_args, get_origin

from pydantic.fields import FieldInfo

from specs.spec import Spec
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree

Kind: TypeAlias = Literal["number", "integer", "text", "boolean", "choice", "list", "pair", "table"]
Shown: TypeAlias = str | bool
"""What stands in an input: a mark or a text; an empty text states nothing."""
Names: TypeAlias = Mapping[str, tuple[str, ...]]
"""What exists in a recipe: names by section, such as ``{"nozzles": ("ring60", "knife")}``."""

DEFAULT = "default"
"""Stands for all classes that a value by class does not list."""
_UNITS = {
    "_mohm_cm": "MΩ·cm", "_mm_s2": "mm/s²", "_deg_s2": "°/s²", "_mm_s": "mm/s", "_deg_s": "°/s", "_mm2": "mm²",
    "_mm": "mm", "_deg": "°", "_bar": "bar", "_lpm": "l/min", "_c": "°C", "_s": "s",
}  # fmt: skip
_SECTION = {"function": "functions", "nozzle": "nozzles", "paths": "templates", "only": "classes"}
"""Fields that name something of the recipe, and the section it stands in."""


@dataclass(frozen=True, slots=True)
class Field:
    """One input of a form."""

    path: YamlPath
    """From the part of the recipe that the form is about."""
    label: str
    kind: Kind
    value: Shown
    """What stands in it; for what is not stated the default."""
    hint: str
    options: tuple[str, ...] = ()
    """What can be chosen, or the words that are allowed besides a number; an empty one states nothing."""
    unit: str = ""
    group: str = ""
    """Folder it stands in; empty for the form itself."""


def describe(
    spec: type[Spec], stated: Mapping[str, Tree], names: Names, keys: Collection[str] = ()
) -> tuple[Field, ...]:
    """Describe the form of a specification, what must be stated first and folders last.

    Args:
        spec: Which one.
        stated: What the recipe states, as plain YAML values; aliases as keys.
        names: What the recipe has to choose from.
        keys: Which keys of the specification; all of them if none is named.
    """
    found = [
        each
        for name, info in _in_order(spec)
        if not keys or name in keys
        for each in _describe_field(name, info, stated.get(info.alias or name), names)
    ]
    return (*(each for each in found if not each.group), *(each for each in found if each.group))


def entitle(name: str) -> tuple[str, str]:
    """Split the name of a key into words for a label and its unit, which may be empty."""
    for suffix, unit in _UNITS.items():
        if name.endswith(suffix) and name != suffix:
            name = name.removesuffix(suffix)
            return name.replace("_", " ").capitalize(), unit
    return name.replace("_", " ").capitalize(), ""


def _in_order(spec: type[Spec]) -> list[tuple[str, FieldInfo]]:
    """What must be stated, then what the class itself adds, then what it shares with others."""
    line = [each for each in spec.__mro__ if issubclass(each, Spec)]

    def rank(item: tuple[str, FieldInfo]) -> tuple[bool, int]:
        depth = next(index for index, each in enumerate(line) if item[0] in each.__annotations__)
        return not item[1].is_required(), depth

    return sorted(spec.model_fields.items(), key=rank)


def _describe_field(name: str, info: FieldInfo, stated: Tree, names: Names) -> list[Field]:
    members = _members(info.annotation)
    key, default = info.alias or name, _default(info)
    title, unit = entitle(name)
    nested = next((each for each in members if isinstance(each, type) and issubclass(each, Spec)), None)
    if nested is not None:
        return _describe_nested(key, nested, (title, unit), info, cast("Mapping[str, Tree]", stated or {}))
    label = f"{title} ({unit})" if unit else title
    kind, options = _kind(name, members, info, names)
    by_class = any(get_origin(each) is dict for each in members)
    if kind == "choice" and len(options) == 1 and name in ("path", "pattern"):
        return []  # what kind of specification it is, which no form changes
    value = cast("dict[str, Tree]", stated).get(DEFAULT) if isinstance(stated, dict) else stated
    first_value = value if value is not None or isinstance(stated, dict) else default
    hint = _hint(info, default, kind, options)
    first = Field((key,), label, kind, _show(kind, first_value), hint, options, unit)
    if not by_class:
        return [first]
    rows = cast("dict[str, Tree]", stated) if isinstance(stated, dict) else {}
    return [first, *(_class_row(first, each, rows.get(each)) for each in names.get("classes", ()))]


def _describe_nested(
    key: str, nested: type[Spec], title: tuple[str, str], info: FieldInfo, stated: Mapping[str, Tree]
) -> list[Field]:
    """Put the fields of a part into a folder; an interval is two fields beside the others."""
    inner = describe(nested, stated, {})
    words, unit = title
    if set(nested.model_fields) == {"min", "max"}:
        return [
            Field(
                path=(key, *each.path),
                label=f"{words} {each.label.lower()}" + (f" ({unit})" if unit else ""),
                kind=each.kind,
                value=each.value,
                hint=f"{info.description} {each.hint}",
                unit=unit,
            )
            for each in inner
        ]
    return [
        Field((key, *each.path), each.label, each.kind, each.value, each.hint, each.options, each.unit, words)
        for each in inner
    ]


def _class_row(first: Field, name: str, value: Tree) -> Field:
    hint = f"{first.label} for the class {name}; empty: as for all others."
    shown = _show(first.kind, value)
    return Field((*first.path, name), name, first.kind, shown, hint, unit=first.unit, group=f"{first.label} by class")


def _kind(name: str, members: list[Any], info: FieldInfo, names: Names) -> tuple[Kind, tuple[str, ...]]:
    known = names.get(_SECTION.get(name, ""), ())
    words = next((get_args(each) for each in members if get_origin(each) is Literal), ())
    optional = ("",) if type(None) in members else ()
    bounded = next((each for each in info.metadata if getattr(each, "pattern", None)), None)
    listed = re.fullmatch(r"\^\(([a-z|]+)\)\$", str(getattr(bounded, "pattern", "")))
    if bool in members:
        return "boolean", ()
    if any(each in members for each in (float, int)):
        return "number" if float in members else "integer", words
    if words or listed is not None:
        return "choice", (*optional, *(words or cast("re.Match[str]", listed)[1].split("|")))
    if str in members:
        return ("choice", known) if known else ("text", ())
    inner = next(each for each in members if get_origin(each) in (tuple, list))
    if get_origin(inner) is tuple:
        return "pair", ()
    return ("list", known) if _members(get_args(inner)[0]) == [str] else ("table", ())


def _members(annotation: Any) -> list[Any]:
    """Take a type apart into what a value may be, without the bounds it must keep."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return _members(get_args(annotation)[0])
    if origin in (Union, types.UnionType):
        return [inner for each in get_args(annotation) for inner in _members(each)]
    return [annotation]


def _default(info: FieldInfo) -> Tree:
    return None if info.is_required() else info.get_default(call_default_factory=False)


def _hint(info: FieldInfo, default: Tree, kind: Kind, options: tuple[str, ...]) -> str:
    told = [info.description or ""]
    if options and kind == "list":
        told.append(f"Separated by commas; there are {', '.join(options)}.")
    elif options and kind != "choice":
        told.append(f"A number, or {' or '.join(options)}.")
    elif kind == "list":
        told.append("Separated by commas.")
    if info.is_required():
        told.append("Needed.")
    elif kind not in ("choice", "boolean") and _plain(default):
        told.append(f"Left empty: {_plain(default)}.")
    return " ".join(told)


def _show(kind: Kind, value: Tree) -> Shown:
    if kind == "boolean":
        return bool(value)
    if kind == "table":
        return "\n".join(" ".join(_plain(item) for item in row) for row in cast("list[list[Tree]]", value or []))
    return _plain(value)


def _plain(value: Tree) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_plain(item) for item in cast("list[Tree]", value))
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return "" if value is None else str(value)
