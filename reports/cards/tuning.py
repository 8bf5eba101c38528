"""Result of tuning."""

from collections.abc import Sequence

from reports.tables.table import Block, Card, FactList, Facts, Table, Text, Tone, Verbatim
from reports.tables.wording import amount, clock
from rulesengine.tuning.front import cleanliness, pareto_front
from rulesengine.tuning.report import Reason, describe_end, is_unfinished
from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.request import TuningResult

_MOST_REASONS = 12
_MOST_FRONT = 8
_FRONT_HEADINGS = ("Pareto front", ">clean components", ">margin", ">time", ">litres")
_HEADINGS = ("change", ">clean components", ">open requirements", ">worst residue", ">time", ">litres")


def tuned_card(tuned: TuningResult, reasons: Sequence[Reason], diff: str) -> Card:
    """Show the result, each change with its effect and cost, unmet requirements and why, the difference."""
    blocks: list[Block] = [Text("It is a prediction for comparing recipes, no proof of cleanliness.", "quiet")]
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
        counts = (
            f"{figures.clean_components} of {tuned.last.total}",
            str(figures.open_requirements),
            f"{figures.worst_residue:.2%}",
        )
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
            f"{after.seconds - before.seconds:+.1f} s",
            f"{after.litres - before.litres:+.2f}",
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
