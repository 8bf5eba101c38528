"""Spacings and levelled films."""

from reports.tables.table import Block, Card, FactList, Table, Text
from rulesengine.levelling.pass_spacing import SpacingTable
from rulesengine.levelling.report import Goal, LevelledStep, LevelReport


def spacings_card(table: SpacingTable) -> Card:
    """Show every even spacing, its ripple, the speed that lays the film, and whether that is allowed."""
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
    limit = f"{table.max_speed_mm_s:g} mm/s ({table.max_speed_of})"
    if not table.valleys:
        remark = "No spacing down to a tenth of the pattern's width is even: hills of one pass remain."
    elif best is None:
        slowest = table.valleys[0].speed_mm_s
        remark = (
            f"None is allowed by {limit}: the widest needs {slowest:.1f} mm/s. Lower the flow or the pressure, or lay "
            f"at least {table.film_um * slowest / table.max_speed_mm_s:.1f} µm."
        )
    else:
        remark = f"At most {limit}. Between these spacings the ripple rises to hills; see the picture."
    head = f"{table.film_um:g} µm with {table.nozzle} from {table.height_mm:g} mm, {table.flow_lpm:.4g} l/min"
    columns = (">spacing", ">ripple", ">film", ">speed", ">overlapping", "")
    return Card(Text(head, "strong"), (Table.of(columns, rows), remark))


def levelled_card(report: LevelReport) -> Card:
    """Show what each step gained, how even its film is on both sets of cells and after timing, and the totals."""
    before, after = report.before, report.after
    measured = (
        ("time", before.duration_s, after.duration_s, "{:.1f} s"),
        ("spraying", before.spray_s, after.spray_s, "{:.1f} s"),
        ("liquid", before.litres, after.litres, "{:.3f} l"),
    )
    rows = [
        (name, form.format(was), form.format(now), f"{100.0 * (now / was - 1.0):+.1f} %" if was > 0.0 else "")
        for name, was, now, form in measured
    ]
    blocks = [block for step in report.steps for block in _step(report.goal, step)]
    return Card("", (*blocks, Table.of(("whole program", ">before", ">levelled", ">"), rows)))


def _step(goal: Goal, step: LevelledStep) -> tuple[Block, ...]:
    head = f"equal deposit on {step.surfaces} surfaces: components, and the bare board"
    if step.target_um is not None:
        head = f"{'at least' if goal == 'least-time' else 'even'} {step.target_um:.4g} µm"
    sprayed = (
        f"{step.spray_before_s:.1f} s before, {step.spray_after_s:.1f} s now, without ramps {step.planned_s:.1f} s"
    )
    if goal == "least-time":
        sprayed += f"; the linear program's least is {step.bound_s:.1f} s"
    else:
        sprayed += f"; the linear program's most even is ±{100.0 * step.bound_s:.2f} %"
    program = f"{step.segments} segments, {step.knots} knots, {step.rows} of the cells in {step.rounds} rounds"
    facts = [("spraying", sprayed), ("program", f"{program}, duality gap {step.gap:.1e}")]
    if goal == "least-time":
        share = 100.0 * step.below / step.after.finer.cells
        lost = f"lose up to {100.0 * step.below_lose:.0f} %" if step.below else "lose nothing"
        facts.append(("below", f"{share:.1f} % of the places, which had less than that before, {lost}"))
    if not step.levelled:
        facts.append(("kept", "ramps would take back what is saved: the step keeps its speeds"))
    if step.kept_s > 0.0:
        facts.append(("least time", f"{step.kept_s:.1f} s of spraying are kept: the step's least_time_s needs them"))
    if step.short:
        facts.append(("short", f"{step.short} places cannot get the film at the slowest speeds; they get all there is"))
    miss = ">short by" if goal == "least-time" else ">off by"
    return (
        (Text(f"{step.function} with {step.nozzle}, {head}", "strong"), f"  {step.made_by}"),
        Table.of(("film", ">cells", ">least", ">mean", ">most", miss), _films(step)),
        FactList(facts),
    )


def _films(step: LevelledStep) -> list[tuple[str, ...]]:
    named = {
        "before": step.before.planned,
        "before, finer cells": step.before.finer,
        "levelled": step.after.planned,
        "levelled, finer cells": step.after.finer,
        "levelled and timed": step.timed.planned,
        "levelled and timed, finer cells": step.timed.finer,
    }
    return [
        (
            name, f"{film.cells:,}", *(f"{each:.4g} µm" for each in (film.least, film.mean, film.most)),
            f"{100.0 * film.deviation:.2f} %",
        )
        for name, film in named.items()
    ]  # fmt: skip
