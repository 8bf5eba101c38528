"""What a robot does with a program, what a remedy changes, and the program in the robot's own language."""

import shlex
from pathlib import Path

import numpy as np

from programs.export import Exported
from reports.tables.table import Card, FactList, Facts, FindingList, Line, Table, Text, Verbatim
from reports.tables.wording import clock
from robotcell.cell.cell_edits import describe_edits
from robotcell.cell.load import LoadedCell, cell_library
from robotcell.diagnosis.changes import Remedy
from robotcell.motion.retime import rates_of
from robotcell.track import CellReport
from specs.errors import printable


def check_card(report: CellReport) -> Card:
    """Show the use of every joint, what is nearest to trouble, findings."""
    stopped = any(each.severity == "error" for each in report.findings)
    result = "can be done" if report.possible and not stopped else "cannot be done"
    found = (_joints(report), FactList(check_facts(report))) if report.possible else ()
    title = cell_title(report, f"{result}{' as it is' * (report.possible and stopped)}")
    return Card(title, (*found, FindingList(report.findings)))


def cell_title(report: CellReport, result: str) -> Line:
    """Program and cell of a report, and what came out."""
    origin, cell = report.requested.origin, report.cell
    names = (Text(origin.board, "strong"), " with ", Text(origin.recipe, "strong"), " in ", Text(cell.name, "strong"))
    return (*names, f" ({cell.robot.name}): {result}")


def remedy_card(source: str, loaded: LoadedCell, remedy: Remedy) -> Card:
    """Show each edit of a remedy with its file and line, and the command that makes them; nothing without edits.

    Args:
        source: The cell as it was named: a file, which the command replaces, or a library cell, which it copies.
        loaded: The cell as it is.
        remedy: The remedy.
    """
    if not remedy.edits:
        return Card("", ())
    output = f"my-{source}.yaml" if source in cell_library() and not Path(source).is_file() else source
    words = ["washboard", "cell", "edit", source, *map(str, remedy.edits), "-o", output]
    lines = (*describe_edits(loaded.root, remedy.edits), shlex.join(words))
    return Card("Remedy:", (Verbatim("\n".join(f"  {printable(line)}" for line in lines)),))


def _joints(report: CellReport) -> Table:
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
    return Table.of(("joint", ">from", ">to", ">limits", ">speed", ">of", ">acceleration", ">of"), rows)


def check_facts(report: CellReport) -> Facts:
    """Time, home, how near singular configurations and bodies come; of a robot that can do the program."""
    planned, done = report.requested.totals.duration_s, report.program.totals.duration_s
    least = int(np.argmin(report.clearance.distances))
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


def export_facts(report: CellReport, exported: Exported, dialect: str) -> Facts:
    """Language, size, time and accuracy of an exported program."""
    from programs.posts.dialects import DIALECTS  # all languages: a check needs none

    language, error, forecast = DIALECTS[dialect], exported.error, exported.forecast
    text = "".join(exported.files.values())
    planned_s, takes_s = report.requested.totals.duration_s, report.program.totals.duration_s
    longer = f", {clock(planned_s)} programmed" if abs(takes_s - planned_s) >= 0.5 else ""
    predicted: Facts = []  # where the text states its times, no controller's model predicts them
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
