"""What a recipe consists of, section by section, and what can be done to an entry as a whole."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import count
from typing import cast

from recipes import rewrite
from recipes.classes import ComponentClass, Mask
from recipes.errors import RecipeError
from recipes.recipe import Function, Limits, Recipe, Step
from specs.spec import Spec
from specs.yaml.located import Located, YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.page.session import Session

SECTIONS: tuple[str, ...] = ("Functions", "Nozzles", "Classes", "Masks", "Templates", "Sequence", "Limits", "General")
GENERAL = ("recipe", "description", "extends")
"""Keys of the recipe itself that are no section of their own."""
_NAMED = ("functions", "nozzles", "classes", "templates")
_ORDERED = ("classes", "masks", "sequence")


@dataclass(frozen=True, slots=True)
class Entry:
    """One thing of a section, such as a template."""

    path: YamlPath
    label: str

    @property
    def section(self) -> str:
        """Section it stands in, such as ``"Templates"``."""
        return str(self.path[0]).capitalize() if self.path else "General"

    @property
    def name(self) -> str:
        """Name under which others refer to it; empty if it has none."""
        return str(self.path[1]) if self.named else ""

    @property
    def named(self) -> bool:
        """Say whether it has a name."""
        return len(self.path) == 2 and self.path[0] in _NAMED

    @property
    def many(self) -> bool:
        """Say whether there may be more of its kind, so that it can be copied and removed."""
        return len(self.path) == 2

    @property
    def ordered(self) -> bool:
        """Say whether its place among its neighbours means something."""
        return bool(self.path) and self.path[0] in _ORDERED


def entries(recipe: Recipe, section: str) -> list[Entry]:
    """List what stands in a section, in the order of the recipe."""
    key = section.lower()
    match key:
        case "general":
            return [Entry((), "Recipe")]
        case "limits":
            return [Entry((key,), "Limits")]
        case "masks":
            return [Entry((key, place), f"{place + 1}  {_tell_mask(mask)}") for place, mask in enumerate(recipe.masks)]
        case "sequence":
            return [
                Entry((key, place), f"{place + 1}  {_tell_step(each)}") for place, each in enumerate(recipe.sequence)
            ]
        case _:
            return [Entry((key, name), name) for name in cast("dict[str, Spec]", getattr(recipe, key))]


def spec_at(recipe: Recipe, path: YamlPath) -> type[Spec]:
    """Give the specification that an entry follows."""
    match path:
        case ("limits",):
            return Limits
        case ("masks", _):
            return Mask
        case ("sequence", _):
            return Step
        case ("functions", _):
            return Function
        case ("classes", _):
            return ComponentClass
        case (str() as section, str() as name):
            return type(cast("dict[str, Spec]", getattr(recipe, section))[name])
        case _:
            return Recipe


def stated_at(root: Located, path: YamlPath) -> Mapping[str, Tree]:
    """Give what a resolved recipe states at a path; nothing where it states nothing."""
    node: Located | None = root
    for key in path:
        node = None if node is None else node.get(key)
    plain = None if node is None else node.plain()
    return cast("Mapping[str, Tree]", plain) if isinstance(plain, dict) else {}


def names_of(recipe: Recipe) -> dict[str, tuple[str, ...]]:
    """Give the names that exist, by section."""
    return {section: tuple(cast("dict[str, Spec]", getattr(recipe, section))) for section in _NAMED}


def users_of(recipe: Recipe, path: YamlPath) -> list[YamlPath]:
    """Find where a named entry is referred to."""
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
    return list(_uses_of_class(recipe, str(name)))


def removed(session: Session, entry: Entry) -> Session:
    """Take an entry out.

    Raises:
        RecipeError: something still needs it.
    """
    users = users_of(session.recipe, entry.path) if entry.named else []
    if users:
        places = ", ".join(dict.fromkeys(_tell_place(session.recipe, path) for path in users))
        raise RecipeError(f"{entry.name} is used by {places}; take it out there first", path=spell_path(entry.path))
    return session.remove(entry.path)


def renamed(session: Session, entry: Entry, name: str) -> Session:
    """Give an entry another name, there and wherever it is referred to.

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
    """Put a new entry into a section, last; a class before the one that takes what is left.

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
    """Put a copy of an entry after it, under a name of its own.

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


def entry_at(recipe: Recipe, made_by: str) -> YamlPath | None:
    """Find the entry that a stroke or a finding comes from: the template of a stroke, else what its path names."""
    step, _, rest = made_by.partition("/")
    template = rest.partition("/")[0]
    if template in recipe.templates:
        return "templates", template
    places = [each.path for section in SECTIONS[:-1] for each in entries(recipe, section)]
    spelt = {spell_path(path): path for path in places}
    near = [place for place in spelt if place == step or step.startswith((place + ".", place + "["))]
    return spelt[max(near, key=len)] if near else None


def _uses_of_class(recipe: Recipe, name: str) -> Iterator[YamlPath]:
    for template, spec in recipe.templates.items():
        for field in type(spec).model_fields:
            value = getattr(spec, field)
            if isinstance(value, dict) and name in value:
                yield ("templates", template, field, name)
        for index, only in enumerate(cast("list[str]", getattr(spec, "only", []))):
            if only == name:
                yield ("templates", template, "only", index)


def _tell_place(recipe: Recipe, path: YamlPath) -> str:
    if path[0] == "sequence":
        return f"step {int(path[1]) + 1} ({recipe.sequence[int(path[1])].function})"
    return spell_path(path[:3])


def _tell_mask(mask: Mask) -> str:
    kinds = {"avoid": mask.avoid, "clean": mask.clean, "ignore": mask.ignore}
    return next(f"{kind} {', '.join(patterns)}" for kind, patterns in kinds.items() if patterns)


def _tell_step(step: Step) -> str:
    off = "" if step.enabled else " (off)"
    return f"{step.function} with {step.nozzle}, {step.side}{off}"
