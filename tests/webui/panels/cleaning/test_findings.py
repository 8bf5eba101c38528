"""What the analysis found stands among the other findings, as long as it is of the program that is shown."""

from contextlib import contextmanager
from dataclasses import replace

from cleaning_report import small_report
from made_findings import made_finding
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session

from webui.cards.findings import ALL, CLEANING, PLANNING, findings_of, name_findings, place_of
from webui.page.evaluations import Analysed
from webui.panels.results.overview import FindingsPanel

JUDGED = made_finding("r7-residue", "warning", "U1: 31 % of the residue is left.", "sequence[0]", (9.0, 12.0, 0.0))
WIDE = made_finding("r9-change-bath", "info", "process: 5 % of the bath is soil.")
PLANNED = made_finding("speed-below-programmed", "warning", "R1: slower.", "sequence[0]/around/C1")


def analysed_session(findings=(JUDGED, WIDE)):
    session = tiny_session()
    session = replace(session, run=replace(session.run, findings=(PLANNED,)))
    report = replace(small_report(), findings=tuple(findings))
    return replace(session, analysed=Analysed(session.run.program, "default", report))


@contextmanager
def opened(session):
    with small_page(session) as page:
        scene = SmallScene(page)
        panel = FindingsPanel(page, scene)
        page.open()
        yield page, scene, panel
        page.close()


def test_both_sources_are_listed_worst_first_and_apart():
    session = analysed_session()
    assert findings_of(session) == (PLANNED, JUDGED, WIDE)
    assert findings_of(session, PLANNING) == (PLANNED,)
    assert findings_of(session, CLEANING) == (JUDGED, WIDE)
    assert findings_of(replace(session, parameters_name="other")) == (PLANNED,)
    assert findings_of(replace(session, run=None)) == ()


def test_a_judgement_is_about_the_part_that_it_names():
    board = tiny_session().board
    assert place_of(JUDGED, board) == "U1"
    assert place_of(WIDE, board) == ""
    assert place_of(PLANNED, board) == "C1"
    assert list(name_findings([JUDGED, WIDE, PLANNED])) == [
        "1 r7-residue U1",
        "2 r9-change-bath process",
        "3 speed-below-programmed around/C1",
    ]


def test_choosing_a_judgement_flies_there_and_lights_what_sprays_the_part():
    with opened(analysed_session()) as (page, scene, _):
        press(page, "Go to", "2 r7-residue U1")
        assert scene.looked == [((9.0, 12.0, 0.0), 15.0)]
        assert page.session.selection.component == "U1"
        assert set(map(str, page.session.lit)) == {"sequence[0]/around/U1", "sequence[0]/sweep"}
        press(page, "Go to", "1 speed-below-programmed around/C1")
        assert str(page.session.selection.made_by) == "sequence[0]/around/C1"


def test_the_source_can_be_chosen_while_there_is_an_analysis():
    with opened(analysed_session()) as (page, _, panel):
        assert find(page, "Source").visible
        press(page, "Source", CLEANING)
        assert find(page, "Go to").options == ("\N{EN DASH}", "1 r7-residue U1", "2 r9-change-bath process")
        assert "step 1" in panel._list.content
        for name in find(page, "Go to").options[1:]:
            assert f'data-row="{name}"' in panel._list.content
        assert "9.0, 12.0, 0.0 mm" in panel._list.content
        assert "2 warnings, 1 note" in panel._tally.content
        page.remember(lambda session: replace(session, parameters_name="other"))
        assert not find(page, "Source").visible
        assert find(page, "Go to").options == ("\N{EN DASH}", "1 speed-below-programmed around/C1")
        press(page, "Source", ALL)


def test_very_many_findings_are_all_gone_through():
    many = [replace(JUDGED, message=f"X{number}: little.") for number in range(600)]
    with opened(analysed_session(many)) as (page, _, panel):
        assert len(find(page, "Go to").options) == 501
        press(page, "Step", "Previous")
        assert panel._steps.chosen == many[-1]
        press(page, "Step", "Previous")
        assert panel._steps.chosen == many[-2]
