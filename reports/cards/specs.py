"""A recipe, a parameter set, a solution or a flux: every value resolved, with the place where it was written."""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any, cast

from cleaning.parameters.chemistries import Chemistry, Flux
from cleaning.parameters.load import LoadedParameters, parameters_sha256
from cleaning.parameters.provenance import value_paths
from recipes.classes import ComponentClass, Range
from recipes.load import LoadedRecipe
from recipes.nozzles import HollowCone, Nozzle, Radial
from recipes.paths import OverFaces, PathSpec
from recipes.recipe import Function, Step
from reports.tables.table import Block, Card, Column, Table, Text, source_lines
from specs.spec import Spec
from specs.yaml.located import Located, Mark, spell_path

_TEXTS = ("parameters", "description", "extends", "provenance", "parts")
_COMMON = ("path", "from_mm", "to_mm", "height_mm", "standoff_mm", "speed_mm_s", "tilt_deg", "tilt_max_deg", "toward")


def recipe_card(loaded: LoadedRecipe) -> Card:
    """Show the functions, nozzles, classes, masks, templates, limits and the sequence of a recipe."""
    recipe, root = loaded.recipe, loaded.root
    files = [file for file in dict.fromkeys(mark.file for mark in _marks(root)) if file != root.mark.file]
    inherits = f", with values from {', '.join(Path(file).stem for file in files)}" if files else ""
    title, source = source_lines(recipe.recipe, recipe.description, f"{root.mark.file}{inherits}")
    blocks: list[Block] = [source]
    for (name, *headings), rows in _elements(loaded).items():
        if rows:
            last = [Column("written in", emphasis="quiet")] if name != "sequence" else []
            blocks += ["", Table.of((Column(name, emphasis="strong"), *headings, *last), rows)]
    limits = ", ".join(f"{field} {_number(value)}" for field, value in recipe.limits if value is not None)
    return Card(title, (*blocks, "", (Text("limits", "strong"), f"  {limits}")))


def _elements(loaded: LoadedRecipe) -> dict[tuple[str, ...], list[tuple[str, ...]]]:
    """Rows of each element of a recipe by their headings."""
    recipe = loaded.recipe

    def rows(kind: str, cells: Callable[[Any], Iterable[str]]) -> list[tuple[str, ...]]:
        return [(name, *cells(each), _origin(loaded, kind, name)) for name, each in getattr(recipe, kind).items()]

    def function(each: Function) -> tuple[str, ...]:
        warmth = "" if each.temperature_c is None else _number(each.temperature_c)
        return each.solution, warmth, _number(each.pressure_bar), _number(each.max_speed_mm_s)

    def nozzle(each: Nozzle) -> tuple[str, ...]:
        return each.pattern, _shape(each), _number(each.flow_lpm), _number(each.at_bar), str(each.tool)

    masks: list[tuple[str, ...]] = []
    for index, mask in enumerate(recipe.masks):
        kind = "avoid" if mask.avoid else "clean" if mask.clean else "ignore"
        margin = _number(mask.margin_mm) if mask.avoid else ""
        masks.append((kind, ", ".join(getattr(mask, kind)), margin, _origin(loaded, "masks", index)))
    sequence = [
        (str(index), step.function, step.nozzle, step.side, ", ".join(step.paths), _how_often(step))
        for index, step in enumerate(recipe.sequence)
    ]
    return {
        ("functions", "solution", ">°C", ">bar", ">max mm/s"): rows("functions", function),
        ("nozzles", "pattern", "shape", ">L/min", ">at bar", ">tool"): rows("nozzles", nozzle),
        ("classes", "takes (the first that matches)"): rows(
            "classes", lambda each: (", ".join(_conditions(each)) or "what is left",)
        ),
        ("masks", "components", ">margin mm"): masks,
        ("templates", "path", ">height mm", ">mm/s", ">tilt", "more"): rows(
            "templates", lambda each: (each.path, *_motion(each), _others(each))
        ),
        ("sequence", "function", "nozzle", "side", "paths", "how often"): sequence,
    }


def _shape(nozzle: Nozzle) -> str:
    if isinstance(nozzle, Radial):
        profile = nozzle.profile if nozzle.profile == "parabola" else f"profile of {len(nozzle.profile)} points"
        return f"{profile}, radius {nozzle.radius_mm:g} mm at {nozzle.at_mm:g} mm"
    width = f"{nozzle.width_mm:g} mm wide, " if nozzle.pattern == "air_knife" else ""
    shape = f"{width}half angle {nozzle.half_angle_deg:g}°"
    if isinstance(nozzle, HollowCone):
        ring = nozzle.wavefront
        shape += (
            ", ideal ring" if ring is None else f", ring of {len(ring.points)} points measured at {ring.height_mm:g} mm"
        )
    return shape


def _conditions(component_class: ComponentClass) -> Iterator[str]:
    for field, value in component_class:
        if isinstance(value, Range):
            lower = "" if value.min is None else f"{value.min:g} ≤ "
            upper = "" if value.max is None else f" ≤ {value.max:g}"
            yield f"{lower}{field}{upper}"
        elif value:
            yield f"{field} {' | '.join(value) if isinstance(value, list) else value}"


def _motion(spec: PathSpec) -> tuple[str, str, str]:
    """Height, speed and tilt of a template; over surfaces the standoff, a speed by the cone, and the largest tilt."""
    if isinstance(spec, OverFaces):
        return _value(spec.standoff_mm), "auto", f"0° to {spec.tilt_max_deg:g}°"
    tilt = f"{_value(spec.tilt_deg)}° {spec.toward}" if spec.tilt_deg else "0°"
    return _value(spec.height_mm), _value(spec.speed_mm_s), tilt


