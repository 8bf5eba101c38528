"""Spacings and levelled films on the terminal."""

from rich.console import Console

from reports.tables.table import Table
from reports.terminal.console import print_facts, print_line, print_table
from rulesengine.levelling.pass_spacing import SpacingTable
from rulesengine.levelling.report import FilmSpread, Goal, LevelledStep, LevelReport


def print_spacings(console: Console, table: SpacingTable) -> None:
    """Print every even spacing, its ripple, the speed that lays the film, and whether that is allowed."""
    head = f"{table.film_um:g} µm with {table.nozzle} from {table.height_mm:g} mm, {table.flow_lpm:.4g} l/min"
    print_line(console, (head, "bold"))
    best = table.best
    rows: list[tuple[str, ...]] = []
    for each in table.valleys:
        found, scale = each.spacing, table.film_um / each.spacing.middle
        note = "best" if each is best else "allowed" if each.allowed else "too fast"
        rows.append(
            (
                f"{found.spacing:.3f} mm", f"±{100.0 * found.ripple:.2f} %",
                f"{found.low * scale:.3f} to {found.high * scale:.3f} µm", f"{each.speed_mm_s:.1f} mm/s",
                str(each.overlapping), note,
            )
        )  # fmt: skip
    print_table(console, Table.of((">spacing", ">ripple", ">film", ">speed", ">overlapping", ""), rows))
    limit = f"{table.max_speed_mm_s:g} mm/s ({table.max_speed_of})"
    if not table.valleys:
        console.print("No spacing down to a tenth of the pattern's width is even: hills of one pass remain.")
    elif best is None:
        slowest = table.valleys[0].speed_mm_s
        console.print(
            f"None is allowed by {limit}: the widest needs {slowest:.1f} mm/s. Lower the flow or the pressure, or lay "
            f"at least {table.film_um * slowest / table.max_speed_mm_s:.1f} µm."
        )
    else:
        console.print(f"At most {limit}. Between these spacings the ripple rises to hills; see the picture.")


def print_levelled(console: Console, report: LevelReport) -> None:
    """Print what each step gained, how even its film is on both sets of cells and after timing, and the totals."""
    for step in report.steps:
        head = f"{step.function} with {step.nozzle}, {_goal(report.goal, step)}"
        print_line(console, (head, "bold"), f"  {step.made_by}")
        print_table(console, Table.of(("film", ">cells", ">least", ">mean", ">most", _miss(report.goal)), _films(step)))
        sprayed = (
            f"{step.spray_before_s:.1f} s before, {step.spray_after_s:.1f} s now, without ramps {step.planned_s:.1f} s"
        )
        if report.goal == "least-time":
            sprayed += f"; the linear program's least is {step.bound_s:.1f} s"
        else:
            sprayed += f"; the linear program's most even is ±{100.0 * step.bound_s:.2f} %"
        program = f"{step.segments} segments, {step.knots} knots, {step.rows} of the cells in {step.rounds} rounds"
        facts = [("spraying", sprayed), ("program", f"{program}, duality gap {step.gap:.1e}")]
        if report.goal == "least-time":
            share = 100.0 * step.below / step.after.finer.cells
            lost = f"lose up to {100.0 * step.below_lose:.0f} %" if step.below else "lose nothing"
            facts.append(("below", f"{share:.1f} % of the places, which had less than that before, {lost}"))
        if not step.levelled:
            facts.append(("kept", "ramps would take back what is saved: the step keeps its speeds"))
        if step.kept_s > 0.0:
            facts.append(
                ("least time", f"{step.kept_s:.1f} s of spraying are kept: the step's least_time_s needs them")
            )
        if step.short:
            facts.append(
                ("short", f"{step.short} places cannot get the film at the slowest speeds; they get all there is")
            )
        print_facts(console, facts)
    before, after = report.before, report.after
    rows = [
        (
            "time",
            f"{before.duration_s:.1f} s",
            f"{after.duration_s:.1f} s",
            _change(before.duration_s, after.duration_s),
        ),
        ("spraying", f"{before.spray_s:.1f} s", f"{after.spray_s:.1f} s", _change(before.spray_s, after.spray_s)),
        ("liquid", f"{before.litres:.3f} l", f"{after.litres:.3f} l", _change(before.litres, after.litres)),
    ]
    print_table(console, Table.of(("whole program", ">before", ">levelled", ">"), rows))


def _films(step: LevelledStep) -> list[tuple[str, ...]]:
    named = {
        "before": step.before.planned,
        "before, finer cells": step.before.finer,
        "levelled": step.after.planned,
        "levelled, finer cells": step.after.finer,
        "levelled and timed": step.timed.planned,
        "levelled and timed, finer cells": step.timed.finer,
    }
    return [(name, *_numbers(film)) for name, film in named.items()]


def _numbers(film: FilmSpread) -> tuple[str, ...]:
    amounts = (f"{each:.4g} µm" for each in (film.least, film.mean, film.most))
    return (f"{film.cells:,}", *amounts, f"{100.0 * film.deviation:.2f} %")


def _goal(goal: Goal, step: LevelledStep) -> str:
    if step.target_um is None:
        return f"equal deposit on {step.surfaces} surfaces: components, and the bare board"
    return f"{'at least' if goal == 'least-time' else 'even'} {step.target_um:.4g} µm"


def _miss(goal: Goal) -> str:
    return ">short by" if goal == "least-time" else ">off by"


def _change(before: float, after: float) -> str:
    return f"{100.0 * (after / before - 1.0):+.1f} %" if before > 0.0 else ""
