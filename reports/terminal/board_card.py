"""A board as it was understood, and the class of each component, for the terminal."""

from collections.abc import Iterable, Sequence

from rich.console import Console

from boards.board import Board, Component
from boards.packages.gap_height import STATED, UNKNOWN
from reports.tables.run_report import board_facts
from reports.tables.table import Column, Table
from reports.tables.wording import amount
from reports.terminal.console import print_facts, print_findings, print_line, print_table
from rulesengine.strokes.classify import Classified

_GUESSED = " *"
_WIDEST_NAME = 24


def print_board(console: Console, board: Board, rows: int | None = None) -> None:
    """Print the board's card: what was understood, its components, its findings.

    Args:
        console: Where to.
        board: The board.
        rows: How many components to list; all of them without.
    """
    print_line(console, (board.name, "bold"))
    print_facts(console, list(board_facts(board).items()))
    listed = board.components[:rows]
    if listed:
        print_table(console, _components(listed))
    if 0 < len(listed) < len(board.components):
        more = amount(len(board.components) - len(listed), "more component")
        print_line(console, (f"and {more}", "dim"), "; --all lists them")
    if any(_is_guessed(component) for component in listed):
        note = "* from the package family; state standoffs in the board file or a parts table"
        print_line(console, (note, "dim"))
    print_findings(console, board.findings)


def print_classes(console: Console, components: Iterable[Component], classified: Sequence[Classified]) -> None:
    """Print which class takes each component and why, in the order of the board."""
    rows = [
        (each.component, component.package, each.component_class, each.because)
        for each, component in zip(classified, components, strict=True)
    ]
    name = _name_column([each.component for each in classified])
    print_table(console, Table.of((name, Column("package", at_most=32), "class", "because"), rows))


def _components(components: Sequence[Component]) -> Table:
    rows: list[tuple[str, ...]] = []
    for each in components:
        height = "unknown" if each.gap_height_mm is None else f"{each.gap_height_mm:.3f}"
        mark = _GUESSED if each.gap_height_mm is not None and _is_guessed(each) else " " * len(_GUESSED)
        nearest = [(f"{distance:.2f}", name) for name, distance in each.neighbours[:1]] or [("", "")]
        rows.append((
            each.name, each.package, each.side, str(each.pins), f"{each.area_mm2:.2f}", f"{each.height_mm:.2f}",
            height + mark, *nearest[0],
        ))  # fmt: skip
    measures = (">pins", ">area\nmm2", ">height\nmm", ">standoff\nmm", ">nearest\nmm", "\nto")
    return Table.of((_name_column([each.name for each in components]), "package", "side", *measures), rows)


def _name_column(names: Iterable[str]) -> Column:
    """A first column that never gives way to a package's long name."""
    return Column("component", at_least=min(max(map(len, names), default=0), _WIDEST_NAME))


def _is_guessed(component: Component) -> bool:
    return component.gap_height_source not in (STATED, UNKNOWN)
