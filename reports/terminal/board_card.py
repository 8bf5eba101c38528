"""A board as it was understood, and the class of each component, for the terminal."""

from collections.abc import Iterable, Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from boards.board import Board, Component
from boards.packages.gap_height import STATED, UNKNOWN
from reports.tables.run_report import board_facts
from reports.tables.summary import amount, print_facts, print_findings
from rulesengine.strokes.classify import Classified

_GUESSED = " *"
_WIDEST_NAME = 24


def print_board(console: Console, board: Board, rows: int | None = None) -> None:
    """The board's card: what was understood, its components, its findings.

    Args:
        console: Where to.
        board: The board.
        rows: How many components to list; all of them without.
    """
    console.print(Text(board.name, "bold"))
    print_facts(console, board_facts(board).items())
    listed = board.components[:rows]
    if listed:
        console.print(_components(listed))
    if 0 < len(listed) < len(board.components):
        console.print(
            f"[dim]and {amount(len(board.components) - len(listed), 'more component')}[/dim]; --all lists them"
        )
    if any(_is_guessed(component) for component in listed):
        console.print("[dim]* from the package family; state standoffs in the board file or a parts table[/dim]")
    print_findings(console, board.findings)


def print_classes(console: Console, components: Iterable[Component], classified: Sequence[Classified]) -> None:
    """Which class takes each component and why, in file order."""
    table = _table([each.component for each in classified])
    table.add_column("package", overflow="ellipsis", max_width=32)
    table.add_column("class", no_wrap=True)
    table.add_column("because")
    for each, component in zip(classified, components, strict=True):
        cells = (each.component, component.package, each.component_class, each.because)
        table.add_row(*(escape(cell) for cell in cells))
    console.print(table)


def _components(components: Sequence[Component]) -> Table:
    table = _table([component.name for component in components])
    table.add_column("package", overflow="ellipsis")
    table.add_column("side", no_wrap=True)
    for heading in ("pins", "area\nmm2", "height\nmm", "standoff\nmm", "nearest\nmm"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("\nto", no_wrap=True)
    for component in components:
        nearest = component.neighbours[0] if component.neighbours else None
        table.add_row(
            escape(component.name),
            escape(component.package),
            component.side,
            str(component.pins),
            f"{component.area_mm2:.2f}",
            f"{component.height_mm:.2f}",
            _gap_height(component),
            "" if nearest is None else f"{nearest[1]:.2f}",
            "" if nearest is None else escape(nearest[0]),
        )
    return table


def _table(names: Iterable[str]) -> Table:
    """A table whose first column never gives way to a package's long name."""
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("component", overflow="fold", min_width=min(max(map(len, names), default=0), _WIDEST_NAME))
    return table


def _gap_height(component: Component) -> str:
    if component.gap_height_mm is None:
        return "unknown" + " " * len(_GUESSED)
    return f"{component.gap_height_mm:.3f}" + (_GUESSED if _is_guessed(component) else " " * len(_GUESSED))


def _is_guessed(component: Component) -> bool:
    return component.gap_height_source not in (STATED, UNKNOWN)
