"""What a robot does with a program, what a remedy changes, the program in its own language; and a cell: mm, degrees."""

import math
import shlex
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from programs.export import Exported
from programs.motion.installation import MAKER_NAMES
from reports.tables import table as model
from reports.tables.wording import clock
from robotcell.cell.cell_edits import describe_edits
from robotcell.cell.hold import FiducialFit, fit_fiducials
from robotcell.cell.load import LoadedCell, cell_library
from robotcell.cell.spec import Outputs
from robotcell.diagnosis.changes import Remedy
from robotcell.diagnosis.plausibility import Frame
from robotcell.motion.retime import rates_of
from robotcell.robot.robot import Body, Box, Capsule
from robotcell.track import CellReport
from specs.errors import printable


def check_card(report: CellReport) -> model.Card:
    """Show the use of every joint, what is nearest to trouble, findings."""
    stopped = any(each.severity == "error" for each in report.findings)
    result = "can be done" if report.possible and not stopped else "cannot be done"
    found = (_joints(report), model.FactList(check_facts(report))) if report.possible else ()
    title = cell_title(report, f"{result}{' as it is' * (report.possible and stopped)}")
    return model.Card(title, (*found, model.FindingList(report.findings)))


def cell_title(report: CellReport, result: str) -> model.Line:
    """Program and cell of a report, and what came out."""
    origin, cell = report.requested.origin, report.cell
    return model.program_title(origin, " in ", model.Text(cell.name, "strong"), f" ({cell.robot.name}): {result}")


def remedy_card(source: str, loaded: LoadedCell, remedy: Remedy) -> model.Card:
    """Show each edit of a remedy with its file and line, and the command that makes them; nothing without edits.

    Args:
        source: The cell as it was named: a file, which the command replaces, or a library cell, which it copies.
        loaded: The cell as it is.
        remedy: The remedy.
    """
    if not remedy.edits:
        return model.Card("", ())
    output = f"my-{source}.yaml" if source in cell_library() and not Path(source).is_file() else source
    words = ["washboard", "cell", "edit", source, *map(str, remedy.edits), "-o", output]
    lines = (*describe_edits(loaded.root, remedy.edits), shlex.join(words))
    return model.Card("Remedy:", (model.Verbatim("\n".join(f"  {printable(line)}" for line in lines)),))


def _joints(report: CellReport) -> model.Table:
    rates = rates_of(report.program, report.joints)
    rows: list[tuple[str, ...]] = []
    for index, joint in enumerate(report.cell.robot.joints):
        scale, unit = (180.0 / np.pi, "deg") if joint.kind == "revolute" else (1e3, "mm")
        speed = float(np.abs(rates.speed[:, index]).max(initial=0.0))
        push = float(np.abs(rates.acceleration[:, index]).max(initial=0.0))
        limits = [f"{scale * each:.0f}" if np.isfinite(each) else "endless" for each in (joint.lowest, joint.highest)]
        rows.append((
            joint.name, f"{scale * rates.q[:, index].min():.1f}", f"{scale * rates.q[:, index].max():.1f} {unit}",
            " to ".join(limits), f"{scale * speed:.0f} {unit}/s", f"{speed / joint.speed:.0%}",
            f"{scale * push:.0f} {unit}/s²", f"{push / joint.acceleration:.0%}",
        ))  # fmt: skip
    return model.Table.of(("joint", ">from", ">to", ">limits", ">speed", ">of", ">acceleration", ">of"), rows)


def check_facts(report: CellReport) -> model.Facts:
    """Time, home, how near singular configurations and bodies come; of a robot that can do the program."""
    planned, done = report.requested.totals.duration_s, report.program.totals.duration_s
    least = report.clearance.nearest
    touch = report.clearance.touches[least]
    near = 1e3 * report.clearance.distances[least]
    w, condition = report.singularity.min(), report.condition.min()
    return [
        ("time", clock(done) if abs(done - planned) < 0.05 else f"{clock(done)}, programmed {clock(planned)}"),
        ("home", report.added.describe()),
        ("singular", f"w at least {w:.4f}, inverse condition at least {condition:.4f}"),
        (
            "nearest",
            f"nothing within {near:.0f} mm" if touch is None else f"{touch.body} to {touch.other}, {near:.1f} mm",
        ),
    ]


