from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import pytest
import viser
from small_page import small_page
from tiny_session import tiny_session

from webui.cards.findings import totals_words
from webui.panels.results import overview as status
from webui.panels.results.overview import StatusPanel
from webui.scene.scene import Scene
from webui.server.server import open_session


def test_what_lasts_no_longer_than_a_moment_is_not_mentioned(monkeypatch: pytest.MonkeyPatch) -> None:
    now_s = [100.0]
    monkeypatch.setattr(status, "time", SimpleNamespace(monotonic=lambda: now_s[0]))
    with small_page(open_session("tiny", "rinse-only")) as page:
        panel = StatusPanel(page, cast(Scene, None))
        page.open()
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


def test_an_edit_is_shown_with_the_time_and_the_liquid_before_it() -> None:
    first = tiny_session()
    assert first.run is not None
    totals = replace(first.run.program.totals, duration_s=7.0)
    edited = replace(first, run=replace(first.run, program=replace(first.run.program, totals=totals)))
    with small_page(first) as page:
        panel = StatusPanel(page, cast(Scene, None))
        page.open()
        html = cast(viser.GuiHtmlHandle, panel._html)
        assert "Before:" not in html.content
        page.show(edited)
        assert f"Before: {totals_words(first.run)}." in html.content
        page.show(replace(edited))
        assert f"Before: {totals_words(first.run)}." in html.content
        page.show(replace(edited, run=replace(edited.run, findings=())))
        assert "Before:" not in html.content  # nothing that is stated has changed
        page.show(edited.with_workpiece("copy", replace(first.board, name="copy")))
        page.show(replace(page.session, run=first.run))
        assert "Before:" not in html.content
        page.close()
