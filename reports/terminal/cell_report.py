"""What a robot does with a program, its export, and where it holds the board best, on the terminal."""

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console

from programs.timing.forecast import Forecast
from reports.tables.placement_tables import (
    METRICS,
    configuration_table,
    failing_table,
    placement_facts,
    value_text,
)
from reports.tables.table import Facts, Table
from reports.tables.wording import amount, clock
from reports.terminal.console import print_facts, print_findings, print_line, print_table
from robotcell.cell.cell_edits import describe_edits, format_place
from robotcell.cell.load import LoadedCell, cell_library
from robotcell.diagnosis.changes import Remedy
from robotcell.motion.retime import rates_of
from robotcell.placement.configurations import PlacementDetails
from robotcell.placement.criteria import PlacementGoal
from robotcell.placement.optimise import Placement
from robotcell.placement.placement_map import PlacementMap
from robotcell.placement.reachability import Metric
from robotcell.search_placement import PartRelocation, Relocation
from robotcell.track import CellReport
from specs.errors import printable

if TYPE_CHECKING:
    from reports.files.export_robot import CellExport


def print_cell_report(console: Console, report: CellReport) -> None:
    """Print head line, the use of every joint, what is nearest to trouble, findings worst first."""
    stopped = any(each.severity == "error" for each in report.findings)
    _print_head(console, report, "cannot be done" if stopped else "can be done")
    if report.possible:
        print_table(console, _joints(report))
        print_facts(console, _facts(report))
    print_findings(console, report.findings)


def print_remedy(console: Console, source: str, loaded: LoadedCell, remedy: Remedy) -> None:
    """Print each edit of a remedy with its file and line, and the command that makes them.

    Args:
        console: Where.
        source: The cell as it was named: a file, which the command replaces, or a library cell, which it copies.
        loaded: The cell as it is.
        remedy: The remedy; nothing is printed for one without edits.
    """
    if not remedy.edits:
        return
    output = f"my-{source}.yaml" if source in cell_library() and not Path(source).is_file() else source
    words = ["washboard", "cell", "edit", source, *map(str, remedy.edits), "-o", output]
    console.print("Remedy:")
    for line in (*describe_edits(loaded.root, remedy.edits), shlex.join(words)):
        console.print(f"  {printable(line)}", markup=False, soft_wrap=True)


def _print_head(console: Console, report: CellReport, result: str) -> None:
    origin, cell = report.requested.origin, report.cell
    names = ((origin.board, "bold"), " with ", (origin.recipe, "bold"), " in ", (cell.name, "bold"))
    print_line(console, *names, f" ({cell.robot.name}): {result}")


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


def _facts(report: CellReport) -> Facts:
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


def export_facts(done: "CellExport", dialect: str) -> Facts:
    """Language, size, time and accuracy of an exported program."""
    from programs.posts.dialects import DIALECTS  # all languages: a check needs none

    language, error = DIALECTS[dialect], done.exported.error
    files, text = done.exported.files, "".join(done.exported.files.values())
    planned_s, takes_s = done.report.requested.totals.duration_s, done.report.program.totals.duration_s
    longer = f", {clock(planned_s)} programmed" if abs(takes_s - planned_s) >= 0.5 else ""
    return [
        ("language", f"{language.title}, class {language.capability.controller_class}"),
        ("files", f"{len(files)}, {text.count(chr(10))} lines, {len(text) / 1000:.0f} kB"),
        ("time", clock(takes_s) + longer),
        *([("home", done.report.added.describe())] if done.report.possible else []),
        *_predicted(done.exported.forecast),
        ("events", f"wrong by at most {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms at planned speeds"),
        ("text", f"read back: {done.exported.agreement.describe()}"),
        ("note", language.notes),
    ]


