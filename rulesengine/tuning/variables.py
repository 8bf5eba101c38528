"""Design variables of a recipe: the numbers that tuning changes, their bounds, and the direction that cleans more.

And edits of a recipe as values at paths, written into its text as its owner would, and the difference of two texts.
"""

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, TypeAlias, cast, get_args

from cleaning.verdicts.process_rules import FARTHEST_MM, NEAREST_MM
from recipes.consistency import half_spread_deg
from recipes.errors import RecipeError
from recipes.paths import ComponentPerimeter, PathSpec, for_class
from recipes.recipe import Recipe, Step
from recipes.rewrite import write_values
from specs.errors import JobError
from specs.yaml.located import Located, YamlPath, spell_path
from specs.yaml.schema import name_nearest
from specs.yaml.tree import Tree

Edits: TypeAlias = tuple[tuple[YamlPath, Tree], ...]
"""Values by the paths where they are to stand, in the order of writing."""
_PART = re.compile(r"(?:^|\.)([^.\[\]]+)|\[(\d+)\]")


def apply_edits(text: str, file: Path, edits: Edits) -> str:
    """Write values into a recipe one after the other; a list that is only inherited is copied into the text first.

    Raises:
        RecipeError: a value cannot be written there.
    """
    for path, value in edits:
        text = write_values(text, file, {path: value})
    return text


def read_kept(words: Sequence[str], root: Located) -> tuple[YamlPath, ...]:
    """Parse paths such as ``templates.around.speed_mm_s`` or ``sequence[0]``, all below which is to stay.

    Raises:
        RecipeError: it is no path, or there is nothing at it.
    """
    found: list[YamlPath] = []
    for word in words:
        path = read_path(word)
        node = root
        for at, key in enumerate(path):
            inner = node.get(key)
            if inner is None:
                why = "it is a single value"
                if isinstance(node.value, dict):
                    why = name_nearest(str(key), list(node.value))
                elif isinstance(node.value, list):
                    why = f"the list has {len(node.value)} items, counted from 0"
                raise RecipeError(f"nothing to keep there: {why}", path=spell_path(path[: at + 1]))
            node = inner
        found.append(path)
    return tuple(found)


def read_path(word: str) -> YamlPath:
    """Parse a path such as ``templates.around.speed_mm_s`` or ``sequence[0]``.

    Raises:
        RecipeError: it is no path.
    """
    parts = list(_PART.finditer(word))
    if not word or "".join(part.group(0) for part in parts) != word:
        raise RecipeError(f"{word!r} is no path; write it as in templates.around.speed_mm_s or sequence[0]")
    return tuple(int(part[2]) if part[2] else part[1] for part in parts)


def is_kept(path: YamlPath, kept: Sequence[YamlPath]) -> bool:
    """Whether writing at a path would change something that is kept."""
    return any(path[: len(each)] == each or each[: len(path)] == path for each in kept)


def recipe_diff(before: str, after: str, name_before: str, name_after: str) -> str:
    """Unified diff of two recipe texts; empty where nothing differs."""
    lines = difflib.unified_diff(
        before.splitlines(keepends=True), after.splitlines(keepends=True), name_before, name_after
    )
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)


ChangeKind: TypeAlias = Literal[
    "speeds", "tilts", "passes", "dwells", "heights", "sides", "wash_time", "pressure", "temperature"
]
CHANGE_KINDS: tuple[ChangeKind, ...] = get_args(ChangeKind)
_SPLIT_BY_CLASS = ("passes", "edge_delay_s", "delay_s")
"""Fields that are changed by component class even where the recipe states one number for all."""
_SLOWEST_MM_S = 5.0
_MOST_LAPS = 24.0
_LONGEST_S = 10.0
_MOST_TILT_DEG = 50.0
_CLOSED_DEG = 84.0
"""Tilt and half angle together stay below, so that the cone closes on the board."""
_MOST_REPEATS = 20.0
_MOST_LEAST_S = 1800.0
_MOST_BAR = 6.0
_HOTTER_C = 10.0


