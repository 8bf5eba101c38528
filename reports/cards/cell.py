"""A cell: what a person compares with the real one. Millimetres and degrees."""

import math
from collections.abc import Iterable

import numpy as np

from programs.motion.installation import MAKER_NAMES
from reports.tables.table import Card, Column, Table, source_lines
from robotcell.cell.hold import FiducialFit, fit_fiducials
from robotcell.cell.load import LoadedCell
from robotcell.cell.spec import Outputs
from robotcell.diagnosis.plausibility import Frame
from robotcell.robot.robot import Body, Box, Capsule


def cell_card(loaded: LoadedCell, frames: Iterable[Frame]) -> Card:
    """Show the joints, frames, tools, fixtures and channels of a cell, and how well measured points fit."""
    spec, cell = loaded.spec, loaded.cell
    fit = fit_fiducials(spec.board) if spec.board.points is not None else None
    title, *blocks = source_lines(cell.name, spec.description, loaded.root.mark.file)
    bodies = [
        (body.name, f"tool {tool.number} {tool.name}", _shape(body)) for tool in cell.tools for body in tool.bodies
    ] + [(body.name, "the cell", _shape(body)) for body in cell.fixtures]
    tables = [
        _joints(loaded),
        Table.of(
            (_name("frames, in the cell"), ">x mm", ">y mm", ">z mm", "looks"),
            [(each.what, *(f"{value:.1f}" for value in each.place_mm), each.looks) for each in frames],
        ),
        *(() if fit is None else (_residuals(fit),)),
        Table.of((_name(f"what may collide; margin {spec.margin_mm:g} mm"), "carried by", "shape"), bodies),
        Table.of((_name("commands"), "set"), _channels(loaded)),
    ]
    blocks += [block for table in tables if table.rows for block in ("", table)]
    return Card(title, (*blocks, *(() if fit is None else (_accuracy(fit, spec.board.noise_mm),))))


def _name(heading: str) -> Column:
    """First column of a table, whose heading names what it lists."""
    return Column(heading, emphasis="strong")


def _joints(loaded: LoadedCell) -> Table:
    robot, home_deg_mm = loaded.cell.robot, tuple(loaded.spec.home_deg_mm)
    counted = () if robot.convention is None else robot.convention.count(home_deg_mm)
    rows: list[tuple[str, ...]] = []
    for at, (joint, home) in enumerate(zip(robot.joints, home_deg_mm, strict=True)):
        unit, word = (1e-3, "mm") if joint.kind == "prismatic" else (math.pi / 180, "deg")
        limits = (joint.lowest, joint.highest, unit * home, joint.speed, joint.acceleration)
        shown = [_number(value) for value in counted[at : at + 1]]
        rows.append((joint.name, word, *(_number(value / unit) for value in limits), *shown))
    maker = "no maker" if robot.maker is None else MAKER_NAMES[robot.maker]
    headings = ("", ">lowest", ">highest", ">home", ">speed/s", ">acceleration/s²")
    return Table.of((_name(f"{robot.name}, {maker}"), *headings, *[">home on its controller"] * bool(counted)), rows)


def _residuals(fit: FiducialFit) -> Table:
    """How far each measured point lies from where the fit puts it."""
    found = zip(fit.residuals_mm.tolist(), fit.distances_mm.tolist(), strict=True)
    rows = [(f"{at}", *(f"{value:.3f}" for value in (*off, distance))) for at, (off, distance) in enumerate(found)]
    return Table.of((_name("measured point"), ">off x mm", ">off y mm", ">off z mm", ">off mm"), rows)


def _accuracy(fit: FiducialFit, noise_mm: float) -> str:
    """Standard deviations of the place and the turn for the stated noise, the noise by the residuals, the stretch."""
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    turn, place = (np.linalg.norm(deviations[part]) for part in (slice(0, 3), slice(3, 6)))
    found = "" if fit.redundancy < 1 else f"; {fit.noise_mm:.3f} mm by the residuals"
    stretch = ""
    if fit.kind != "rigid":
        (x, shear), (_, y) = fit.stretch.tolist()
        stretch = (
            f"; stretched by {1e6 * (x - 1):.0f} and {1e6 * (y - 1):.0f} ppm along x and y, {1e6 * shear:.0f} ppm shear"
        )
    return (
        f"{fit.kind} fit with {noise_mm:g} mm a coordinate{found}: place ± {place:.3f} mm at the points' middle, "
        f"turn ± {math.degrees(float(turn)):.4f} deg{stretch}"
    )


def _channels(loaded: LoadedCell) -> list[tuple[str, str]]:
    """Commands of a program, and the outputs that each sets."""
    io = loaded.spec.io
    rows: list[tuple[str, str]] = []
    for name, nozzle in loaded.spec.nozzles.items():
        lags = (
            f"opens in {nozzle.open_lag_s:g} s, closes in {nozzle.close_lag_s:g} s, pulses of {nozzle.min_pulse_s:g} s"
        )
        rows.append((f"SPRAY with {name}", f"{nozzle.valve}; {lags}{'; round' if nozzle.round else ''}"))
    rows += [(f"FUNCTION {name}", _values(outputs)) for name, outputs in io.functions.items()]
    rows += [(f"SOLUTION {name}", _values(outputs)) for name, outputs in io.solutions.items()]
    for key, setting in io.settings.items():
        output = io.outputs[setting.output]
        most = f" {output.unit}, at most {output.full_scale:g}" if output.kind == "analog" else ""
        rows.append((f"SET {key}", f"{setting.output} = {setting.scale:g} * {key} + {setting.offset:g}{most}"))
    grips = (("open", io.grip.open), ("close", io.grip.close))
    rows += [(f"GRIP {name}", _values(outputs)) for name, outputs in grips if outputs]
    for key, sensor in io.sensors.items():
        value = f"{sensor.scale:g} * {sensor.input} + {sensor.offset:g}"
        most = f"{sensor.input} in {sensor.unit}, at most {sensor.full_scale:g}"
        rows.append((f"UNTIL {key}", f"{key} = {value}; {most}"))
    return rows


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


def _number(value: float) -> str:
    return f"{round(value, 3) + 0.0:g}"