def _predicted(forecast: Forecast | None) -> Facts:
    """Time by the controller's model, and the events at its speeds; nothing where the text states its times."""
    if forecast is None:
        return []
    events = f"wrong by at most {forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms at predicted speeds"
    return [("predicted", forecast.describe()), ("", events)]


def print_relocation(console: Console, found: Relocation, goal: PlacementGoal) -> None:
    """Print head line, a row for each place that was checked, what was found at the best, and its YAML."""
    best = found.best
    _print_head(console, found.present.report, f"{METRICS[goal.metric]}, {amount(found.evaluated, 'place')} looked at")
    print_table(console, _places(found, goal))
    print_details(console, found.details, found.mapped)
    if best is not None:
        print_findings(console, best.report.findings)
        if found.present.report.cell.fixtures:
            console.print(
                "Fixtures stay where they are: a holder that goes with the board has to be moved, then check."
            )
        console.print(format_place(best.held_at, best.report.cell.held_by), markup=False, soft_wrap=True, end="")
    elif found.present.stopped_by:
        print_findings(console, (found.tried[-1] if found.tried else found.present).report.findings)
        console.print("No place was found where the robot can do the program.")
    else:
        console.print("No better place was found: the board stays where it is.")


def print_part_relocation(console: Console, workpiece: str, found: PartRelocation) -> None:
    """Print head line, the values before and there, what each configuration reaches, and the place's YAML."""
    cell, goal, best = found.cell, found.details.goal, found.found
    names = ((workpiece, "bold"), " in ", (cell.name, "bold"), f" ({cell.robot.name}): ")
    points = amount(len(found.details.targets.tool), "point")
    print_line(console, *names, f"{METRICS[goal.metric]} of {points}, {amount(best.tried, 'place')} looked at")
    rows = [
        (name, *_values(each, goal.metric), f"{1e3 * each.distance:.0f} mm", f"{math.degrees(each.yaw):.1f} deg")
        for name, each in (("as it is", found.present), ("best", best))
    ]
    print_table(console, Table.of(("", ">least", ">mean", ">radius", ">turned"), rows))
    print_details(console, found.details, found.mapped)
    if best.value >= 0.0:
        console.print(format_place(found.held_at, cell.held_by), markup=False, soft_wrap=True, end="")
    else:
        console.print("No place was found where the robot reaches all points well enough.")


def print_details(console: Console, details: PlacementDetails, mapped: PlacementMap | None) -> None:
    """Print what each configuration reaches at a placement, its worst point, and the points that fail."""
    print_table(console, configuration_table(details))
    print_facts(console, placement_facts(details, mapped))
    if details.failing:
        print_table(console, failing_table(details))
        print_line(console, f"{amount(len(details.failing), 'point')} in all.")


def _places(found: Relocation, goal: PlacementGoal) -> Table:
    trials = [("as it is", found.present)]
    trials += [("best" if each is found.best else "refused", each) for each in found.tried]
    rows: list[tuple[str, ...]] = []
    for name, trial in trials:
        placement, place = trial.placement, trial.held_at
        rows.append((
            name, *_values(placement, goal.metric), f"{1e3 * placement.distance:.0f} mm",
            f"{math.degrees(placement.yaw):.1f} deg", *(f"{value:.1f}" for value in place.xyz_mm),
            f"{place.rpy_deg[2]:.2f} deg",
            f"refused: {', '.join(trial.stopped_by)}"
            if trial.stopped_by
            else clock(trial.report.program.totals.duration_s),
        ))  # fmt: skip
    headings = (">least", ">mean", ">radius", ">turned", ">x", ">y", ">z", ">yaw", ">the robot takes")
    return Table.of(("", *headings), rows)


def _values(placement: Placement, metric: Metric) -> tuple[str, str]:
    """Give the least and the mean; the share of points that are reached where it is not all."""
    if not math.isfinite(placement.least):
        return f"{2.0 + placement.value:.0%} reached", ""
    return value_text(placement.least, metric), value_text(placement.mean, metric)
