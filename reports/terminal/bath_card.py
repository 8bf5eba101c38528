"""A washing bath over many boards, on the terminal."""

from collections.abc import Sequence

from rich.console import Console

from cleaning.uncertainty.bath import Bath, BoardInBath
from cleaning.verdicts.cleanliness import count_cleanliness, report_outcome
from reports.tables.cleaning_tables import caveat
from reports.tables.rinse_tables import rinse_over_boards
from reports.tables.table import Cell, Table, Text
from reports.tables.wording import amount, short_number
from reports.terminal.console import print_facts, print_line, print_table

_HEAD = (">board", ">residue in the bath", ">refractometer reads", "verdict", "components", ">worst residue")


def print_bath(console: Console, bath: Bath, liquid: str, limit_pct: float, boards: Sequence[BoardInBath]) -> None:
    """Print what a board brings and takes along, when the bath is spent, and the boards that were analysed."""
    origin = boards[0].report.origin
    print_line(
        console,
        (origin.board, "bold"),
        " with ",
        (origin.recipe, "bold"),
        f" in a bath of {bath.volume_l:g} l of {liquid}",
    )
    print_line(console, (caveat(boards[0].report), "dim"))
    brought, taken = short_number(1e3 * bath.flux_g), short_number(bath.drag_out_ml)
    balance = f"brings {brought} mg of flux, takes {taken} ml of the bath along, which fresh solution makes up"
    begins = "" if bath.begin_pct is None else f"begins with {bath.begin_pct:g} % residue; "
    rinse = [("rinse", each) for each in rinse_over_boards(bath, boards)]
    print_facts(console, [("each board", balance), ("bath", begins + change_words(bath, limit_pct)), *rinse])
    concentration = boards[0].report.parameters.liquids[liquid].concentration_pct
    rows = [_row(each, concentration) for each in boards]
    water = boards[0].report.rinse_water
    tanks = [] if water is None else [f">{solution}, MΩ·cm" for solution in water.cascade.solutions]
    print_table(console, Table.of((*_HEAD, *tanks), rows))


def change_words(bath: Bath, limit_pct: float) -> str:
    """When the bath is to be changed, and by which limit."""
    limit = f"{limit_pct:g} % non-volatile residue"
    boards = bath.boards_until(limit_pct)
    if boards is None:
        return f"never reaches {limit}: it settles at {bath.settles_pct:.2g} %"
    return f"change it after {amount(boards, 'board')}, for {limit}"


def _row(washed: BoardInBath, concentration_pct: float) -> tuple[Cell, ...]:
    report, water = washed.report, washed.report.rinse_water
    outcome = report_outcome(report)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in count_cleanliness(report.parts).items())
    worst = max((part.residue for part in report.parts if part.residue is not None), default=None)
    return (
        f"{washed.number:,}",
        f"{washed.residue_pct:.2f} %",
        f"{concentration_pct + washed.residue_pct:.1f} %",  # it takes what is dissolved for agent
        Text(outcome, tone=outcome),
        counts,
        "" if worst is None else f"{100.0 * worst:.2g} %",
        *(short_number(tank.resistivity_mohm_cm) for tank in ([] if water is None else water.tanks)),
    )
