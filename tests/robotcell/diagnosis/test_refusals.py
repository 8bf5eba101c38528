"""Cells that no motion can do are refused by cheap rules, before any search, with the cause and the edit that helps."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hostile_cells import KINDS, hostile_text, read_text
from tracked import line_program

import robotcell.track
from boards.board import Board
from boards.load import board_library, load_board
from robotcell.cell.cell import Cell
from robotcell.cell.cell_edits import CellEdit, apply_edits
from robotcell.cell.load import LoadedCell, hold_board
from robotcell.diagnosis.reasons import PathInCell
from robotcell.diagnosis.refusals import find_refusal
from robotcell.motion.cell_queries import CellQueries, build_queries
from robotcell.motion.plan_joints import OutOfReach, plan_motion
from robotcell.motion.sampled_path import sample_path
from robotcell.track import CellReport, terms_of, track
from specs.progress import no_progress

MENDED = [(name, kind) for name in ("kr6-bench", "gantry") for kind in KINDS]
MENDED = [each for each in MENDED if each != ("gantry", "shadow")]
MENDED += [(name, kind) for name in ("ur5e-bench", "irb1200-bench") for kind in ("shadow", "post", "tight")]
MENDED += [("lrmate-bench", "tight"), ("cairo-bench", "shadow")]
"""A gantry has no shadow."""
CAUSES = {
    "far": ("board-out-of-reach", "mm from the first joint"),
    "long-tool": ("out-of-reach", "out of the robot's reach"),
    "tight": ("joint-limit", "beyond a joint's limit: wrist_1 by"),
    "upside-down": ("board-upside-down", "top faces down"),
    "table-through-base": ("collision", "collides with table"),
    "shadow": ("out-of-reach", "out of the robot's reach"),
    "post": ("collision", "collides with post"),
}
REMEDIES = {
    "far": "board moved by -",
    "long-tool": "mm shorter",
    "tight": "limits of wrist_1 from",
    "upside-down": "turned over",
    "table-through-base": "table moved by -",
    "shadow": "board moved by",
    "post": "moved by",
}


@cache
def board() -> Board:
    return load_board(board_library()["tiny"])


def checked(loaded: LoadedCell) -> CellReport:
    return track(line_program(), loaded.cell, board(), terms=terms_of(loaded))


def hostile(name: str, kind: str) -> LoadedCell:
    return hold_board(read_text(hostile_text(name, kind)), board())


def errors(report: CellReport) -> list[str]:
    return [finding.message for finding in report.findings if finding.severity == "error"]


def _mark(kind: str) -> Any:
    """Remedies that have to be tried, one after the other, take seconds."""
    return kind if kind in ("far", "shadow") else pytest.param(kind, marks=pytest.mark.slow)


@pytest.fixture
def searched(monkeypatch: pytest.MonkeyPatch) -> list[Cell]:
    """Cells in which a motion is searched."""
    found: list[Cell] = []

    def search(queries: CellQueries, *rest: Any) -> Any:
        found.append(queries.cell)
        return plan_motion(queries, *rest)

    monkeypatch.setattr(robotcell.track, "plan_motion", search)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("kind", [_mark(kind) for kind in KINDS if kind != "post"])
def test_a_hostile_cell_is_refused_without_a_search_with_cause_and_remedy_by_name(
    kind: str, searched: list[Cell]
) -> None:
    loaded = hostile("ur5e-bench", kind)
    report = checked(loaded)
    assert all(cell is not loaded.cell for cell in searched)
    assert searched, "the remedy is proven"
    found = {(finding.rule.id, finding.message) for finding in report.findings if finding.severity == "error"}
    rule, words = CAUSES[kind]
    assert any(each == rule and words in message for each, message in found), found
    (remedy,) = [finding.message for finding in report.findings if finding.rule.id == "cell-remedy"]
    assert REMEDIES[kind] in remedy
    assert "Write in the cell: " in remedy


@pytest.mark.slow
def test_no_remedy_is_offered_that_the_whole_check_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robotcell.track, "_is_possible", lambda *_: False)
    report = checked(hostile("ur5e-bench", "upside-down"))
    assert report.remedy is None
    (advice,) = [finding.message for finding in report.findings if finding.rule.id == "cell-remedy"]
    assert "no single change was found" in advice
    assert "turned over" in advice  # the mistake is named all the same


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), MENDED)
def test_the_edit_that_is_named_makes_the_program_possible(name: str, kind: str) -> None:
    text = hostile_text(name, kind)
    report = checked(hold_board(read_text(text), board()))
    assert errors(report)
    assert kind != "post" or any("collides with post" in each for each in errors(report))
    assert report.remedy is not None
    mended = apply_edits(text, report.remedy.edits, Path(name))
    assert errors(checked(hold_board(read_text(mended), board()))) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["kr6-bench", "ur5e-bench"])
def test_what_the_rules_refuse_no_search_can_do(name: str) -> None:
    """Places from well within reach to well beyond it: the rules refuse only where the search finds nothing."""
    program, refused, done = line_program(), 0, 0
    for x in (-200.0, 100.0, 250.0, 400.0, 550.0, 650.0, 800.0):
        text = apply_edits(hostile_text(name, "far"), [_at(x)], Path(name))
        loaded = hold_board(read_text(text), board())
        path = sample_path(program, loaded.cell, loaded.round_nozzles, {})
        queries = build_queries(program, loaded.cell, board(), [loaded.cell.T_cell_board])
        refusal = find_refusal(PathInCell(queries, path), 0.0)
        motion = plan_motion(queries, path, 0.0, no_progress)
        flawless = not isinstance(motion, OutOfReach) and not any(
            len(each) for each in (motion.hits, motion.lost, motion.discontinuities, motion.blocked)
        )
        assert refusal is None or not flawless
        refused, done = refused + (refusal is not None), done + flawless
    assert refused
    assert done


@pytest.mark.slow
def test_of_two_tools_only_the_long_one_is_shortened() -> None:
    text = apply_edits(hostile_text("ur5e-bench", "far"), [_at(400), _orifice(620)], Path("ur5e-bench"))
    report = checked(hold_board(read_text(text), board()))
    assert report.remedy is not None
    assert report.remedy.text.startswith("with tool 1 (cone) ")
    assert report.remedy.text.endswith(" mm shorter")


@pytest.mark.slow
def test_a_table_that_is_above_the_base_goes_back_under_it() -> None:
    """The least move that helps is a quarter of it, upwards; nobody stands a robot under a table."""
    raised = CellEdit(("fixtures", "table", "at", "xyz_mm"), [350, 0, 380])
    text = apply_edits(hostile_text("ur5e-bench", "far"), [_at(400), raised], Path("ur5e-bench"))
    report = checked(hold_board(read_text(text), board()))
    assert report.remedy is not None
    assert [str(edit) for edit in report.remedy.edits] == ["fixtures.table.at.xyz_mm: [350, 0, -20]"]


def _orifice(z: float) -> CellEdit:
    return CellEdit(("tools", "1", "tcp"), {"xyz_mm": [0, 0, z]})


def _at(x: float) -> CellEdit:
    return CellEdit(("board", "pose", "xyz_mm"), [x, -50, 250])


@pytest.mark.slow
def test_a_fixture_inside_the_base_is_refused_and_one_that_carries_it_is_not() -> None:
    text = hostile_text("kr6-bench", "far")
    for z, through in ((-20, False), (-5, False), (150, True)):
        moved = text.replace("at: {xyz_mm: [350, 0, -20]}", f"at: {{xyz_mm: [350, 0, {z}]}}")
        report = checked(hold_board(read_text(moved), board()))
        messages = [finding.message for finding in report.findings if finding.rule.id == "fixture-in-base"]
        assert bool(messages) is through
        assert all("reaches more than 20 mm into the robot's base" in message for message in messages)
