"""The components that a program cleans, as a table."""

from collections.abc import Sequence

from cleaning.verdicts.results import Part, deciding_judgement, outcome
from reports.tables.table import Column, Table, Text
from webui.theme.html import listing_html, quiet_html

_COLUMNS = (
    Column("part", width="18%"),
    Column("verdict", width="28%"),
    Column("because", width="34%"),
    Column("residue", "right", width="20%"),
)


def parts_html(parts: Sequence[Part], selected: str) -> str:
    """The parts as a table, the selected one marked."""
    if not parts:
        return quiet_html("The board has no parts.")
    rows = [
        (
            part.component, Text(outcome(part), tone=outcome(part)), deciding_judgement(part).name,
            "" if part.residue is None else f"{100 * part.residue:.1f} %",
        )
        for part in parts
    ]  # fmt: skip
    return listing_html(Table(_COLUMNS, tuple(rows)), selected, height="26vh", more="better ones")
