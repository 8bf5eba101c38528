import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from cleaning_report import small_report

from cleaning.parameters.model import Provenance
from cleaning.report import Traceability
from cleaning.verdicts.results import CleaningReport, Judgement, Number, Part
from cleaning.verdicts.rules import MISSED, RULES, UNDER_EXPOSED, VERDICTS, WET_GAP
from cleaning.verify import Verified
from reports.html import cleaning_page as cleaning_page_module
from reports.html.cleaning_page import MOST_DESCRIBED, cleaning_page, components_html, head_html
from reports.html.page import table_html
from reports.pictures.cleaning_pictures import VERDICT_COLOURS
from reports.pictures.sheet import Picture
from reports.tables.cleaning_tables import (
    assumptions_table,
    caveat,
    gap_table,
    headline,
    remarks,
    renewals,
    surplus_words,
)
from reports.tables.wording import number_text, short_number

VOID = {"meta", "img", "br", "link"}


class Reader(HTMLParser):
    """Counts what is open, and keeps every place that a browser would fetch."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in VOID:
            self.open.append(tag)
        self.fetched += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def u1_of(report: CleaningReport) -> Part:
    return next(part for part in report.parts if part.component == "U1")


def with_u1(report: CleaningReport, changed: Part) -> CleaningReport:
    """Put a changed U1 in its place."""
    return replace(report, parts=tuple(changed if part.component == "U1" else part for part in report.parts))


@pytest.fixture(scope="module")
def page() -> str:
    return cleaning_page(small_report(), Traceability(serial="A <7>", bath_c="61"))


@pytest.mark.slow
def test_the_page_is_whole_and_fetches_nothing(page: str) -> None:
    reader = Reader()
    reader.feed(page)
    assert reader.open == []
    assert len(reader.fetched) >= 6
    assert all(place.startswith("data:image/") for place in reader.fetched)
    assert "url(" not in page
    assert "@import" not in page


@pytest.mark.slow
def test_the_same_report_gives_the_same_bytes_without_a_clock(page: str) -> None:
    assert cleaning_page(small_report(), Traceability(serial="A <7>", bath_c="61")) == page
    visible = re.sub(r'src="[^"]*"', "", page)
    assert not re.search(r"20\d\d-\d\d-\d\d", visible)


@pytest.mark.slow
def test_the_page_says_what_it_is_worth_and_never_that_a_standard_is_met(page: str) -> None:
    assert "Predicted: 1 of 5 components dirty" in page
    assert "uncalibrated" in page
    assert "SIR" in page
    assert "J-STD" not in page
    assert "IPC" not in page


@pytest.mark.slow
def test_the_page_has_the_hashes_the_entries_and_every_assumption(page: str) -> None:
    report = small_report()
    for sha in (report.origin.board_sha256, report.origin.recipe_sha256, report.parameters_sha256):
        assert sha in page
    assert "A &lt;7&gt;" in page
    assert "<b>&nbsp;</b>" in page, "what was not given is a blank to fill in"
    assert "soil.k1_per_s" in page
    assert all(f"<td>{rule.id}</td>" in page for rule in RULES)


def test_names_cannot_become_markup() -> None:
    report = small_report()
    wicked = replace(u1_of(report).judgements[0], because="<script>alert(1)</script>", advice="<b>x")
    part = replace(u1_of(report), judgements=(wicked,))
    told = components_html(with_u1(report, part))
    assert "<script" not in told
    assert "<b>x" not in told
    assert "&lt;script&gt;" in told


def only(verdict: str) -> list[Part]:
    return [part for part in small_report().parts if part.verdict == verdict]


def test_the_headline_is_about_the_worst_and_not_an_average() -> None:
    report = small_report()
    clean = replace(report, parts=tuple(only("clean")), verdict="clean")
    assert headline(clean) == "Predicted: all of 2 components clean"
    near = replace(report.process[0], verdict="marginal")
    assert headline(replace(clean, process=(near,))) == "Predicted: marginal, for the process or the bare board"
    unknown = tuple(part for part in report.parts if part.verdict in ("no verdict", "clean"))
    assert headline(replace(report, parts=unknown)) == "Predicted: 1 of 3 components without verdict"
    assert headline(replace(report, parts=())) == "Predicted: no components to judge"


def test_calibration_and_made_up_data_are_said() -> None:
    report = small_report()
    fitted = {f"soil.{name}": Provenance(known="calibrated", source="coupons") for name in ("k1_per_s", "k_m_per_s")}
    known = {**report.parameters.provenance, **fitted}
    assert "uncalibrated" not in caveat(
        replace(report, parameters=report.parameters.model_copy(update={"provenance": known}))
    )
    made_up = {**known, "film": Provenance(known="synthetic", source="demo")}
    told = caveat(replace(report, parameters=report.parameters.model_copy(update={"provenance": made_up})))
    assert "made-up" in told


@pytest.mark.slow
def test_a_board_whose_parts_are_all_clean_still_has_a_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cleaning_page_module.pictures, "draw_exposures", lambda _: [])
    report = small_report()
    parts = tuple(replace(part, verdict="clean", gaps=(), underside=None, elasticity={}) for part in report.parts)
    page = cleaning_page(replace(report, parts=parts, verdict="clean"), Traceability())
    assert "Predicted clean (5):" in page
    assert "Under the worst parts" not in page


WET = Judgement(rule=WET_GAP, verdict="marginal", because="Drying clears no gap here.", advice="Bake it.")


def wet(part: Part) -> Part:
    verdict = part.verdict if part.verdict != "clean" else "marginal"
    judgements = tuple(sorted((*part.judgements, WET), key=lambda each: VERDICTS.index(each.verdict)))
    return replace(part, verdict=verdict, judgements=judgements)


def test_what_stays_wet_does_not_hide_what_is_clean() -> None:
    report = small_report()
    clean = tuple(map(wet, only("clean")))
    soaked = replace(report, parts=clean, verdict="marginal")
    assert headline(soaked) == "Predicted: all of 2 components clean; 2 stay wet underneath"
    told = head_html(soaked)
    assert "<b>2</b><span>predicted to be clean</span>" in told
    assert "<b>2</b><span>stay wet underneath: bake, or blow harder</span>" in told
    assert "near a limit" not in told
    one = with_u1(report, wet(u1_of(report)))
    assert "Predicted clean and dry (2):" in components_html(one)
    assert headline(one) == "Predicted: 1 of 5 components dirty; 1 stays wet underneath"
    assert "R12 wet under part" in components_html(soaked)
    assert "</span>clean, wet<" in components_html(soaked)
    assert "</span>marginal<" not in components_html(soaked)
    assert "</span>clean, wet" in cleaning_page_module.legend()
    assert f'<h1 style="border-color:{VERDICT_COLOURS["clean, wet"]}">' in told


def test_components_of_which_the_same_is_said_share_a_row_that_names_them_all() -> None:
    report = small_report()
    names = [f"U{number}" for number in range(90)]
    dirty = tuple(replace(u1_of(report), component=name) for name in names)
    told = components_html(replace(report, parts=dirty))
    assert told.count("R7 residue</b>") == told.count("R8 one-sided flow</b>") == 1
    assert "<b>90 components</b>" in told
    assert ", ".join(names) in told
    assert "<b>U0, U1, U2</b>" in components_html(replace(report, parts=dirty[:3]))


def test_a_list_that_is_too_long_still_names_all() -> None:
    report = small_report()
    first = u1_of(report).judgements[0]
    unlike = tuple(
        replace(u1_of(report), component=f"U{number}", judgements=(replace(first, advice=f"Ask engineer E{number}."),))
        for number in range(MOST_DESCRIBED + 10)
    )
    told = components_html(replace(report, parts=unlike))
    assert told.count("R7 residue</b>") == MOST_DESCRIBED
    assert "Neither are these clean (10):</b> " + ", ".join(f"U{MOST_DESCRIBED + more}" for more in range(10)) in told


@pytest.mark.slow
def test_what_was_worked_out_exactly_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cleaning_page_module.pictures, "draw_exposures", lambda _: [])
    cone = {"cone_s": 8.1234, "cone_error_s": 0.1234, "exact_cone_s": 8.0456}
    exact = Verified("U1", "clean", "sequence[0]", rays_mm=5.5, exact_mm=5.0, worst_mm=0.8, cells=30, **cone)
    told = cleaning_page(small_report(), Traceability(), (exact,))
    assert "Worked out exactly" in told
    assert "+10.0%" in told
    assert "8.12 ± 0.12" in told
    assert "Worked out exactly" not in cleaning_page(small_report(), Traceability())


def test_rinsing_says_how_often_it_renews_the_film() -> None:
    report = small_report()  # 9 mm on average, of a film of 0.2 mm
    assert report.parameters.rinse.film_um == 200
    assert renewals(report) == [
        "sequence[1]: rinse renews the film on the bare board 45 times on average, on its least wetted places 22.5 "
        "times."
    ]


@pytest.mark.slow
def test_gaps_are_drawn_of_one_part_of_each_package(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(
        cleaning_page_module, "draw_gaps", lambda _, part: drawn.append(part.component) or Picture(".svg", b"", "")
    )
    monkeypatch.setattr(cleaning_page_module.pictures, "draw_exposures", lambda _: [])
    report = small_report()
    r1 = next(part for part in report.parts if part.component == "R1")
    twins = tuple(replace(r1, component="R2") if part.component == "R2" else part for part in report.parts)
    cleaning_page(replace(report, parts=twins), Traceability())
    assert drawn == ["U1", "R1"], "R2 has the package of R1"


def closely(report, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Which pictures the page has of the worst parts."""
    drawn: list[str] = []

    def gaps(_report, part):
        drawn.append(f"gap {part.component}")
        return Picture(".svg", b"<svg/>", "")

    def reach(_report, part):
        drawn.append(f"reach {part.component}")
        return Picture(".svg", b"<svg/>", "")

    monkeypatch.setattr(cleaning_page_module, "draw_gaps", gaps)
    monkeypatch.setattr(cleaning_page_module.pictures, "draw_reach", reach)
    for name in ("draw_verdicts", "draw_exposures"):
        monkeypatch.setattr(cleaning_page_module.pictures, name, lambda _report: [])
    for name in ("draw_volumes", "draw_limiting"):
        monkeypatch.setattr(cleaning_page_module.pictures, name, lambda _report: None)
    cleaning_page(report, Traceability())
    return drawn


