"""What is found for a recipe: spacings, levelled films, the result of tuning."""

from collections.abc import Sequence

from reports.tables.cleaning_tables import UNCALIBRATED
from reports.tables.table import Block, Card, FactList, Facts, Table, Text, Tone, Verbatim
from reports.tables.wording import amount, clock
from rulesengine.levelling.pass_spacing import SpacingTable
from rulesengine.levelling.report import Goal, LevelledStep, LevelReport
from rulesengine.tuning.report import Reason, describe_end, is_unfinished
from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.request import TuningResult, cleanliness, pareto_front

_MOST_REASONS = 12
_MOST_FRONT = 8
_NO_GAP = 1e-7
"""Duality gap, relative, that is none: the search for an even film ends at it."""
_FRONT_HEADINGS = ("Pareto front", ">clean components", ">margin", ">time", ">litres")
_HEADINGS = ("change", ">clean components", ">open requirements", ">worst residue", ">time", ">litres")


def tuned_card(tuned: TuningResult, reasons: Sequence[Reason], diff: str) -> Card:
    """Show the result, each change with its effect and cost, unmet requirements and why, the difference."""
    worth = "It is a prediction for comparing recipes, no proof of cleanliness."
    worth += f" {UNCALIBRATED}" * (not tuned.calibrated)
    blocks: list[Block] = [Text(worth, "quiet")]
    blocks += [_changes(tuned), _front(tuned), FactList(_facts(tuned))]
    blocks += [
        (Text(reason.component, tone="warning"), f"  {reason.rule} {reason.name}: {reason.because} {reason.why}")
        for reason in reasons[:_MOST_REASONS]
    ]
    if len(reasons) > _MOST_REASONS:
        blocks.append(f"and {amount(len(reasons) - _MOST_REASONS, 'more component')}; --report has all of them")
    if is_unfinished(tuned):
        blocks.append("With a higher --analyses, tuning may find more.")
    blocks.append(Verbatim(diff, "changed") if diff else Text("The recipe stays as it is.", "quiet"))
    tone: Tone = "clean" if tuned.last.clean and tuned.within_limits else "marginal"
    return Card(Text(_headline(tuned), tone=tone), tuple(blocks))


def _headline(tuned: TuningResult) -> str:
    first, last = tuned.first, tuned.last
    before = first.figures.clean_components
    clean = f"{last.figures.clean_components} of {amount(last.total, 'component')} clean"
    if not tuned.within_limits:
        return f"The limits cannot be kept with what may be changed; at its best {clean}."
    if last.clean:
        return f"Predicted clean: {clean}" + (", as before." if first.clean else f", {before} before.")
    return f"Not clean: {clean}, {before} before. The reasons are below."


def _changes(tuned: TuningResult) -> Table:
    def totals(name: str, figures: Figures) -> tuple[str | Text, ...]:
        clean = f"{figures.clean_components} of {tuned.last.total}"
        counts = (clean, str(figures.open_requirements), f"{figures.worst_residue:.2%}")
        return (Text(name, "quiet"), *counts, clock(figures.seconds), f"{figures.litres:.2f}")

    rows = [totals("as it was", tuned.first.figures)]
    for change in tuned.changes:
        before, after = change.before, change.after
        differences = (
            after.clean_components - before.clean_components,
            after.open_requirements - before.open_requirements,
        )
        rows += [(what, "", "", "", "", "") for what in change.what[:-1]]  # made at once: the last has the numbers
        rows.append((
            change.what[-1],
            *(f"{count:+d}" if count else "" for count in differences),
            f"{before.worst_residue:.2%} -> {after.worst_residue:.2%}",
            f"{after.seconds - before.seconds:+z.1f} s",
            f"{after.litres - before.litres:+z.2f}",
        ))  # fmt: skip
    return Table.of(_HEADINGS, [*rows, totals("as it is now", tuned.last.figures)])


def _front(tuned: TuningResult) -> Table:
    """Recipes of the Pareto front, the cleanest first, by the numbers of picture and files."""
    rows: list[tuple[str, ...]] = []
    numbered = enumerate(pareto_front(tuned.trials), 1)
    for number, each in sorted(numbered, key=lambda pair: cleanliness(pair[1]), reverse=True)[:_MOST_FRONT]:
        figures = each.figures
        rows.append((
            f"{number}{' (chosen)' if each.text == tuned.last.text else ''}",
            f"{figures.clean_components} of {tuned.last.total}",
            f"{each.margin:.2f}" if each.margin else "",
            clock(figures.seconds),
            f"{figures.litres:.2f}",
        ))  # fmt: skip
    return Table.of(_FRONT_HEADINGS, rows)


def _facts(tuned: TuningResult) -> Facts:
    facts = [("analyses", f"{tuned.used} of at most {tuned.request.max_analyses}"), ("ended", describe_end(tuned))]
    loops = [f"sequence[{at}]" for at, step in enumerate(tuned.last.recipe.sequence) if step.enabled and step.until]
    if loops:
        facts.append(("repeats", f"{', '.join(loops)}: repeated until a sensor ends them; time and liquid count once"))
    if tuned.robot is not None:
        left = amount(tuned.robot.infeasible, "candidate")
        text = f"{tuned.robot.cell} ({tuned.robot.name}): times are the robot's; it cannot carry out {left}"
        facts.append(("cell", text))
    if tuned.last.excluded:
        facts.append(("left out", f"{', '.join(sorted(tuned.last.excluded))}: masks avoid or ignore them"))
    return facts


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
        (name, form.format(was), form.format(now), f"{100.0 * (now / was - 1.0):+z.1f} %" if was > 0.0 else "")
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
    facts = [("spraying", sprayed), ("program", f"{program}, duality gap {_gap(step.gap)}")]
    if goal == "least-time":
        share = 100.0 * step.below / step.after.finer.cells
        lost = f"lose up to {100.0 * step.below_lose:.0f} %" if step.below else "lose nothing"
        facts.append(("below", f"{share:.1f} % of the places, which had less than that before, {lost}"))
    if not step.levelled:
        reason = "ramps would take back what is saved" if goal == "least-time" else "levelled it would be no more even"
        facts.append(("kept", f"{reason}: the step keeps its speeds"))
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


def _gap(gap: float) -> str:
    """Write a duality gap; below what the solvers are to reach, its digits are rounding, and each machine's own."""
    return f"{gap:.1e}" if gap >= _NO_GAP else f"under {_NO_GAP:g}"


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
