from dataclasses import replace

import pytest
from made_findings import made_finding
from tiny_session import tiny_session

from webui.layers.paths.strokes import stroke_lines
from webui.page.session import Selection
from webui.panels.board.paths import card_html
from webui.theme.html import legend_html


@pytest.fixture
def lines():
    return stroke_lines(tiny_session().run.plan)


def selected(made_by):
    return replace(tiny_session(), selection=Selection(made_by=made_by))


def test_the_card_says_what_the_recipe_asks_for(lines):
    around = next(line for line in lines if line.template == "around")
    html = card_html(selected(around.made_by), lines)
    for fact in (
        "40 mm/s",
        "component perimeter",
        "40 mm",
        "35\N{DEGREE SIGN}",
        "clean, nozzle ring60",
        f"{around.laps}<",
    ):
        assert fact in html
    recipe = (tiny_session().document.file).read_text().splitlines()
    number = int(html.partition("smt-aqueous.yaml, line ")[2].partition("<")[0])
    assert recipe[number - 1].strip().startswith("around:")


def test_without_a_selection_the_card_says_so(lines):
    assert "No stroke is selected" in card_html(tiny_session(), lines)
    assert "No stroke is selected" in card_html(replace(selected(lines[0].made_by), run=None), lines)


def test_findings_of_the_stroke_are_on_its_card_and_escaped(lines):
    session = selected(lines[0].made_by)
    findings = (
        made_finding("odd", "warning", "<b>too & fast</b>", lines[0].made_by),
        made_finding("other", "warning", "elsewhere", "sequence[9]/none"),
    )
    html = card_html(replace(session, run=replace(session.run, findings=findings)), lines)
    assert "&lt;b&gt;too &amp; fast" in html
    assert "elsewhere" not in html


def test_the_legend_escapes_names():
    html = legend_html([("<i>", (1, 2, 3))])
    assert "&lt;i&gt;" in html
    assert "#010203" in html