def test_the_picture_of_a_worst_part_is_that_of_the_rule_that_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    report = small_report()
    assert "gap U1" in closely(report, monkeypatch)  # dirty by R7
    first = u1_of(report)
    for rule in (MISSED, UNDER_EXPOSED):
        surface = Judgement(rule=rule, verdict="dirty", because="Too little.", advice="More.")
        part = replace(first, judgements=(surface, *first.judgements))
        drawn = closely(with_u1(report, part), monkeypatch)
        assert "reach U1" in drawn
        assert "gap U1" not in drawn


def test_a_part_that_no_stage_acts_on_has_no_empty_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    report = small_report()
    first = u1_of(report)
    gaps = tuple(replace(gap, stages=(None,) * len(gap.stages)) for gap in first.gaps)
    drawn = closely(with_u1(report, replace(first, gaps=gaps)), monkeypatch)
    assert not any("U1" in each for each in drawn)


def test_renewals_are_given_as_multiples_of_what_is_needed() -> None:
    report = small_report()
    part = next(each for each in report.parts if each.gaps)
    gap = part.gaps[0]
    headings = [column.heading for column in gap_table(report, part).columns]
    row = dict(zip(headings, gap_table(report, part).rows[0], strict=True))
    act = next(each for each in gap.stages if each is not None)
    assert row["renewed, times needed"] == short_number(act.exchanges / gap.exchanges_needed)
    acts = tuple(each and replace(each, exchanges=3000.0 * gap.exchanges_needed) for each in gap.stages)
    often = replace(part, gaps=(replace(gap, stages=acts),))
    told = surplus_words(replace(report, parts=(often,)))
    assert told[0].startswith("Washing renews every gap at least 3,000 times as often as needed")
    assert surplus_words(replace(report, parts=(replace(part, gaps=()),))) == []


