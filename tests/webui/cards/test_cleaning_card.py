"""What is written of a report: no name can break the page, nothing is left out silently."""

from dataclasses import replace

from cleaning_report import WET, small_report, soaked_report

from reports.cards.cleaning import cleaned_component_card, headline_card, judgement_note, stage_names
from webui.cards.workpiece_card import parts_html
from webui.theme.html import MOST_ROWS, blocks_html, card_html
from webui.theme.palette import VERDICT_COLOURS, to_hex

REPORT = small_report()
U1 = next(part for part in REPORT.parts if part.component == "U1")


def part_html(report, part):
    return card_html(cleaned_component_card(report, part))


def headline_html(report):
    return card_html(headline_card(report, "as planned"))


def u1(**changes):
    return part_html(REPORT, replace(U1, **changes))


def test_names_of_the_board_are_text():
    odd = replace(U1, component="<b>U1</b>", makers=(("<i>x</i>", 1.0),))
    for html in (parts_html([odd], ""), part_html(REPORT, odd)):
        assert "<b>U1" not in html
        assert "<i>x" not in html
        assert "&lt;b&gt;U1" in html


def test_the_selected_part_is_marked():
    assert parts_html(REPORT.worst_first(), "R1").count("box-shadow") == 1
    assert "box-shadow" not in parts_html(REPORT.worst_first(), "")


def test_what_is_clean_and_stays_wet_is_called_so():
    report = soaked_report()
    told = {part.component: (parts_html([part], ""), part_html(report, part)) for part in report.parts}
    assert "</span> clean, wet<" in told["C1"][0]
    assert "Clean, wet underneath" in told["C1"][1]
    assert "clean, wet" not in told["R1"][0]
    assert "Marginal" in told["R1"][1]


def test_the_headline_has_the_colour_of_what_it_says():
    clean = tuple(part for part in soaked_report().parts if part.component in ("C1", "R2"))
    colours = {
        outcome: to_hex(VERDICT_COLOURS[outcome]) in headline_html(report)
        for outcome, report in (
            ("dirty", REPORT), ("clean, wet", replace(REPORT, parts=clean, verdict="marginal")),
        )
    }  # fmt: skip
    assert all(colours.values()), colours


def test_the_rule_that_decides_is_told_first_although_the_part_stays_wet_too():
    j1 = next(part for part in REPORT.parts if part.component == "J1")
    both = replace(j1, judgements=(WET, *j1.judgements), verdict="marginal", grade="B")
    html = part_html(REPORT, both)
    assert html.index("R14 model limit") < html.index("R12 wet under part")
    assert "grade A</span></div>" in html
    assert ">model limit<" in parts_html([both], "")


def test_a_long_list_says_how_many_more_there_are():
    many = [replace(U1, component=f"U{n}") for n in range(MOST_ROWS + 7)]
    assert "and 7 better ones" in parts_html(many, "")


def test_every_judgement_of_a_part_is_written_with_its_stage():
    part = U1
    html = part_html(REPORT, part)
    for judgement in part.judgements:
        assert judgement.because in html
        assert judgement.advice in html
        assert f"{judgement.rule} {judgement.name}" in html
    assert "1 clean" in html
    assert stage_names(REPORT.stages) == ("1 clean", "2 rinse")


def test_what_is_wrong_with_the_process_stands_in_the_headline():
    assert "R9" not in headline_html(REPORT)  # it is clean
    bad = replace(REPORT, process=(replace(REPORT.process[0], verdict="dirty", advice="Change the bath."),))
    assert "Change the bath." in headline_html(bad)


def test_calibrated_kinetics_are_still_predicted():
    known = REPORT.parameters.provenance | {
        f"soil.{name}": REPORT.parameters.known("soil").model_copy(update={"known": "calibrated"})
        for name in ("k1_per_s", "k_m_per_s")
    }
    fitted = replace(REPORT, parameters=REPORT.parameters.model_copy(update={"provenance": known}))
    assert "uncalibrated" in headline_html(REPORT)
    assert "uncalibrated" not in headline_html(fitted)
    assert "SIR" in headline_html(fitted)


def test_the_factor_that_limits_most_comes_first_and_is_longest():
    html = u1(elasticity={"pressure": -0.4, "time": -2.0}, limiting="time")
    assert html.index(">time<") < html.index(">pressure<")
    assert "width:100%" in html
    assert "width:20%" in html
    assert "What limits it" in html
    assert "What limits it" not in u1(elasticity={}, limiting="")
    assert "+0.00 %" in u1(elasticity={"time": 0.0}, limiting="")


def test_a_stage_on_the_other_side_says_so():
    html = u1(exposed=(None, U1.exposed[1]))
    assert "other side" in html
    assert "5.50 mm" in html


def test_many_makers_are_counted():
    assert "and 6 more" in u1(makers=tuple((f"sequence[0]/around/U{n}", 1 / 12) for n in range(12)))
    assert "more<" not in u1(makers=tuple((f"sequence[0]/around/U{n}", 1 / 6) for n in range(6)))
    assert "nothing" in u1(makers=())


def test_the_card_marks_a_verdict_by_kinetics_that_nothing_fitted_once():
    assert u1().count("uncalibrated") == 1
    fitted = tuple(replace(each, calibrated=True) for each in U1.judgements)
    assert "uncalibrated" not in u1(judgements=fitted)


def test_numbers_stand_beside_their_limits():
    html = blocks_html([judgement_note(U1.judgements[0], "")])
    assert "residue 31 % (limit 20)" in html
    assert "grade C" in html