@dataclass(frozen=True, slots=True)
class DesignVariable:
    """One number of a recipe."""

    kind: ChangeKind
    path: YamlPath
    """Where it is written."""
    value: float
    lower: float
    upper: float
    resolution: float
    """It is a multiple of this."""
    direction: float
    """1 if more of it cleans more, -1 if less does."""
    steps: tuple[str, ...]
    """Where it acts, such as ``"sequence[0]"``."""
    template: str = ""
    component_class: str = ""
    """Empty: of all classes."""
    default: float | None = None
    """Value of the other classes, where it is the first of its template to be stated by class."""

    @property
    def by_repeats(self) -> bool:
        """Whether it is a least time, which repeats of a path make up."""
        return self.path[-1] == "least_time_s"

    def rounded(self, value: float) -> float:
        """Round to the resolution and keep within the bounds."""
        multiple = round(round(value / self.resolution) * self.resolution, 6)
        return min(max(multiple, self.lower), self.upper)

    def describe(self, value: float) -> str:
        """Describe the change to another value, such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
        of_class = f" of {self.component_class}" if self.default is not None else ""
        return f"{spell_path(self.path)}{of_class}: {self.value:g} -> {value:g}"

    def edit(self, value: float) -> Edits:
        """Edits that write another value."""
        plain = int(value) if float(value).is_integer() else value
        if self.default is None:
            return ((self.path, plain),)
        default = int(self.default) if self.default.is_integer() else self.default
        return ((self.path, {self.component_class: plain, "default": default}),)


def read_kinds(words: str) -> frozenset[ChangeKind]:
    """Parse kinds of change, separated by commas.

    Raises:
        JobError: one is unknown, or there is none.
    """
    names = [word.strip() for word in words.split(",") if word.strip()]
    for name in names:
        if name not in CHANGE_KINDS:
            raise JobError(f"--allow {words}: {name!r} cannot be changed; {name_nearest(name, CHANGE_KINDS)}")
    if not names:
        raise JobError(f"--allow allows nothing; name some of {', '.join(CHANGE_KINDS)}")
    return frozenset(kind for kind in CHANGE_KINDS if kind in names)


def enabled_steps(recipe: Recipe) -> list[tuple[str, Step]]:
    """Enabled steps, each with its path."""
    return [(f"sequence[{at}]", step) for at, step in enumerate(recipe.sequence) if step.enabled]


def design_variables(
    recipe: Recipe, classes: frozenset[str], windows: Mapping[str, tuple[float, float]]
) -> tuple[DesignVariable, ...]:
    """List all design variables, template by template, then steps, then functions.

    ``classes`` are those with members on the board, ``windows`` the permitted temperatures of liquids by function.
    """
    steps = enabled_steps(recipe)
    found: list[DesignVariable] = []
    for name, spec in recipe.templates.items():
        users = [(made_by, step) for made_by, step in steps if name in step.paths]
        if users:
            found += _template_variables(name, spec, recipe, users, classes)
    for at, step in enumerate(recipe.sequence):
        if not step.enabled or step.until is not None:
            continue
        path, acts = ("sequence", at), (f"sequence[{at}]",)
        if step.least_time_s is None:
            bounds = 1.0, _MOST_REPEATS, 1.0
            found.append(DesignVariable("wash_time", (*path, "repeat"), step.repeat, *bounds, 1.0, acts))
        else:
            least, bounds = step.least_time_s, (min(5.0, step.least_time_s), max(_MOST_LEAST_S, step.least_time_s), 5.0)
            found.append(DesignVariable("wash_time", (*path, "least_time_s"), least, *bounds, 1.0, acts))
    return (*found, *_function_variables(recipe, windows))


def _template_variables(
    name: str, spec: PathSpec, recipe: Recipe, users: list[tuple[str, Step]], classes: frozenset[str]
) -> Iterator[DesignVariable]:
    fastest = min(recipe.functions[step.function].max_speed_mm_s for _, step in users)
    spread = max(half_spread_deg(recipe.nozzles[step.nozzle]) for _, step in users)
    flattest = 0.0
    if isinstance(spec, ComponentPerimeter):
        classes = classes & set(spec.only) if spec.only else classes
        if spec.align == "wavefront" and spec.toward == "component":
            # More upright than the half angle, the near wave front would lie behind the nozzle.
            flattest = min(spread + 1.0, _MOST_TILT_DEG) // 1.0
    lowest = max(NEAREST_MM, recipe.limits.clearance_mm + 1.0)
    steepest = min(_MOST_TILT_DEG, _CLOSED_DEG - spread)
    fields: dict[str, tuple[ChangeKind, float, float, float, float]] = {  # kind, bounds, resolution, direction
        "speed_mm_s": ("speeds", _SLOWEST_MM_S, fastest, 1.0, -1.0),
        "passes": ("passes", 0.0, _MOST_LAPS, 1.0, 1.0),
        "repeats": ("passes", 1.0, _MOST_LAPS, 1.0, 1.0),
        "edge_delay_s": ("dwells", 0.0, _LONGEST_S, 0.1, 1.0),
        "delay_s": ("dwells", 0.0, _LONGEST_S, 0.1, 1.0),
        "corner_delay_s": ("dwells", 0.0, _LONGEST_S, 0.1, 1.0),
        "tilt_deg": ("tilts", flattest, steepest, 1.0, 1.0),
        "height_mm": ("heights", lowest, FARTHEST_MM, 1.0, -1.0),
    }
    steps = tuple(made_by for made_by, _ in users)
    for field, (kind, lower, upper, resolution, direction) in fields.items():
        if field in type(spec).model_fields:
            path: YamlPath = ("templates", name, field)
            base = DesignVariable(kind, path, 0.0, lower, upper, resolution, direction, steps, name)
            yield from _field_variables(spec, field, base, classes)


def _field_variables(
    spec: PathSpec, field: str, base: DesignVariable, classes: frozenset[str]
) -> Iterator[DesignVariable]:
    value = cast('float | dict[str, float] | Literal["auto"]', getattr(spec, field))
    if value == "auto":  # of a template that no step of this board follows
        return
    if isinstance(value, dict):
        for each in sorted(classes):
            yield _at_value(replace(base, path=(*base.path, each), component_class=each), for_class(value, each))
        return
    yield _at_value(base, value)
    takes_classes = isinstance(spec, ComponentPerimeter) or field == "delay_s"
    if field in _SPLIT_BY_CLASS and takes_classes and len(classes) > 1:
        for each in sorted(classes):
            yield replace(_at_value(base, value), component_class=each, default=float(value))


def _at_value(base: DesignVariable, value: float) -> DesignVariable:
    """Set the present value; one that is beyond its bounds already may stay there."""
    upper = base.upper if base.kind == "speeds" else max(base.upper, value)
    return replace(base, value=float(value), lower=min(base.lower, value), upper=upper)


def _function_variables(recipe: Recipe, windows: Mapping[str, tuple[float, float]]) -> Iterator[DesignVariable]:
    for name, function in recipe.functions.items():
        steps = tuple(made_by for made_by, step in enabled_steps(recipe) if step.function == name)
        if not steps:
            continue
        bar, path = function.pressure_bar, ("functions", name)
        most = max(_MOST_BAR, bar)
        yield DesignVariable("pressure", (*path, "pressure_bar"), bar, min(1.0, bar), most, 0.1, 1.0, steps)
        if function.temperature_c is not None and name in windows:
            low, high = windows[name]
            warm = function.temperature_c
            most = max(min(high, warm + _HOTTER_C), low)
            yield DesignVariable("temperature", (*path, "temperature_c"), warm, low, most, 1.0, 1.0, steps)
