"""What an answered form changes in the recipe."""

import math
import re
from collections.abc import Iterable, Mapping
from typing import cast

from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.forms.fields import DEFAULT, Field, Shown

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_COMMA = re.compile(r",(?![^\[]*\])")  # a comma in brackets belongs to a shell pattern


def parse(field: Field, shown: Shown) -> Tree:
    """Turn what stands in an input into a value of the recipe; ``None`` states nothing.

    What cannot be read stays text: the recipe's own check says then what is wanted.
    """
    if isinstance(shown, bool):
        return shown
    text = shown.strip()
    if not text:
        return None
    match field.kind:
        case "number" | "integer":
            return _number(text, field)
        case "list":
            return [item.strip() for item in _COMMA.split(text) if item.strip()]
        case "pair":
            return [_number(item, field) for item in re.split(r"[,;\s]+", text)]
        case "table":
            return [[_number(item, field) for item in re.split(r"[,;\s]+", line.strip())] for line in _lines(text)]
        case _:
            return text


def changes(fields: Iterable[Field], shown: Iterable[Shown], stated: Mapping[str, Tree]) -> dict[YamlPath, Tree]:
    """Find what an answered form changes.

    Returns:
        Path from the part that the form is about to its new value; ``None`` takes it out.
    """
    answers = list(zip(fields, shown, strict=True))
    touched = dict.fromkeys(field.path[0] for field, value in answers if value != field.value)
    found: dict[YamlPath, Tree] = {}
    for key in touched:
        new = _compose([(field, parse(field, value)) for field, value in answers if field.path[0] == key])
        found.update(_differences(stated.get(str(key)), new, (key,)))
    return found


def field_at(fields: Iterable[Field], base: YamlPath, path: str) -> Field | None:
    """Find the input that a path of an error is about, such as ``"templates.around.speed_mm_s"``."""
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


def _lines(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.strip()]


def _compose(answers: list[tuple[Field, Tree]]) -> Tree:
    """Put the answers about one key together: a value, one by class, or a part of its own."""
    alone = [value for field, value in answers if len(field.path) == 1]
    rows = {field.path[1]: value for field, value in answers if len(field.path) == 2 and value is not None}
    if not alone:
        return rows or None
    if not rows:
        return alone[0]
    return rows if alone[0] is None else {**rows, DEFAULT: alone[0]}


def _differences(old: Tree, new: Tree, path: YamlPath) -> dict[YamlPath, Tree]:
    if isinstance(old, dict) and isinstance(new, dict):
        before, after = cast("dict[str, Tree]", old), cast("dict[str, Tree]", new)
        found: dict[YamlPath, Tree] = {(*path, key): None for key in before if key not in after}
        for key, value in after.items():
            found.update(_differences(before.get(key), value, (*path, key)))
        return found
    same = type(old) is type(new) or not (isinstance(old, bool) or isinstance(new, bool))
    return {} if same and old == new else {path: new}
