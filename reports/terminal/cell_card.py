"""A cell on the terminal: what a person compares with the real one. Millimetres and degrees."""

import math
from collections.abc import Iterable

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from robotcell.cell.load import LoadedCell
from robotcell.cell.spec import Output, Outputs
from robotcell.diagnosis.frame_table import Frame
from robotcell.robot.robot import Body, Box, Capsule, Joint


def print_cell(console: Console, loaded: LoadedCell, frames: Iterable[Frame]) -> None:
    """Print the joints, the frames, the tools, the fixtures and the channels of a cell."""
    spec, cell = loaded.spec, loaded.cell
    console.print(f"[bold]{escape(cell.name)}[/bold]  {escape(spec.description)}")
    console.print(f"{escape(loaded.root.mark.file)}", style="dim", soft_wrap=True, highlight=False)
    for table in (_joints(loaded), _frames(frames), _bodies(loaded), _channels(loaded)):
        if table.row_count:
            console.print()
            console.print(table)


def _joints(loaded: LoadedCell) -> Table:
    robot = loaded.cell.robot
    table = _table(robot.name, "", ">lowest", ">highest", ">home", ">speed/s", ">acceleration/s²")
    for joint, home in zip(robot.joints, loaded.spec.home_deg_mm, strict=True):
        unit = 1e-3 if joint.kind == "prismatic" else math.pi / 180
        limits = (joint.lowest, joint.highest, unit * home, joint.speed, joint.acceleration)
        _row(table, joint.name, _unit(joint), *(_number(value / unit) for value in limits))
    return table


def _frames(frames: Iterable[Frame]) -> Table:
    table = _table("frames, in the cell", ">x mm", ">y mm", ">z mm", "looks")
    for frame in frames:
        _row(table, frame.what, *(f"{value:.1f}" for value in frame.place_mm), frame.looks)
    return table


def _bodies(loaded: LoadedCell) -> Table:
    table = _table(f"what may collide; margin {loaded.spec.margin_mm:g} mm", "carried by", "shape")
    for tool in loaded.cell.tools:
        for body in tool.bodies:
            _row(table, body.name, f"tool {tool.number} {tool.name}", _shape(body))
    for body in loaded.cell.fixtures:
        _row(table, body.name, "the cell", _shape(body))
    return table


def _channels(loaded: LoadedCell) -> Table:
    spec = loaded.spec
    table = _table("commands", "set")
    for name, nozzle in spec.nozzles.items():
        lags = (
            f"opens in {nozzle.open_lag_s:g} s, closes in {nozzle.close_lag_s:g} s, pulses of {nozzle.min_pulse_s:g} s"
        )
        _row(table, f"SPRAY with {name}", f"{nozzle.valve}; {lags}{'; round' if nozzle.round else ''}")
    for name, outputs in spec.io.functions.items():
        _row(table, f"FUNCTION {name}", _values(outputs))
    for name, outputs in spec.io.solutions.items():
        _row(table, f"SOLUTION {name}", _values(outputs))
    for key, setting in spec.io.settings.items():
        output = spec.io.outputs[setting.output]
        value = f"{setting.scale:g} * {key} + {setting.offset:g}"
        _row(table, f"SET {key}", f"{setting.output} = {value}{_range(output) if output.kind == 'analog' else ''}")
    for name, outputs in (("open", spec.io.grip.open), ("close", spec.io.grip.close)):
        if outputs:
            _row(table, f"GRIP {name}", _values(outputs))
    for key, sensor in spec.io.sensors.items():
        value = f"{sensor.scale:g} * {sensor.input} + {sensor.offset:g}"
        _row(table, f"UNTIL {key}", f"{key} = {value}; {sensor.input} in {sensor.unit}, at most {sensor.full_scale:g}")
    return table


def _range(output: Output) -> str:
    return f" {output.unit}, at most {output.full_scale:g}"


def _values(outputs: Outputs) -> str:
    return ", ".join(f"{name} = {value:g}" for name, value in outputs.items())


def _shape(body: Body) -> str:
    match body.shape:
        case Box(size):
            return "box " + " x ".join(_number(1e3 * value) for value in size)
        case Capsule(radius, length):
            return f"rod {_number(1e3 * length)} long, radius {_number(1e3 * radius)}"
        case mesh:
            return f"{len(mesh.triangles)} triangles"


def _unit(joint: Joint) -> str:
    return "mm" if joint.kind == "prismatic" else "deg"


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"


def _table(*columns: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim", padding=(0, 2, 0, 0))
    for index, column in enumerate(columns):
        right = column.startswith(">")
        style = "bold" if index == 0 else ""
        table.add_column(column.removeprefix(">"), justify="right" if right else "left", style=style, overflow="fold")
    return table


def _row(table: Table, *cells: str) -> None:
    table.add_row(*(escape(cell) for cell in cells))