def test_what_was_noticed_on_the_way_is_told_and_judgements_are_not_told_twice() -> None:
    assert remarks(small_report()) == [
        "sequence[1]: rinse is repeated until a sensor ends it; it is analysed done once."
    ]


def test_numbers_are_short() -> None:
    low, high = Number("gap", 25.0, "um", 100.0), Number("gap", 50.0, "um", 100.0)
    assert (number_text(low), number_text(low, high)) == ("gap 25 um (limit 100)", "gap 25 to 50 um (limit 100)")
    assert [short_number(value) for value in (0.0, 0.0312, 12.34, 12345.6, float("inf"))] == [
        "0", "0.0312", "12.3", "12,346", "∞",
    ]  # fmt: skip
    assert number_text(Number("volume", 6.1e-06, "mm")) == "volume under 0.001 mm"
    assert number_text(Number("volume", 0.0, "mm")) == "volume 0 mm"
    assert number_text(Number("gap", float("inf"), "µm")) == "gap ∞ µm"
    assert number_text(Number("margin", -4e-4, "Pa")) == "margin -0.0004 Pa"


def test_a_fitted_value_is_told_with_how_well_it_was_fitted() -> None:
    report = small_report()
    fitted = Provenance(
        known="calibrated", source="c.csv", date="2026-11-21", samples=48, rms=0.02, interval=(4e-4, 5e-4)
    )
    known = {**report.parameters.provenance, "soil.k1_per_s": fitted}
    fitted_report = replace(report, parameters=report.parameters.model_copy(update={"provenance": known}))
    told = table_html(assumptions_table(fitted_report))
    assert "c.csv (2026-11-21); 48 samples, rms 0.02, 95 % 0.0004 to 0.0005" in told


@pytest.mark.slow
def test_the_program_is_named_by_its_hash_where_it_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cleaning_page_module.pictures, "draw_exposures", lambda _: [])
    told = cleaning_page(small_report(), Traceability(program_sha256="c0de" * 16))
    assert f"program <code>{'c0de' * 16}</code>" in told
