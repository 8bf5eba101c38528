"""A recipe on the terminal, as a process engineer reads it: one table for each element, every value resolved."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from recipes.classes import ComponentClass, Range
from recipes.load import LoadedRecipe
from recipes.nozzles import HollowCone, Nozzle
from recipes.paths import PathSpec
from recipes.recipe import Step, Until
from specs.spec import Spec
from specs.yaml.located import Located, Mark

_COMMON = ("path", "from_mm", "to_mm", "height_mm", "speed_mm_s", "tilt_deg", "toward")


def print_recipe(console: Console, loaded: LoadedRecipe) -> None:
    """Print the functions, nozzles, classes, masks, templates, limits and the sequence of a recipe."""
    recipe = loaded.recipe
    console.print(f"[bold]{escape(recipe.recipe)}[/bold]  {escape(recipe.description)}")
    files = _files(loaded.root)
    inherits = f", with values from {', '.join(Path(file).stem for file in files)}" if files else ""
    console.print(f"{escape(loaded.root.mark.file)}{escape(inherits)}", style="dim", soft_wrap=True, highlight=False)
    for table in (_functions(loaded), _nozzles(loaded), _classes(loaded), _masks(loaded), _templates(loaded)):
        if table.row_count:
            console.print()
            console.print(table)
    console.print()
    console.print(_sequence(loaded))
    limits = ", ".join(f"{field} {_number(value)}" for field, value in recipe.limits if value is not None)
    console.print(f"\n[bold]limits[/bold]  {escape(limits)}", highlight=False)


def _functions(loaded: LoadedRecipe) -> Table:
    table = _table("functions", "solution", ">°C", ">bar", ">max mm/s", "written in")
    for name, function in loaded.recipe.functions.items():
        heat = "" if function.temperature_c is None else _number(function.temperature_c)
        speed = _number(function.max_speed_mm_s)
        pressure, origin = _number(function.pressure_bar), _origin(loaded, "functions", name)
        _row(table, name, function.solution, heat, pressure, speed, origin)
    return table


def _nozzles(loaded: LoadedRecipe) -> Table:
    table = _table("nozzles", "pattern", "shape", ">L/min", ">at bar", ">tool", "written in")
    for name, nozzle in loaded.recipe.nozzles.items():
        flow, pressure = _number(nozzle.flow_lpm), _number(nozzle.at_bar)
        cells = (nozzle.pattern, _shape(nozzle), flow, pressure, str(nozzle.tool), _origin(loaded, "nozzles", name))
        _row(table, name, *cells)
    return table


def _shape(nozzle: Nozzle) -> str:
    width = f"{nozzle.width_mm:g} mm wide, " if nozzle.pattern == "air_knife" else ""
    shape = f"{width}half angle {nozzle.half_angle_deg:g}°"
    if isinstance(nozzle, HollowCone):
        ring = nozzle.wavefront
        shape += (
            ", ideal ring" if ring is None else f", ring of {len(ring.points)} points measured at {ring.height_mm:g} mm"
        )
    return shape


def _classes(loaded: LoadedRecipe) -> Table:
    table = _table("classes", "takes (the first that matches)", "written in")
    for name, component_class in loaded.recipe.classes.items():
        _row(table, name, ", ".join(_conditions(component_class)) or "what is left", _origin(loaded, "classes", name))
    return table


def _conditions(component_class: ComponentClass) -> Iterator[str]:
    for field, value in component_class:
        if isinstance(value, Range):
            lower = "" if value.min is None else f"{value.min:g} ≤ "
            upper = "" if value.max is None else f" ≤ {value.max:g}"
            yield f"{lower}{field}{upper}"
        elif value:
            yield f"{field} {' | '.join(value) if isinstance(value, list) else value}"


def _masks(loaded: LoadedRecipe) -> Table:
    table = _table("masks", "components", ">margin mm", "written in")
    for index, mask in enumerate(loaded.recipe.masks):
        kind = "avoid" if mask.avoid else "clean" if mask.clean else "ignore"
        margin = _number(mask.margin_mm) if mask.avoid else ""
        _row(table, kind, ", ".join(getattr(mask, kind)), margin, _origin(loaded, "masks", index))
    return table


def _templates(loaded: LoadedRecipe) -> Table:
    table = _table("templates", "path", ">height mm", ">mm/s", ">tilt", "more", "written in")
    for name, spec in loaded.recipe.templates.items():
        tilt = f"{_value(spec.tilt_deg)}° {spec.toward}" if spec.tilt_deg else "0°"
        height, speed = _value(spec.height_mm), _value(spec.speed_mm_s)
        _row(table, name, spec.path, height, speed, tilt, _more(spec), _origin(loaded, "templates", name))
    return table


def _more(spec: PathSpec) -> str:
    """Name what a template sets beside height, speed and tilt; what is left at its default is not worth the room."""
    stated = {field: value for field, value in spec if field not in _COMMON}
    line = f"{spec.from_mm} to {spec.to_mm}, " if spec.path == "straight_line" else ""
    defaults = {key: field.default for key, field in type(spec).model_fields.items()}
    return line + ", ".join(f"{key} {_value(value)}" for key, value in stated.items() if value != defaults[key])


def _sequence(loaded: LoadedRecipe) -> Table:
    table = _table("sequence", "function", "nozzle", "side", "paths", "how often")
    for index, step in enumerate(loaded.recipe.sequence):
        _row(table, str(index), step.function, step.nozzle, step.side, ", ".join(step.paths), _how_often(step))
    return table


def _how_often(step: Step) -> str:
    if not step.enabled:
        return "not enabled"
    return f"{step.repeat} x" if step.until is None else _until(step.until)


def _until(until: Until) -> str:
    goals = [f"{key} ≥ {value:g}" for key, value in until if key != "max_repeats" and value is not None]
    return f"until {goals[0]}, at most {until.max_repeats} x"


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    for index, column in enumerate(columns):
        right = column.startswith(">")
        style = "bold" if index == 0 else "dim" if column == "written in" else ""
        table.add_column(column.removeprefix(">"), justify="right" if right else "left", style=style, overflow="fold")
    return table


def _row(table: Table, *cells: str) -> None:
    table.add_row(*(escape(cell) for cell in cells))


def _value(value: Any) -> str:
    """Write one value or one for each class."""
    if isinstance(value, Spec):
        return " ".join(f"{key} {_value(inner)}" for key, inner in value if inner is not None)
    if isinstance(value, dict):
        return " ".join(f"{key}:{_number(number)}" for key, number in value.items())
    return ", ".join(value) if isinstance(value, list) else _number(value)


def _number(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


def _files(root: Located) -> list[str]:
    """Give the files that values were inherited from, in the order in which they first appear."""
    return [file for file in dict.fromkeys(mark.file for mark in _marks(root)) if file != root.mark.file]


def _origin(loaded: LoadedRecipe, *path: str | int) -> str:
    """Say which lines of which files a part was written on."""
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
