"""The numbers of a recipe that tuning turns: where each stands, its bounds, and which way cleans more."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, cast, get_args

from cleaning.verdicts.validity_rules import FARTHEST_MM, NEAREST_MM
from recipes.consistency import half_spread_deg
from recipes.paths import ComponentPerimeter, PathSpec, for_class
from recipes.recipe import Recipe, Step
from rulesengine.tuning.variables.recipe_edits import Edits
from specs.errors import JobError
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.schema import name_nearest

Kind: TypeAlias = Literal[
    "speeds", "tilts", "passes", "dwells", "heights", "sides", "wash_time", "pressure", "temperature"
]
KINDS: tuple[Kind, ...] = get_args(Kind)
_OF_CLASS = ("passes", "edge_delay_s", "delay_s", "speed_mm_s")
_SLOWEST_MM_S = 5.0
_MOST_LAPS = 24.0
_LONGEST_S = 10.0
_MOST_TILT_DEG = 50.0
_CLOSED_DEG = 84.0
"""Tilt and half angle together stay below, so that the cone closes on the board."""
_MOST_REPEATS = 20.0
_MOST_BAR = 6.0
_HOTTER_C = 10.0


@dataclass(frozen=True, slots=True)
class Knob:
    """One number of a recipe."""

    kind: Kind
    path: YamlPath
    """Where it is written."""
    value: float
    least: float
    most: float
    grain: float
    """It is a whole number of these."""
    gain: float
    """1 if more of it cleans more, -1 if less does."""
    steps: tuple[str, ...]
    """Where it acts, such as ``"sequence[0]"``."""
    template: str = ""
    of_class: str = ""
    """Empty: of all classes."""
    rest: float | None = None
    """What the other classes keep where it is the first of its template to be told by class."""

    def moved(self, value: float) -> float:
        """Round to the grain and keep within the bounds."""
        rounded = round(round(value / self.grain) * self.grain, 6)
        return min(max(rounded, self.least), self.most)

    def told(self, value: float) -> str:
        """Say what another value changes, such as ``"templates.sweep.speed_mm_s: 60 -> 40"``."""
        of_class = f" of {self.of_class}" if self.rest is not None else ""
        return f"{spell_path(self.path)}{of_class}: {self.value:g} -> {value:g}"

    def edit(self, value: float) -> Edits:
        """Write another value."""
        plain = int(value) if float(value).is_integer() else value
        if self.rest is None:
            return ((self.path, plain),)
        rest = int(self.rest) if self.rest.is_integer() else self.rest
        return ((self.path, {self.of_class: plain, "default": rest}),)


def read_kinds(words: str) -> frozenset[Kind]:
    """Read kinds of change, separated by commas.

    Raises:
        JobError: one is unknown, or there is none.
    """
    asked = [word.strip() for word in words.split(",") if word.strip()]
    for word in asked:
        if word not in KINDS:
            raise JobError(f"--allow {words}: {word!r} cannot be changed; {name_nearest(word, KINDS)}")
    if not asked:
        raise JobError(f"--allow allows nothing; name some of {', '.join(KINDS)}")
    return frozenset(kind for kind in KINDS if kind in asked)


def enabled_steps(recipe: Recipe) -> list[tuple[str, Step]]:
    """List the steps that are done, each with its path."""
    return [(f"sequence[{at}]", step) for at, step in enumerate(recipe.sequence) if step.enabled]


def knobs_of(recipe: Recipe, classes: frozenset[str], windows: Mapping[str, tuple[float, float]]) -> tuple[Knob, ...]:
    """List all that can be turned, template by template, then steps, then functions.

    Args:
        recipe: Whose numbers.
        classes: Those that have members on the board.
        windows: Temperatures that the liquid of a function bears, by function.
    """
    found: list[Knob] = []
    for name, spec in recipe.templates.items():
        steps = tuple(made_by for made_by, step in enabled_steps(recipe) if name in step.paths)
        if steps:
            found += _of_template(name, spec, recipe, steps, classes)
    for at, step in enumerate(recipe.sequence):
        if step.enabled and step.until is None:
            path: YamlPath = ("sequence", at, "repeat")
            found.append(Knob("wash_time", path, step.repeat, 1.0, _MOST_REPEATS, 1.0, 1.0, (f"sequence[{at}]",)))
    return (*found, *_of_functions(recipe, windows))


def _of_template(
    name: str, spec: PathSpec, recipe: Recipe, steps: tuple[str, ...], classes: frozenset[str]
) -> Iterator[Knob]:
    using = [step for made_by, step in enabled_steps(recipe) if made_by in steps]
    fastest = min(recipe.functions[step.function].max_speed_mm_s for step in using)
    spread = max(half_spread_deg(recipe.nozzles[step.nozzle]) for step in using)
    lowest = max(NEAREST_MM, recipe.limits.clearance_mm + 1.0)
    at: YamlPath = ("templates", name)
    least_tilt = min(spread + 1.0, _MOST_TILT_DEG) // 1.0 if _leans_in(spec) else 0.0
    fields: dict[str, Knob] = {
        "speed_mm_s": Knob("speeds", at, 0.0, _SLOWEST_MM_S, fastest, 1.0, -1.0, steps, name),
        "passes": Knob("passes", at, 0.0, 0.0, _MOST_LAPS, 1.0, 1.0, steps, name),
        "repeats": Knob("passes", at, 0.0, 1.0, _MOST_LAPS, 1.0, 1.0, steps, name),
        "edge_delay_s": Knob("dwells", at, 0.0, 0.0, _LONGEST_S, 0.1, 1.0, steps, name),
        "delay_s": Knob("dwells", at, 0.0, 0.0, _LONGEST_S, 0.1, 1.0, steps, name),
        "corner_delay_s": Knob("dwells", at, 0.0, 0.0, _LONGEST_S, 0.1, 1.0, steps, name),
        "tilt_deg": Knob(
            "tilts", at, 0.0, least_tilt, min(_MOST_TILT_DEG, _CLOSED_DEG - spread), 1.0, 1.0, steps, name
        ),
        "height_mm": Knob("heights", at, 0.0, lowest, FARTHEST_MM, 1.0, -1.0, steps, name),
    }
    for field, knob in fields.items():
        if field in type(spec).model_fields:
            yield from _of_field(spec, field, knob, classes)


def _leans_in(spec: PathSpec) -> bool:
    """Whether the near wave front is put on an edge: more upright than its half angle it lies behind the nozzle."""
    return isinstance(spec, ComponentPerimeter) and spec.align == "wavefront" and spec.toward == "component"


def _of_field(spec: PathSpec, field: str, knob: Knob, classes: frozenset[str]) -> Iterator[Knob]:
    value = cast("float | dict[str, float]", getattr(spec, field))
    path: YamlPath = (*knob.path, field)
    only = spec.only if isinstance(spec, ComponentPerimeter) else []
    served = sorted(classes if not only else classes & set(only))
    if isinstance(value, dict):
        for each in served:
            yield _at(knob, (*path, each), for_class(value, each), each)
        return
    yield _at(knob, path, value)
    if field in _OF_CLASS[:3] and len(served) > 1 and _takes_classes(spec, field):
        for each in served:
            yield replace(_at(knob, path, value, each), rest=float(value))


def _takes_classes(spec: PathSpec, field: str) -> bool:
    return isinstance(spec, ComponentPerimeter) or field == "delay_s"


def _at(knob: Knob, path: YamlPath, value: float, of_class: str = "") -> Knob:
    """Set a knob to what the recipe says; what lies beyond its bounds already may stay there."""
    least, most = min(knob.least, value), max(knob.most, value)
    if knob.kind == "speeds":
        most = knob.most
    return replace(knob, path=path, value=float(value), least=least, most=most, of_class=of_class)


def _of_functions(recipe: Recipe, windows: Mapping[str, tuple[float, float]]) -> Iterator[Knob]:
    for name, function in recipe.functions.items():
        steps = tuple(made_by for made_by, step in enabled_steps(recipe) if step.function == name)
        if not steps:
            continue
        bar = function.pressure_bar
        path: YamlPath = ("functions", name, "pressure_bar")
        yield Knob("pressure", path, bar, min(1.0, bar), max(_MOST_BAR, bar), 0.1, 1.0, steps)
        if function.temperature_c is not None and name in windows:
            low, high = windows[name]
            warm = function.temperature_c
            most = max(min(high, warm + _HOTTER_C), low)
            yield Knob("temperature", (*path[:2], "temperature_c"), warm, low, max(most, low), 1.0, 1.0, steps)
