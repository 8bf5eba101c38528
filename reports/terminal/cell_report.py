"""What a robot does with a program, as a person wants to read it in a terminal."""

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from reports.tables.summary import clock, print_facts, print_findings
from robotcell.motion.retime import rates_of
from robotcell.robot.robot import Joint
from robotcell.track import CellReport


def print_cell_report(console: Console, report: CellReport) -> None:
    """Head line, the use of every joint, what is nearest to trouble, findings worst first."""
    origin = report.requested.origin
    verdict = "can be done" if not any(each.severity == "error" for each in report.findings) else "cannot be done"
    console.print(
        f"[bold]{escape(origin.board)}[/bold] with [bold]{escape(origin.recipe)}[/bold] in "
        f"[bold]{escape(report.cell.name)}[/bold] ({escape(report.cell.robot.name)}): {verdict}"
    )
    if report.possible:
        console.print(_joints(report))
        print_facts(console, _facts(report))
    print_findings(console, report.findings)


def _joints(report: CellReport) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("joint")
    for heading in ("from", "to", "limits", "speed", "of", "acceleration", "of"):
        table.add_column(heading, justify="right", no_wrap=True)
    rates = rates_of(report.program, report.joints)
    for index, joint in enumerate(report.cell.robot.joints):
        scale, unit = (180.0 / np.pi, "deg") if joint.kind == "revolute" else (1e3, "mm")
        speed = float(np.abs(rates.speed[:, index]).max(initial=0.0))
        push = float(np.abs(rates.acceleration[:, index]).max(initial=0.0))
        table.add_row(
            escape(joint.name),
            f"{scale * rates.q[:, index].min():.1f}",
            f"{scale * rates.q[:, index].max():.1f} {unit}",
            _limits(joint, scale),
            f"{scale * speed:.0f} {unit}/s",
            f"{speed / joint.speed:.0%}",
            f"{scale * push:.0f} {unit}/s²",
            f"{push / joint.acceleration:.0%}",
        )
    return table


def _limits(joint: Joint, scale: float) -> str:
    return " to ".join(
        f"{scale * each:.0f}" if np.isfinite(each) else "endless" for each in (joint.lowest, joint.highest)
    )


def _facts(report: CellReport) -> list[tuple[str, str]]:
    asked, done = report.requested.totals.duration_s, report.program.totals.duration_s
    took = clock(done) if abs(done - asked) < 0.05 else f"{clock(done)}, asked for {clock(asked)}"
    facts = [
        ("time", took),
        (
            "singular",
            f"w at least {report.singularity.min():.4f}, inverse condition at least {report.condition.min():.4f}",
        ),
    ]
    least = int(np.argmin(report.clearance.distances))
    touch = report.clearance.touches[least]
    near = 1e3 * report.clearance.distances[least]
    pair = f"nothing within {near:.0f} mm" if touch is None else f"{touch.body} to {touch.other}, {near:.1f} mm"
    return [*facts, ("nearest", pair)]
