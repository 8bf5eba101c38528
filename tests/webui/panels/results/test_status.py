from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest
import viser
from made_findings import made_finding
from small_page import small_page

from rulesengine.planning.pipeline import run
from webui.page.session import Session
from webui.panels.results import status
from webui.panels.results.status import StatusPanel, status_html
from webui.scene.scene import Scene
from webui.server.server import open_session


@pytest.fixture(scope="module")
def fresh() -> Session:
    return open_session("smt-demo", "rinse-only")


@pytest.fixture(scope="module")
def planned(fresh: Session) -> Session:
    return replace(fresh, run=run(fresh.recipe, fresh.board))


def edited(session: Session) -> Session:
    name = session.recipe.sequence[0].paths[0]
    return session.set_value(("templates", name, "speed_mm_s"), 31)


def test_a_planned_recipe_says_how_long_it_takes_and_what_it_needs(planned: Session) -> None:
    assert planned.run is not None
    html = status_html(planned, 0.312, "done", 1.0)
    litres = sum(amount for _, amount in planned.run.program.totals.liquid_l)
    assert "Planned in 0.31 s" in html
    assert f"{litres:.1f} l" in html
    assert "No errors or warnings" in html


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
    html = status_html(replace(planned, run=replace(planned.run, findings=findings)), 0.3, "done", 1.0)
    assert "1 error, 2 warnings" in html


def test_unsaved_changes_are_marked(planned: Session) -> None:
    assert "\N{BULLET}" in status_html(edited(planned), 0.3, "timing", 0.6)
    assert "\N{BULLET}" not in status_html(planned, 0.3, "done", 1.0)


def test_names_cannot_become_markup(planned: Session) -> None:
    nasty = replace(planned, board=replace(planned.board, name="<img src=x>"))
    assert "<img" not in status_html(nasty, None, "", 0.0)


def test_what_lasts_no_longer_than_a_moment_is_not_mentioned(planned: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(status, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    with small_page(edited(planned)) as page:
        panel = StatusPanel(page, cast(Scene, None))
        page.open([panel])
        html = cast(viser.GuiHtmlHandle, panel._html)

        def told(after_s: float, what: str, share: float) -> str:
            now_s[0] += after_s
            page._report_progress(what, share)
            return html.content

        assert "Planning\N{HORIZONTAL ELLIPSIS} 0%" in told(0.0, "planning", 0.0)
        assert "Planning\N{HORIZONTAL ELLIPSIS} 0%" in told(0.03, "planning rinse", 0.1)
        assert "Refining\N{HORIZONTAL ELLIPSIS} 20%" in told(0.08, "refining", 0.2)
        assert "20%" in told(0.02, "refining", 0.25)
        assert "30%" in told(0.09, "refining", 0.3)
        assert "Timing\N{HORIZONTAL ELLIPSIS} 60%" in told(0.01, "timing", 0.6)
        assert "Cancelled" in told(0.01, "cancelled", 1.0)
        assert "Planning" in told(0.01, "planning", 0.0)
        page.close()