def export_facts(report: CellReport, exported: Exported, dialect: str) -> model.Facts:
    """Language, size, time and accuracy of an exported program."""
    from programs.posts.dialects import DIALECTS  # all languages: a check needs none

    language, error, forecast = DIALECTS[dialect], exported.error, exported.forecast
    text = "".join(exported.files.values())
    planned_s, takes_s = report.requested.totals.duration_s, report.program.totals.duration_s
    longer = f", {clock(planned_s)} programmed" if abs(takes_s - planned_s) >= 0.5 else ""
    predicted: model.Facts = []  # where the text states its times, no controller's model predicts them
    if forecast is not None:
        events = f"wrong by at most {forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms at predicted speeds"
        predicted = [("predicted", forecast.describe()), ("", events)]
    return [
        ("language", f"{language.title}, class {language.capability.controller_class}"),
        ("files", f"{len(exported.files)}, {text.count(chr(10))} lines, {len(text) / 1000:.0f} kB"),
        ("time", clock(takes_s) + longer),
        *([("home", report.added.describe())] if report.possible else []),
        *predicted,
        ("events", f"wrong by at most {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms at planned speeds"),
        ("text", f"read back: {exported.agreement.describe()}"),
        ("note", language.notes),
    ]


def cell_card(loaded: LoadedCell, frames: Iterable[Frame]) -> model.Card:
    """Show the joints, frames, tools, fixtures and channels of a cell, and how well measured points fit."""
    spec, cell = loaded.spec, loaded.cell
    fit = fit_fiducials(spec.board) if spec.board.points is not None else None
    title, *blocks = model.source_lines(cell.name, spec.description, loaded.root.mark.file)
    bodies = [
        (body.name, f"tool {tool.number} {tool.name}", _shape(body)) for tool in cell.tools for body in tool.bodies
    ] + [(body.name, "the cell", _shape(body)) for body in cell.fixtures]
    measured = [] if fit is None else zip(fit.residuals_mm.tolist(), fit.distances_mm.tolist(), strict=True)
    residuals = [  # how far each measured point lies from where the fit puts it
        (f"{at}", *(f"{value:z.3f}" for value in (*off, distance))) for at, (off, distance) in enumerate(measured)
    ]
    tables = [
        _joint_limits(loaded),
        model.Table.of(
            (_name("frames, in the cell"), ">x mm", ">y mm", ">z mm", "looks"),
            [(each.what, *(f"{value:z.1f}" for value in each.place_mm), each.looks) for each in frames],
        ),
        model.Table.of((_name("measured point"), ">off x mm", ">off y mm", ">off z mm", ">off mm"), residuals),
        model.Table.of((_name(f"what may collide; margin {spec.margin_mm:g} mm"), "carried by", "shape"), bodies),
        model.Table.of((_name("commands"), "set"), _channels(loaded)),
    ]
    blocks += [block for table in tables if table.rows for block in ("", table)]
    return model.Card(title, (*blocks, *(() if fit is None else (_accuracy(fit, spec.board.noise_mm),))))


def _name(heading: str) -> model.Column:
    """First column of a table, whose heading names what it lists."""
    return model.Column(heading, emphasis="strong")


def _joint_limits(loaded: LoadedCell) -> model.Table:
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
    return model.Table.of(
        (_name(f"{robot.name}, {maker}"), *headings, *[">home on its controller"] * bool(counted)), rows
    )


def _accuracy(fit: FiducialFit, noise_mm: float) -> str:
    """Standard deviations of the place and the turn for the stated noise, the noise by the residuals, the stretch."""
    deviations = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    turn, place = (np.linalg.norm(deviations[part]) for part in (slice(0, 3), slice(3, 6)))
    found = "" if fit.redundancy < 1 else f"; {fit.noise_mm:.3f} mm by the residuals"
    stretch = ""
    if fit.kind != "rigid":
        (x, shear), (_, y) = fit.stretch.tolist()
        along, across, shear = (f"{1e6 * each:.0f}" for each in (x - 1, y - 1, shear))
        stretch = f"; stretched by {along} and {across} ppm along x and y, {shear} ppm shear"
    return (
        f"{fit.kind} fit with {noise_mm:g} mm a coordinate{found}: place ± {place:.3f} mm at the points' middle, "
        f"turn ± {math.degrees(float(turn)):.4f} deg{stretch}"
    )


def _channels(loaded: LoadedCell) -> list[tuple[str, str]]:
    """Commands of a program, and the outputs that each sets."""
    io = loaded.spec.io
    rows: list[tuple[str, str]] = []
    for name, nozzle in loaded.spec.nozzles.items():
        opens = f"opens in {nozzle.open_lag_s:g} s, closes in {nozzle.close_lag_s:g} s"
        lags = f"{opens}, pulses of {nozzle.min_pulse_s:g} s"
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