def _others(spec: PathSpec) -> str:
    """Values of a template beside height, speed and tilt that are not their defaults."""
    stated = {field: value for field, value in spec if field not in _COMMON}
    line = f"{spec.from_mm} to {spec.to_mm}, " if spec.path == "straight_line" else ""
    defaults = {key: field.default for key, field in type(spec).model_fields.items()}
    return line + ", ".join(f"{key} {_value(value)}" for key, value in stated.items() if value != defaults[key])


def _how_often(step: Step) -> str:
    if not step.enabled:
        return "not enabled"
    if step.until is None:
        return f"{step.repeat} x"
    goals = [f"{key} ≥ {value:g}" for key, value in step.until if key != "max_repeats" and value is not None]
    return f"until {goals[0]}, at most {step.until.max_repeats} x"


def _value(value: Any) -> str:
    """One value, or one for each class."""
    if isinstance(value, Spec):
        return " ".join(f"{key} {_value(inner)}" for key, inner in value if inner is not None)
    if isinstance(value, dict):
        return " ".join(f"{key}:{_number(number)}" for key, number in value.items())
    return ", ".join(value) if isinstance(value, list) else _number(value)


def _number(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _origin(loaded: LoadedRecipe, *path: str | int) -> str:
    """Lines of the files on which a part was written."""
    node = loaded.root.at(path)
    lines: dict[str, int] = {}
    for mark in _marks(node):
        lines[mark.file] = min(mark.line, lines.get(mark.file, mark.line))
    here = loaded.root.mark.file
    return ", ".join(f"line {line}" if file == here else f"{Path(file).stem}:{line}" for file, line in lines.items())


def _marks(node: Located) -> Iterator[Mark]:
    if isinstance(node.value, dict):
        yield from (mark for inner in node.value.values() for mark in _marks(inner))
    elif isinstance(node.value, list):
        yield from (mark for inner in node.value for mark in _marks(inner))
    if not isinstance(node.value, dict) or not node.value:
        yield node.mark


def parameters_card(loaded: LoadedParameters) -> Card:
    """Show the values of a set, block by block, each with its provenance, and what that means for verdicts."""
    parameters = loaded.parameters
    extends = f", extends {parameters.extends}" if parameters.extends else ""
    title, *blocks = source_lines(parameters.parameters, parameters.description, f"{loaded.root.mark.file}{extends}")
    for name, block in parameters.model_dump(mode="json", exclude=set(_TEXTS)).items():
        blocks += ["", _block(name, block, loaded)]
    for index, part in enumerate(parameters.parts):
        values = ", ".join(f"{key} {_range_text(value)}" for key, value in part if key != "match" and value is not None)
        blocks += ["", (Text(f"parts[{index}]", "strong"), f"  {', '.join(part.match)}: {values}")]
    kinetics = "calibrated: verdicts on residue have grade B"
    if not parameters.calibrated:
        grade = "verdicts on residue have grade C, good for ranking only"
        kinetics = f"UNCALIBRATED: {grade}; see `washboard calibrate gap`"
    sha256 = f"    {parameters_sha256(parameters)[:16]}"
    last = ((Text("kinetics", "strong"), f"  {kinetics}"), (Text("sha256", "strong"), sha256))
    return Card(title, (*blocks, "", *last))


def chemistry_card(name: str, chemistry: Chemistry | Flux) -> Card:
    """Show a solution or a flux of the library: its values, each with its provenance."""
    noun, stated = ("solution", chemistry.liquid) if isinstance(chemistry, Chemistry) else ("flux", chemistry)
    title, source = source_lines(name, chemistry.description, f"a {noun} of the library")
    values = stated.model_dump(mode="json", exclude_unset=True, exclude={"description", "provenance"})
    known = [(key, value, chemistry.known(key)) for key, value in values.items()]
    rows = [(key, _list_text(value), entry.known, entry.source) for key, value, entry in known]
    return Card(title, (source, Table.of((Column(noun, emphasis="strong"), ">", "known", "from"), rows)))


def _list_text(value: Any) -> str:
    words = isinstance(value, list) and all(isinstance(each, str) for each in cast("list[Any]", value))
    return ", ".join(cast("list[str]", value)) if words else _range_text(value)


def _block(name: str, block: dict[str, Any], loaded: LoadedParameters) -> Table:
    here = loaded.root.mark.file
    rows: list[tuple[str, ...]] = []
    for path in value_paths(block):
        value: Any = block
        for key in path:
            value = value[key]
        if value is None:
            continue
        entry = loaded.parameters.known(spell_path((name, *path)))
        interval = "" if entry.interval is None else f" ({entry.interval[0]:g} to {entry.interval[1]:g})"
        mark = loaded.root.at((name, *path)).mark
        written = f"line {mark.line}" if mark.file == here else f"{Path(mark.file).stem}:{mark.line}"
        rows.append((spell_path(path), _list_text(value) + interval, entry.known, entry.source, written))
    columns = (Column(name, emphasis="strong"), ">", "known", "from", Column("written in", emphasis="quiet"))
    return Table.of(columns, rows)


def _range_text(value: Any) -> str:
    return " to ".join(map(_range_text, value)) if isinstance(value, list | tuple) else _number(value)
