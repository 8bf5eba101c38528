"""Measured cleanliness that was uploaded, and its comparison with the analysis of a session."""

from dataclasses import replace

from boards.board import Board
from cleaning.uncertainty.comparison import Comparison, calibrate_command, compare_measured
from cleaning.uncertainty.measured_table import MeasuredTable, read_measured
from specs.confinement import admit
from specs.temporary import temporary_folder
from webui.page.project import ProjectError
from webui.page.session import Session

_LARGEST_TABLE = 20_000_000


def read_uploaded(name: str, content: bytes, board: Board) -> MeasuredTable:
    """Read an uploaded table of measured cleanliness, which is not stored.

    Raises:
        ProjectError: it is too large.
        CleaningError: it cannot be used; the message names the line.
    """
    if len(content) > _LARGEST_TABLE:
        raise ProjectError(f"{name[:40]!r}: {len(content) / 1e6:.0f} MB are too many for a table of measurements.")
    with temporary_folder() as folder:
        table = folder / "measured.csv"
        table.write_bytes(content)
        with admit(table):
            read = read_measured(table, [*(each.name for each in board.components), "board"])
    return replace(read, file=name)


def comparison_of(session: Session) -> tuple[Comparison, list[str]] | None:
    """Compare the measurements with the analysis, if there are both; with the command for each recalibration."""
    analysis, table = session.analysis, session.measured
    if analysis is None or table is None:
        return None
    found, recipe = compare_measured(analysis.report, table), session.document.file.name
    commands = [
        calibrate_command(each, analysis.report, recipe, analysis.parameters_name) for each in found.recalibrations
    ]
    return found, commands
