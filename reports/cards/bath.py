"""A washing bath over many boards, and the rinse tanks behind it."""

from collections.abc import Sequence

from cleaning.uncertainty.bath import Bath, BoardInBath
from cleaning.verdicts.cleanliness import report_outcome
from reports.tables.cleaning_tables import caveat, count_words
from reports.tables.table import Card, Cell, FactList, Facts, Table, Text
from reports.tables.wording import amount, short_number

_HEAD = (">board", ">residue in the bath", ">refractometer reads", "verdict", "components", ">worst residue")


def bath_card(bath: Bath, liquid: str, limit_pct: float, boards: Sequence[BoardInBath]) -> Card:
    """Show what a board brings and takes along, when the bath is spent, and the boards that were analysed."""
    report = boards[0].report
    origin, water = report.origin, report.rinse_water
    brought, taken = short_number(1e3 * bath.flux_g), short_number(bath.drag_out_ml)
    balance = f"brings {brought} mg of flux, takes {taken} ml of the bath along, which fresh solution makes up"
    begins = "" if bath.begin_pct is None else f"begins with {bath.begin_pct:g} % residue; "
    facts = [("each board", balance), ("bath", begins + change_words(bath, limit_pct)), *_rinse(bath, boards)]
    concentration = report.parameters.liquids[liquid].concentration_pct
    tanks = [] if water is None else [f">{solution}, MΩ·cm" for solution in water.cascade.solutions]
    return Card(
        (
            Text(origin.board, "strong"), " with ", Text(origin.recipe, "strong"),
            f" in a bath of {bath.volume_l:g} l of {liquid}",
        ),
        (
            Text(caveat(report), "quiet"),
            FactList(facts),
            Table.of((*_HEAD, *tanks), [_row(each, concentration) for each in boards]),
        ),
    )  # fmt: skip


def _rinse(bath: Bath, boards: Sequence[BoardInBath]) -> Facts:
    """When the last tank is no longer clean enough, by which limit; nothing where there are no tanks."""
    report = boards[0].report
    if report.rinse_water is None:
        return []
    least, cascade = report.parameters.limits.rinse_warn_mohm, report.rinse_water.cascade
    last, after = cascade.solutions[-1], cascade.boards_until(least, *bath.carried_g_m3)
    if after is None:
        return [("rinse", f"{last} never falls below {least:g} MΩ·cm")]
    return [("rinse", f"{last} falls below {least:g} MΩ·cm after {amount(after, 'board')}")]


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
    worst = max((part.residue for part in report.parts if part.residue is not None), default=None)
    return (
        f"{washed.number:,}",
        f"{washed.residue_pct:.2f} %",
        f"{concentration_pct + washed.residue_pct:.1f} %",  # it takes what is dissolved for agent
        Text(outcome, tone=outcome),
        count_words(report.parts),
        "" if worst is None else f"{100.0 * worst:.2g} %",
        *(short_number(tank.resistivity_mohm_cm) for tank in ([] if water is None else water.tanks)),
    )
