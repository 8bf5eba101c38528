"""What came of tuning, as a person wants to read it in a terminal."""

from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from reports.tables.summary import amount, clock, print_facts
from rulesengine.tuning.explain import Reason, is_unfinished
from rulesengine.tuning.trial.result import Figures, Tuned, figures_of

_MOST_REASONS = 12
_STYLES = {"+": "green", "-": "red", "@": "dim"}


def print_tuned(console: Console, tuned: Tuned, reasons: Sequence[Reason], diff: str) -> None:
    """What became of the recipe, each change with what it does and costs, what stays and why, the difference."""
    console.print(escape(_headline(tuned)), style="green" if tuned.last.clean and tuned.within else "yellow")
    console.print("It is a prediction, made to compare recipes with, and no proof of cleanliness.", style="dim")
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


def _headline(tuned: Tuned) -> str:
    first, last = tuned.first, tuned.last
    held = f"{last.held} of {amount(last.total, 'component')} lack nothing"
    if not tuned.within:
        return f"The limits cannot be kept with what may be changed; at its best {held}."
    if last.clean:
        return f"Predicted clean: {held}" + (", as before." if first.clean else f", {first.held} before.")
    return f"Not clean: {held}, {first.held} before. Why is said below."


def _changes(tuned: Tuned) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("change", overflow="fold")
    for heading in ("components that lack nothing", "wanting", "worst residue", "time", "litres"):
        table.add_column(heading, justify="right", no_wrap=False)
    first = figures_of(tuned.first)
    table.add_row("[dim]as it was[/dim]", *_totals(first, tuned.last.total))
    for change in tuned.changes:
        before, after = change.before, change.after
        for what in change.what[:-1]:  # made at once: the last of them has the numbers of all
            table.add_row(escape(what))
        table.add_row(
            escape(change.what[-1]),
            f"{after.held - before.held:+d}" if after.held != before.held else "",
            f"{after.wanting - before.wanting:+d}" if after.wanting != before.wanting else "",
            f"{before.worst_residue:.2%} -> {after.worst_residue:.2%}",
            f"{after.seconds - before.seconds:+.1f} s",
            f"{after.litres - before.litres:+.2f}",
        )
    table.add_row("[dim]as it is now[/dim]", *_totals(figures_of(tuned.last), tuned.last.total))
    return table


def _totals(figures: Figures, total: int) -> tuple[str, str, str, str, str]:
    return (
        f"{figures.held} of {total}",
        str(figures.wanting),
        f"{figures.worst_residue:.2%}",
        clock(figures.seconds),
        f"{figures.litres:.2f}",
    )


def _facts(tuned: Tuned) -> list[tuple[str, str]]:
    facts = [("analyses", f"{tuned.used} of at most {tuned.asked.analyses}")]
    loops = [f"sequence[{at}]" for at, step in enumerate(tuned.last.recipe.sequence) if step.enabled and step.until]
    if loops:
        facts.append(
            ("repeats", f"{', '.join(loops)}: repeated until a sensor says so; time and liquid are those of once")
        )
    if tuned.last.left_out:
        facts.append(("left out", f"{', '.join(sorted(tuned.last.left_out))}: masks avoid or ignore them"))
    return facts
