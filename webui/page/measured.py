"""Measured cleanliness that was uploaded, and its comparison with the analysis of a session."""

from dataclasses import replace

from boards.board import Board
from cleaning.uncertainty.comparison import Comparison, calibrate_command, compare_measured
from cleaning.uncertainty.measured_table import MeasuredTable, read_measured
from webui.page.project import uploaded_table
from webui.page.session import Session


def read_uploaded(name: str, content: bytes, board: Board) -> MeasuredTable:
    """Read an uploaded table of measured cleanliness, which is not stored.

    Raises:
        ProjectError: it is too large.
        CleaningError: it cannot be used; the message names the line.
    """
    with uploaded_table(name, content, "measured.csv", "a table of measurements") as table:
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
