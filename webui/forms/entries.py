"""Entries of a recipe, section by section: listed, added, copied, renamed, moved, removed, and their first values."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import count
from typing import Any, cast

from boards.board import Workpiece
from recipes import rewrite
from recipes.errors import RecipeError
from recipes.load import read_recipe, recipe_library
from recipes.nozzles import NOZZLE_PATTERNS
from recipes.paths import PATH_CLASSES
from recipes.recipe import Recipe
from specs.source import Source
from specs.spec import Spec
from specs.yaml.located import Located, YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.page.session import Session

SECTIONS: tuple[str, ...] = ("Functions", "Nozzles", "Classes", "Masks", "Templates", "Sequence", "Limits", "General")
GENERAL = ("recipe", "description", "extends")
"""Keys of the recipe itself that are no section of their own."""
_NAMED = ("functions", "nozzles", "classes", "templates")
_ORDERED = ("classes", "masks", "sequence")
_KIND: dict[str, tuple[str, tuple[type[Spec], ...]]] = {
    "templates": ("path", PATH_CLASSES),
    "nozzles": ("pattern", NOZZLE_PATTERNS),
}
"""Sections whose entries have kinds: the key of the kind, and the specifications."""
_FIRST_VALUES: dict[str, Tree] = {"height_mm": 50, "speed_mm_s": 40}
_FIRST_NUMBER = 10
"""Values of the keys that an entry needs and that the library has for no entry of its kind."""
_NOT_IN_LIBRARY: dict[str, dict[str, Tree]] = {
    "full_cone": {"pattern": "full_cone", "half_angle_deg": 30, "flow_lpm": 2, "at_bar": 3},
    "flat_fan": {"pattern": "flat_fan", "half_angle_deg": 40, "flow_lpm": 2, "at_bar": 3},
    "radial": {"pattern": "radial", "radius_mm": 40, "at_mm": 100, "profile": "parabola", "flow_lpm": 2, "at_bar": 3},
}
"""First values of nozzles that no recipe of the library has."""


@dataclass(frozen=True, slots=True)
class Entry:
    """An entry of a section, such as a template."""

    path: YamlPath
    label: str

    @property
    def section(self) -> str:
        """Its section, such as ``"Templates"``."""
        return str(self.path[0]).capitalize() if self.path else "General"

    @property
    def name(self) -> str:
        """Name by which other entries refer to it; empty if it has none."""
        return str(self.path[1]) if self.named else ""

    @property
    def named(self) -> bool:
        """Whether it has a name."""
        return len(self.path) == 2 and self.path[0] in _NAMED

    @property
    def many(self) -> bool:
        """Whether there may be more of its kind, so that it can be copied and removed."""
        return len(self.path) == 2

    @property
    def ordered(self) -> bool:
        """Whether its place among its neighbours matters."""
        return bool(self.path) and self.path[0] in _ORDERED


def entries(recipe: Recipe, section: str) -> list[Entry]:
    """Entries of a section, in the order of the recipe."""
    key = section.lower()
    match key:
        case "general":
            return [Entry((), "Recipe")]
        case "limits":
            return [Entry((key,), "Limits")]
        case "masks":
            kinds = [{"avoid": mask.avoid, "clean": mask.clean, "ignore": mask.ignore} for mask in recipe.masks]
            labels = [next(f"{kind} {', '.join(each)}" for kind, each in mask.items() if each) for mask in kinds]
            return [Entry((key, place), f"{place + 1}  {label}") for place, label in enumerate(labels)]
        case "sequence":
            labels = [
                f"{step.function} with {step.nozzle}, {step.side}{'' if step.enabled else ' (off)'}"
                for step in recipe.sequence
            ]
            return [Entry((key, place), f"{place + 1}  {label}") for place, label in enumerate(labels)]
        case _:
            return [Entry((key, name), name) for name in cast("dict[str, Spec]", getattr(recipe, key))]


def spec_at(recipe: Recipe, path: YamlPath) -> type[Spec]:
    """Specification of an entry."""
    node: Any = recipe
    for key in path:
        node = getattr(node, str(key)) if isinstance(node, Spec) else node[key]
    return type(node)


def stated_at(root: Located, path: YamlPath) -> Mapping[str, Tree]:
    """Values that a resolved recipe states at a path."""
    node = root.find(path)
    plain = None if node is None else node.plain()
    return cast("Mapping[str, Tree]", plain) if isinstance(plain, dict) else {}


def names_of(recipe: Recipe) -> dict[str, tuple[str, ...]]:
    """Names that exist, by section."""
    return {section: tuple(cast("dict[str, Spec]", getattr(recipe, section))) for section in _NAMED}


def users_of(recipe: Recipe, path: YamlPath) -> list[YamlPath]:
    """Places that refer to a named entry."""
    section, name = path
    kept = {"functions": "function", "nozzles": "nozzle"}.get(str(section))
    if kept is not None:
        return [("sequence", place, kept) for place, step in enumerate(recipe.sequence) if getattr(step, kept) == name]
    if section == "templates":
        return [
            ("sequence", place, "paths", index)
            for place, step in enumerate(recipe.sequence)
            for index, used in enumerate(step.paths)
            if used == name
        ]
    found: list[YamlPath] = []
    for template, spec in recipe.templates.items():
        values = ((field, getattr(spec, field)) for field in type(spec).model_fields)
        found += [
            ("templates", template, key, name) for key, value in values if isinstance(value, dict) and name in value
        ]
        only = cast("list[str]", getattr(spec, "only", []))
        found += [("templates", template, "only", index) for index, each in enumerate(only) if each == name]
    return found


def removed(session: Session, entry: Entry) -> Session:
    """Session without an entry.

    Raises:
        RecipeError: another entry refers to it.
    """
    users = users_of(session.recipe, entry.path) if entry.named else []
    if users:
        steps = session.recipe.sequence
        named = [
            f"step {int(path[1]) + 1} ({steps[int(path[1])].function})"
            if path[0] == "sequence"
            else spell_path(path[:3])
            for path in users
        ]
        places = ", ".join(dict.fromkeys(named))
        raise RecipeError(f"{entry.name} is used by {places}; take it out there first", path=spell_path(entry.path))
    return session.remove(entry.path)


def renamed(session: Session, entry: Entry, name: str) -> Session:
    """Session with another name for an entry, there and wherever it is referred to.

    Raises:
        RecipeError: it is inherited, or the name is taken or cannot be one.
    """
    if name == entry.name:
        return session
    recipe, file = session.recipe, session.document.file
    if name in names_of(recipe)[str(entry.path[0])]:
        raise RecipeError(f"{name!r} is there already; choose another name", path=spell_path(entry.path[:1]))
    text = rewrite.rename(session.document.text, file, entry.path, name)
    for path in users_of(recipe, entry.path):
        if path[0] == "templates" and path[-1] == entry.name:
            text = rewrite.rename(text, file, path, name)
        else:
            text = rewrite.write_values(text, file, {path: name})
    return session.edited(text)


def moved(session: Session, entry: Entry, by: int) -> tuple[Session, YamlPath]:
    """Move an entry up (-1) or down (+1) among its neighbours, as far as there are any.

    Raises:
        RecipeError: the text cannot be changed there.
    """
    paths = [each.path for each in entries(session.recipe, entry.section)]
    place = paths.index(entry.path)
    to = min(max(place + by, 0), len(paths) - 1)
    if to == place:
        return session, entry.path
    path: YamlPath = entry.path if entry.named else (entry.path[0], to)
    return session.move(entry.path, to), path


def added(session: Session, section: str, name: str, value: Tree) -> tuple[Session, YamlPath]:
    """Session with a new entry, last in its section; a class before the one that takes all others.

    Raises:
        RecipeError: the name is taken or cannot be one, or the entry is refused.
    """
    key = section.lower()
    there = entries(session.recipe, section)
    if key not in _NAMED:
        path: YamlPath = (key, len(there))
        return session.insert(path, value), path
    path = (key, name)
    if path in [each.path for each in there]:
        raise RecipeError(f"{name!r} is there already; choose another name")
    if not name:
        raise RecipeError("It needs a name that begins with a letter.")
    if key != "classes":
        return session.set_value(path, value), path
    file = session.document.file
    text = rewrite.write_values(session.document.text, file, {path: value})
    return session.edited(rewrite.move(text, file, path, max(len(there) - 1, 0))), path


def copied(session: Session, entry: Entry) -> tuple[Session, YamlPath]:
    """Session with a copy of an entry after it, under a new name.

    Raises:
        RecipeError: the text cannot be changed there.
    """
    value = dict(stated_at(session.loaded.root, entry.path))
    there = [each.path for each in entries(session.recipe, entry.section)]
    if not entry.named:
        path: YamlPath = (entry.path[0], int(entry.path[1]) + 1)
        return session.insert(path, value), path
    stem = re.sub(r"-\d+$", "", entry.name)
    path = next(found for number in count(2) if (found := (entry.path[0], f"{stem}-{number}")) not in there)
    text, file = session.document.text, session.document.file
    text = rewrite.write_values(text, file, {path: value})
    if entry.ordered:
        text = rewrite.move(text, file, path, there.index(entry.path) + 1)
    return session.edited(text), path


def entry_at(recipe: Recipe, made_by: Source) -> YamlPath | None:
    """Entry that caused a stroke or a finding: the template of a stroke, else what its path names."""
    places = {each.path for section in SECTIONS[:-1] for each in entries(recipe, section)}
    path = made_by.recipe_path
    return next((path[:end] for end in range(len(path), 0, -1) if path[:end] in places), None)


def kinds_of(section: str) -> tuple[str, ...]:
    """Kinds of entries that a section can have, such as the path classes of templates; most have one."""
    if section in _KIND:
        key, specs = _KIND[section]
        return tuple(str(each.model_fields[key].default) for each in specs)
    return ("avoid", "clean", "ignore") if section == "masks" else ()


def default_entry(recipe: Recipe, workpiece: Workpiece, section: str, kind: str, name: str) -> Tree:
    """First values of a new entry, taken from the library where it has such an entry.

    Args:
        recipe: The recipe of the new entry.
        workpiece: A straight line runs across the middle of it; a mask names its first component.
        section: Key of the section, such as ``"templates"``.
        kind: One of ``kinds_of`` the section.
        name: Of the new entry; a class takes packages of that name.
    """
    match section:
        case "templates" | "nozzles":
            tag, specs = _KIND[section]
            fields = next(each.model_fields for each in specs if each.model_fields[tag].default == kind)
            needed = [field.alias or name for name, field in fields.items() if field.is_required()]
            value = _library_entries(section).get(kind) or _NOT_IN_LIBRARY.get(kind) or {tag: kind}
            value = value | {key: value.get(key, first) for key, first in _FIRST_VALUES.items() if key in needed}
            (left, front, _), (right, back, _) = (corner.tolist() for corner in workpiece.box)
            middle = round((front + back) / 2, 2)
            ends: dict[str, Tree] = {"from": [round(left, 2), middle], "to": [round(right, 2), middle]}
            return value | {key: ends.get(key) or value.get(key, _FIRST_NUMBER) for key in needed}
        case "functions":
            return dict(_library_entries(section)["clean"])
        case "classes":
            return {"package": [f"*{name.upper()}*"]}
        case "masks":
            return {kind: [next(iter(workpiece.place_names), "J*")]}
        case _:
            function, nozzle, template = (
                next(iter(names_of(recipe)[key])) for key in ("functions", "nozzles", "templates")
            )
            return {"function": function, "nozzle": nozzle, "paths": [template]}


@cache
def _library_entries(section: str) -> dict[str, dict[str, Tree]]:
    """First entry of each kind in the library; by name where a section has one kind.

    Classes differ from recipe to recipe: a value by class becomes the one for all others.
    """
    found: dict[str, dict[str, Tree]] = {}
    names = sorted(recipe_library(), key=lambda name: (name != "smt-aqueous", name))
    for name in names:
        for entry, values in cast("dict[str, dict[str, Tree]]", read_recipe(name).root.plain()[section]).items():
            plain: dict[str, Tree] = {
                key: cast("dict[str, Tree]", value).get("default", value) if isinstance(value, dict) else value
                for key, value in values.items()
                if key != "wavefront"  # measured with one nozzle, and true for no other
            }
            found.setdefault(str(plain[_KIND[section][0]]) if section in _KIND else entry, plain)
    return found
