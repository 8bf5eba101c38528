"""A specification as a form: its inputs, and what their values change in the recipe."""

import math
import re
import types
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, TypeAlias, Union, cast, get_args, get_origin

from pydantic.fields import FieldInfo

from specs.spec import Spec
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree

Kind: TypeAlias = Literal["number", "integer", "text", "boolean", "choice", "list", "pair", "table"]
InputValue: TypeAlias = str | bool
"""Value of an input: a tick or a text; an empty text states nothing."""
Names: TypeAlias = Mapping[str, tuple[str, ...]]
"""What exists in a recipe: names by section, such as ``{"nozzles": ("ring60", "knife")}``."""

DEFAULT = "default"
"""Stands for all classes that a value by class does not list."""
_UNITS = {
    "_mohm_cm": "MΩ·cm", "_mm_s2": "mm/s²", "_deg_s2": "°/s²", "_mm_s": "mm/s", "_deg_s": "°/s", "_mm2": "mm²",
    "_mm": "mm", "_deg": "°", "_bar": "bar", "_lpm": "l/min", "_c": "°C", "_s": "s", "_kg": "kg",
}  # fmt: skip
_SPELT = {"xyz": "X, y, z", "rpy": "Roll, pitch, yaw", "tcp": "TCP"}
"""Keys that are abbreviations."""
_SECTION = {"function": "functions", "nozzle": "nozzles", "paths": "templates", "only": "classes"}
"""Fields that name an entry of the recipe, and the section of that entry."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_COMMA = re.compile(r",(?![^\[]*\])")  # a comma in brackets belongs to a shell pattern
_GAP = re.compile(r"[,;\s]+")


@dataclass(frozen=True, slots=True)
class Field:
    """One input of a form."""

    path: YamlPath
    """Relative to the part of the recipe that the form edits."""
    label: str
    kind: Kind
    value: InputValue
    """Value that the recipe states, else the default."""
    hint: str
    options: tuple[str, ...] = ()
    """Choices, or the words that are allowed besides a number; an empty one states nothing."""
    unit: str = ""
    group: str = ""
    """Folder of the input; empty for the form itself."""


def describe(
    spec: type[Spec], stated: Mapping[str, Tree], names: Names, keys: Collection[str] = ()
) -> tuple[Field, ...]:
    """Inputs of a specification, required ones first and folders last.

    Args:
        spec: The specification.
        stated: Values that the recipe states, as plain YAML values; aliases as keys.
        names: Names that the recipe has to choose from.
        keys: Which keys of the specification; all of them if none is named.
    """
    lineage = [each for each in spec.__mro__ if issubclass(each, Spec)]

    def rank(item: tuple[str, FieldInfo]) -> tuple[bool, int]:
        """Required keys, then those of the class itself, then those it shares with others."""
        depth = next(index for index, each in enumerate(lineage) if item[0] in each.__annotations__)
        return not item[1].is_required(), depth

    found = [
        each
        for name, info in sorted(spec.model_fields.items(), key=rank)
        if not keys or name in keys
        for each in _describe_field(name, info, stated.get(info.alias or name), names)
    ]
    return (*(each for each in found if not each.group), *(each for each in found if each.group))


def label_and_unit(name: str) -> tuple[str, str]:
    """Split the name of a key into words for a label and its unit, which may be empty."""
    suffix, unit = next((each for each in _UNITS.items() if name.endswith(each[0]) and name != each[0]), ("", ""))
    stem = name.removesuffix(suffix)
    return _SPELT.get(stem) or stem.replace("_", " ").capitalize(), unit


def _describe_field(name: str, info: FieldInfo, stated: Tree, names: Names) -> list[Field]:
    members = _members(info.annotation)
    key, default = info.alias or name, None if info.is_required() else info.get_default(call_default_factory=False)
    title, unit = label_and_unit(name)
    nested = next((each for each in members if isinstance(each, type) and issubclass(each, Spec)), None)
    if nested is not None:
        return _describe_nested(key, nested, (title, unit), info, cast("Mapping[str, Tree]", stated or {}))
    label = f"{title} ({unit})" if unit else title
    kind, options = _kind(name, members, info, names)
    if kind == "choice" and len(options) == 1 and name in ("path", "pattern", "kind"):
        return []  # the kind of a specification, which no form changes
    rows = cast("dict[str, Tree]", stated) if isinstance(stated, dict) else {}
    value = rows.get(DEFAULT) if isinstance(stated, dict) else default if stated is None else stated
    first = Field((key,), label, kind, _spell(kind, value), _hint(info, default, kind, options), options, unit)
    if not any(get_origin(each) is dict for each in members):
        return [first]
    by_class = [
        Field(
            path=(key, each),
            label=each,
            kind=kind,
            value=_spell(kind, rows.get(each)),
            hint=f"{label} for the class {each}; empty: as for all others.",
            unit=unit,
            group=f"{label} by class",
        )
        for each in names.get("classes", ())
    ]
    return [first, *by_class]


def _describe_nested(
    key: str, nested: type[Spec], title: tuple[str, str], info: FieldInfo, stated: Mapping[str, Tree]
) -> list[Field]:
    """Fields of a nested specification in a folder; an interval is two fields beside the others."""
    words, unit = title
    if set(nested.model_fields) != {"min", "max"}:
        return [replace(each, path=(key, *each.path), group=words) for each in describe(nested, stated, {})]
    return [
        Field(
            path=(key, *each.path),
            label=f"{words} {each.label.lower()}" + (f" ({unit})" if unit else ""),
            kind=each.kind,
            value=each.value,
            hint=f"{info.description} {each.hint}",
            unit=unit,
        )
        for each in describe(nested, stated, {})
    ]


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
    if words and any(get_origin(each) is list for each in members):
        return "table", words
    if words or listed is not None:
        return "choice", (*optional, *(words or cast("re.Match[str]", listed)[1].split("|")))
    if str in members:
        return ("choice", known) if known else ("text", ())
    inner = next(each for each in members if get_origin(each) in (tuple, list))
    if get_origin(inner) is tuple:
        return "pair", ()
    return ("list", known) if _members(get_args(inner)[0]) == [str] else ("table", ())


def _members(annotation: Any) -> list[Any]:
    """Alternatives of a type, without bounds."""
    origin = get_origin(annotation)
    if origin is Annotated:
        return _members(get_args(annotation)[0])
    if origin in (Union, types.UnionType):
        return [inner for each in get_args(annotation) for inner in _members(each)]
    return [annotation]


def _hint(info: FieldInfo, default: Tree, kind: Kind, options: tuple[str, ...]) -> str:
    parts = [info.description or ""]
    if options and kind == "list":
        parts.append(f"Separated by commas; there are {', '.join(options)}.")
    elif options and kind == "table":
        parts.append(f"A line for each row, or {' or '.join(options)}.")
    elif options and kind != "choice":
        parts.append(f"A number, or {' or '.join(options)}.")
    elif kind == "list":
        parts.append("Separated by commas.")
    if info.is_required():
        parts.append("Needed.")
    elif kind not in ("choice", "boolean") and _plain(default):
        parts.append(f"Left empty: {_plain(default)}.")
    return " ".join(parts)


def _spell(kind: Kind, value: Tree) -> InputValue:
    if kind == "boolean":
        return bool(value)
    if kind == "table" and not isinstance(value, str):
        return "\n".join(" ".join(_plain(item) for item in row) for row in cast("list[list[Tree]]", value or []))
    return _plain(value)


def _plain(value: Tree) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_plain(item) for item in cast("list[Tree]", value))
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    return "" if value is None else str(value)


def parse(field: Field, value: InputValue) -> Tree:
    """Value of the recipe for the value of an input; ``None`` states nothing.

    What cannot be read stays text: the recipe's own check states then what is required.
    """
    if isinstance(value, bool):
        return value
    text = value.strip()
    if not text:
        return None
    match field.kind:
        case "number" | "integer":
            return _number(text, field)
        case "list":
            return [item.strip() for item in _COMMA.split(text) if item.strip()]
        case "pair":
            return [_number(item, field) for item in _GAP.split(text)]
        case "table":
            if text in field.options:
                return text
            lines = [line.strip() for line in text.splitlines() if line.strip()]
            return [[_number(item, field) for item in _GAP.split(line)] for line in lines]
        case _:
            return text


def changes(fields: Iterable[Field], values: Iterable[InputValue], stated: Mapping[str, Tree]) -> dict[YamlPath, Tree]:
    """Changes of the recipe that a filled-in form makes.

    Returns:
        Path relative to the part that the form edits, and its new value; ``None`` takes it out.
    """
    inputs = list(zip(fields, values, strict=True))
    found: dict[YamlPath, Tree] = {}
    for key in dict.fromkeys(field.path[0] for field, value in inputs if value != field.value):
        parsed = [(field.path[1:], parse(field, value)) for field, value in inputs if field.path[0] == key]
        alone = [value for rest, value in parsed if not rest]
        rows = {rest[0]: value for rest, value in parsed if len(rest) == 1 and value is not None}
        new: Tree = rows or None  # one value, one by class, or a part of its own
        if alone:
            new = alone[0] if not rows else rows if alone[0] is None else {**rows, DEFAULT: alone[0]}
        found.update(_differences(stated.get(str(key)), new, (key,)))
    return found


def field_at(fields: Iterable[Field], base: YamlPath, path: str) -> Field | None:
    """Input at the path of an error, such as ``"templates.around.speed_mm_s"``, or the nearest above or below it."""
    spelt = {spell_path((*base, *field.path)): field for field in fields}
    near = [place for place in spelt if place == path or re.match(re.escape(place) + r"[.\[]", path)]
    if not near:
        near = [place for place in spelt if path and re.match(re.escape(path) + r"[.\[]", place)][:1]
    inside = path.startswith(spell_path(base)) and path != spell_path(base)
    return spelt[max(near, key=len)] if near and inside else None


def _number(text: str, field: Field) -> Tree:
    bare = text.removesuffix(field.unit).strip() if field.unit else text
    if len(bare) <= 40 and _NUMBER.fullmatch(bare):
        number = float(bare)
        if math.isfinite(number):
            return int(bare) if re.fullmatch(r"[+-]?\d+", bare) else number
    word = bare.replace(" ", "_").lower()
    return word if word in field.options else text


def _differences(old: Tree, new: Tree, path: YamlPath) -> dict[YamlPath, Tree]:
    if isinstance(old, dict) and isinstance(new, dict):
        before, after = cast("dict[str, Tree]", old), cast("dict[str, Tree]", new)
        found: dict[YamlPath, Tree] = {(*path, key): None for key in before if key not in after}
        for key, value in after.items():
            found.update(_differences(before.get(key), value, (*path, key)))
        return found
    same = type(old) is type(new) or not (isinstance(old, bool) or isinstance(new, bool))
    return {} if same and old == new else {path: new}
