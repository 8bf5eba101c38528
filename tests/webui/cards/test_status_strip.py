"""The strip states what is known of the program that is shown, and nothing that is older without a word."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any, cast

import pytest
from cleaning_report import small_report
from hypothesis import given, settings
from hypothesis import strategies as st
from made_findings import made_finding
from tiny_session import tiny_session

from cleaning.verdicts.results import Part
from cleaning.verdicts.rules import UNDER_EXPOSED
from reports.tables.wording import clock
from rulesengine.planning.pipeline import Run, run
from webui.cards.findings import status_cells, status_html
from webui.page.evaluations import Analysed, Checked
from webui.page.session import Session
from webui.panels.recipe.recipe import mask_part
from webui.server.server import open_session

SPEEDS = (35, 45)
KNOWN = ("good", "warning", "error")


@pytest.fixture(scope="module")
def fresh() -> Session:
    return open_session("smt-demo", "rinse-only")


@pytest.fixture(scope="module")
def planned(fresh: Session) -> Session:
    return replace(fresh, run=run(fresh.recipe, fresh.board))


def edited(session: Session) -> Session:
    name = session.recipe.sequence[0].paths[0]
    return session.set_value(("templates", name, "speed_mm_s"), 31)


def cells_of(session: Session) -> dict[str, tuple[str, str]]:
    return {cell.title: (cell.text, cell.tone) for cell in status_cells(session)}


@pytest.mark.slow
def test_a_planned_recipe_says_how_long_it_takes_and_what_it_needs(planned: Session) -> None:
    assert planned.run is not None
    html = status_html(planned, 0.312, "done", 1.0)
    litres = sum(amount for _, amount in planned.run.program.totals.liquid_l)
    assert "Planned in 0.31 s" in html
    assert f"{litres:.1f} l" in html
    assert cells_of(planned)["Findings"] == ("no warnings", "good")
    assert cells_of(replace(planned, run=replace(planned.run, findings=())))["Findings"] == ("none", "good")


def test_while_it_is_planned_it_says_how_far_that_is(fresh: Session) -> None:
    assert "Planning rinse\N{HORIZONTAL ELLIPSIS} 40%" in status_html(fresh, None, "planning rinse", 0.4)


def test_an_edit_that_is_not_planned_never_looks_planned(planned: Session) -> None:
    html = status_html(edited(planned), 0.312, "timing", 0.6)
    assert "Planned" not in html
    assert "Timing" in html


@pytest.mark.parametrize("what", ["cancelled", "not planned"])
def test_what_is_stopped_says_that_the_paths_are_older(planned: Session, fresh: Session, what: str) -> None:
    assert "recipe before" in status_html(edited(planned), 0.3, what, 1.0)
    assert "recipe before" not in status_html(fresh, None, what, 1.0)


def test_a_sketch_says_that_its_order_is_being_refined(planned: Session) -> None:
    assert planned.run is not None
    session = replace(edited(planned), sketch=planned.run.plan)
    assert "Refining the order\N{HORIZONTAL ELLIPSIS} 30%" in status_html(session, 0.3, "planning dry", 0.3)
    assert "Refining" not in status_html(edited(planned), 0.3, "planning dry", 0.3)


def test_errors_are_in_sight(planned: Session) -> None:
    assert planned.run is not None
    findings = (made_finding("a", "error", ""), made_finding("b", "warning", ""), made_finding("b", "warning", ""))
    session = replace(planned, run=replace(planned.run, findings=findings))
    assert cells_of(session)["Findings"] == ("1 error", "error")
    assert "2 warnings" in status_html(session, 0.3, "done", 1.0)


@pytest.mark.slow
def test_components_of_a_side_that_nothing_sprays_are_an_error() -> None:
    session = open_session("two-sided", "smt-aqueous")
    document = session.document
    steps = [index for index, step in enumerate(session.recipe.sequence) if step.side == "bottom"]
    for index in reversed(steps):
        session = session.remove(("sequence", index))
    assert session.document is not document
    session = replace(session, run=run(session.recipe, session.board))
    top = sum(each.side == "top" for each in session.board.components)
    assert cells_of(session)["Sprayed"] == (f"{top} of {len(session.board.components)}", "error")
    assert "not on the bottom" in status_html(session, 0.3, "done", 1.0)


@pytest.mark.slow
def test_a_component_that_is_avoided_is_not_counted_as_sprayed() -> None:
    begun = tiny_session()
    session = mask_part(begun, begun.board.components[0].name, "avoid")
    session = replace(session, run=run(session.recipe, session.board))
    count = len(session.board.components)
    assert cells_of(begun)["Sprayed"] == (f"{count} of {count}", "good")
    assert cells_of(session)["Sprayed"] == (f"{count - 1} of {count}", "good")
    assert "1 avoided" in status_html(session, 0.3, "done", 1.0)


def test_cleaning_is_counted_as_in_its_tab_and_the_bare_board_named_where_it_alone_is_worse() -> None:
    def shown(*parts: Part, bare: Part) -> tuple[str, str]:
        analysed = Analysed(begun.planned_run.program, begun.parameters_name, replace(report, parts=parts, bare=bare))
        return cells_of(replace(begun, analysed=analysed))["Cleaning"]

    begun, report = tiny_session(), small_report()
    by_verdict = {part.verdict: part for part in report.parts}
    clean, dirty = by_verdict["clean"], by_verdict["dirty"]
    avoided = replace(clean, verdict="avoided", judgements=(replace(clean.judgements[0], verdict="avoided"),))
    assert shown(dirty, clean, bare=dirty) == ("1 dirty", "error")
    assert shown(clean, clean, bare=dirty) == ("board dirty", "error")
    assert shown(clean, avoided, bare=clean) == ("all clean", "good")
    assert shown(by_verdict["marginal"], avoided, bare=clean) == ("1 marginal", "warning")


def test_unsaved_changes_are_marked(planned: Session) -> None:
    assert "\N{BULLET}" in status_html(edited(planned), 0.3, "timing", 0.6)
    assert "\N{BULLET}" not in status_html(planned, 0.3, "done", 1.0)


def test_names_cannot_become_markup(planned: Session) -> None:
    nasty = replace(planned, workpiece=replace(planned.board, name="<img src=x>"))
    assert "<img" not in status_html(nasty, None, "", 0.0)


@cache
def at_speed(speed: int) -> Session:
    session = tiny_session().set_value(("templates", "around", "speed_mm_s"), speed)
    return replace(session, run=run(session.recipe, session.board))


def checked(of: Run, cell: Any) -> Checked:
    report = SimpleNamespace(program=of.program, findings=())
    return Checked(of, cell, cast(Any, report), cast(Any, object()))


def analysed(of: Run) -> Analysed:
    part = SimpleNamespace(judgements=(SimpleNamespace(rule=UNDER_EXPOSED, verdict="clean"),))
    report = SimpleNamespace(parts=(part,), bare=part, process=(), findings=())
    return Analysed(of.program, "default", cast(Any, report))


def test_once_the_robot_was_checked_the_time_is_that_of_its_motion(planned: Session) -> None:
    run = planned.run
    assert run is not None
    totals = replace(run.program.totals, duration_s=run.program.totals.duration_s + 60.0)
    slower = replace(run, program=replace(run.program, totals=totals))
    cell = cast(Any, object())
    session = replace(planned, cell=cell, cell_name="a", checked=replace(checked(slower, cell), run=run))
    total = status_html(session, 0.3, "done", 1.0).partition("data-total")[2].partition("</div>")[0]
    assert total.endswith(clock(run.program.totals.duration_s + 60.0))
    assert f"planned {clock(run.program.totals.duration_s)}" in total
    assert "before the edit" in status_html(edited(session), 0.3, "timing", 0.6)
    assert "; planned" not in status_html(planned, 0.3, "done", 1.0)


@pytest.mark.slow
@settings(max_examples=200)
@given(st.lists(st.sampled_from(("edit", "plan", "check", "analyse", "cell", "parameters")), max_size=14))
def test_no_cell_is_ever_older_than_it_states(events: list[str]) -> None:
    """A model beside the session: which speed is written, planned, checked in which cell, analysed with which set."""
    session = replace(at_speed(SPEEDS[0]), run=None, cell_name="a", cell=cast(Any, object()))
    written, cell, values = SPEEDS[0], 0, "default"
    done: dict[str, Any] = {}
    for event in events:
        if event == "edit":
            written = SPEEDS[1] if written == SPEEDS[0] else SPEEDS[0]
            session = session.set_value(("templates", "around", "speed_mm_s"), written)
        elif event == "plan":
            session, done["run"] = replace(session, run=at_speed(written).run), written
        elif event == "cell":
            session, cell = replace(session, cell=cast(Any, object())), cell + 1
        elif event == "parameters":
            values = "aged" if values == "default" else "default"
            session = replace(session, parameters_name=values)
        elif event == "check" and session.planned and session.run is not None:
            session, done["check"] = replace(session, checked=checked(session.run, session.cell)), (written, cell)
        elif event == "analyse" and session.planned and session.run is not None:
            session = replace(session, analysed=replace(analysed(session.run), parameters_name=values))
            done["analysis"] = (written, values)
        cells = cells_of(session)
        if "run" not in done:
            assert cells == {}
            continue
        current = done["run"] == written
        assert (cells["Sprayed"][1] in KNOWN) == current
        assert (cells["Findings"][1] in KNOWN) == current
        assert (cells["Robot"][1] in KNOWN) == (current and done.get("check") == (written, cell))
        assert (cells["Cleaning"][1] in KNOWN) == (current and done.get("analysis") == (written, values))
        assert ("before the edit" in status_html(session, None, "timing", 0.5)) == (not current)
