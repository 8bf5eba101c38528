import pytest
from made_findings import made_finding

from boards.board import Board
from recipes.load import LoadedRecipe
from reports.tables.wording import tally
from webui.cards.findings import ALL, choose_findings, findings_html, name_findings, place_of
from webui.server.server import open_session

ERROR = made_finding("not-served", "error", "U1 must be cleaned.", "masks")
SLOW = made_finding("speed-below-programmed", "warning", "Slower.", "sequence[0]/around/U12", (1.0, 2.0, 3.0))
NOTE = made_finding("order-gain", "info", "Order of 34 strokes.", "sequence[0]/around")


@pytest.fixture(scope="module")
def board() -> Board:
    return open_session("smt-demo", "smt-aqueous").board


@pytest.fixture(scope="module")
def loaded() -> LoadedRecipe:
    return open_session("smt-demo", "smt-aqueous").loaded


def test_filters_keep_the_order() -> None:
    findings = [ERROR, SLOW, NOTE, SLOW]
    assert choose_findings(findings, ALL, ALL) == findings
    assert choose_findings(findings, "Warnings", ALL) == [SLOW, SLOW]
    assert choose_findings(findings, ALL, "order-gain") == [NOTE]
    assert choose_findings(findings, "Errors", "order-gain") == []


def test_every_finding_has_a_name_of_its_own_even_if_two_say_the_same() -> None:
    names = name_findings([ERROR, SLOW, SLOW, NOTE])
    assert list(names) == [
        "1 not-served masks",
        "2 speed-below-programmed around/U12",
        "3 speed-below-programmed around/U12",
        "4 order-gain around",
    ]


@pytest.mark.slow
def test_a_finding_about_one_component_names_it(board: Board) -> None:
    assert place_of(SLOW, board) == "U12"
    assert place_of(NOTE, board) == ""
    assert place_of(made_finding("x", "info", "", "sequence[0]/around/U12+C1"), board) == ""
    assert place_of(made_finding("x", "info", "", "sequence[0]/around/NOBODY"), board) == ""


@pytest.mark.slow
def test_the_list_says_what_was_seen_where_and_which_line_asked_for_it(loaded: LoadedRecipe) -> None:
    html = findings_html([ERROR, SLOW], loaded, SLOW)
    line = loaded.root.at(("templates", "around")).mark.line
    assert html.index("not-served") < html.index("speed-below-programmed")
    assert f"smt-aqueous.yaml, line {line}" in html
    assert "1.0, 2.0, 3.0 mm" in html


def test_only_the_chosen_one_is_marked(loaded: LoadedRecipe) -> None:
    plain = findings_html([ERROR, SLOW], loaded, None)
    marked = findings_html([ERROR, SLOW], loaded, SLOW)
    assert plain != marked
    assert marked.count("#e6f1f8") == 1


def test_what_files_say_cannot_become_markup(loaded: LoadedRecipe) -> None:
    nasty = made_finding("<b>rule", "error", "<script>alert(1)</script>", "sequence[0]/<i>")
    html = findings_html([nasty], loaded, None)
    assert "<script>" not in html
    assert "<i>" not in html
    assert "&lt;b&gt;rule" in html


def test_long_lists_say_how_many_more_there_are(loaded: LoadedRecipe) -> None:
    assert "and 40 more" in findings_html([NOTE] * 100, loaded, None)
    assert "more;" not in findings_html([NOTE] * 3, loaded, None)
    assert "Nothing" in findings_html([], loaded, None)


def test_the_tally_counts_by_severity_worst_first() -> None:
    assert tally([NOTE, ERROR, SLOW, NOTE]) == "1 error, 1 warning, 2 notes"
    assert tally([]) == "no findings"
