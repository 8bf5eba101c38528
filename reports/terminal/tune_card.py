"""Result of tuning in the terminal."""

from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from reports.tables.summary import amount, clock, print_facts
from rulesengine.tuning.report import Reason, is_unfinished
from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.result import TuningResult

_MOST_REASONS = 12
_STYLES = {"+": "green", "-": "red", "@": "dim"}


def print_tuned(console: Console, tuned: TuningResult, reasons: Sequence[Reason], diff: str) -> None:
    """Print the headline, each change with effect and cost, the open requirements with reasons, and the diff."""
    console.print(escape(_headline(tuned)), style="green" if tuned.last.clean and tuned.within_limits else "yellow")
    console.print("It is a prediction for comparing recipes, no proof of cleanliness.", style="dim")
    console.print(_changes(tuned))
    print_facts(console, _facts(tuned))
    for reason in reasons[:_MOST_REASONS]:
        console.print(f"[yellow]{escape(reason.component)}[/]  {reason.rule} {escape(reason.name)}: ", end="")
        console.print(escape(f"{reason.because} {reason.why}"))
    if len(reasons) > _MOST_REASONS:
        console.print(f"and {amount(len(reasons) - _MOST_REASONS, 'more component')}; --report has all of them")
    if is_unfinished(tuned):
        console.print("With a higher --analyses, tuning may find more.")
    for line in diff.splitlines():
        console.print(Text(line, style=_STYLES.get(line[:1], "")), soft_wrap=True)
    if not diff:
        console.print("[dim]The recipe stays as it is.[/dim]")


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
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("change", overflow="fold")
    for heading in ("clean components", "open requirements", "worst residue", "time", "litres"):
        table.add_column(heading, justify="right", no_wrap=False)
    first = tuned.first.figures
    table.add_row("[dim]as it was[/dim]", *_totals(first, tuned.last.total))
    for change in tuned.changes:
        before, after = change.before, change.after
        for what in change.what[:-1]:  # made at once: the last of them has the numbers of all
            table.add_row(escape(what))
        table.add_row(
            escape(change.what[-1]),
            _difference(before.clean_components, after.clean_components),
            _difference(before.open_requirements, after.open_requirements),
            f"{before.worst_residue:.2%} -> {after.worst_residue:.2%}",
            f"{after.seconds - before.seconds:+.1f} s",
            f"{after.litres - before.litres:+.2f}",
        )
    table.add_row("[dim]as it is now[/dim]", *_totals(tuned.last.figures, tuned.last.total))
    return table


def _difference(before: int, after: int) -> str:
    return f"{after - before:+d}" if after != before else ""


def _totals(figures: Figures, total: int) -> tuple[str, str, str, str, str]:
    return (
        f"{figures.clean_components} of {total}",
        str(figures.open_requirements),
        f"{figures.worst_residue:.2%}",
        clock(figures.seconds),
        f"{figures.litres:.2f}",
    )


def _facts(tuned: TuningResult) -> list[tuple[str, str]]:
    facts = [("analyses", f"{tuned.used} of at most {tuned.request.max_analyses}")]
    loops = [f"sequence[{at}]" for at, step in enumerate(tuned.last.recipe.sequence) if step.enabled and step.until]
    if loops:
        facts.append(("repeats", f"{', '.join(loops)}: repeated until a sensor ends them; time and liquid count once"))
    if tuned.last.excluded:
        facts.append(("left out", f"{', '.join(sorted(tuned.last.excluded))}: masks avoid or ignore them"))
    return facts
