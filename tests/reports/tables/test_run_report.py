"""The report is plain data with known keys, and its numbers are those of the program."""

import json
from pathlib import Path

import pytest
from made_findings import made_finding
from small_boards import board_of, part

from boards.load import board_library, load_board
from programs.playback import playback
from programs.program import Command, MoveTo, SetNozzle
from recipes.load import load_recipe, parse_recipe
from reports.cards.program import fitted_words
from reports.cards.workpiece import board_facts
from reports.tables.run_report import class_counts, report
from rulesengine.planning.pipeline import Run, run
from specs.finding import blocking, grouped_findings

RECIPE = "recipe: a\nextends: smt-aqueous\nmasks: [{avoid: [R2], margin_mm: 0}, {clean: [R2]}]\n"


@pytest.fixture(scope="module")
def done() -> Run:
    return run(parse_recipe(RECIPE), load_board(board_library()["tiny"]))


def test_keys(done: Run) -> None:
    told = report(done)
    assert list(told) == [
        *("washboard_report", "board", "recipe", "fitted", "totals", "functions", "sprayed", "classes", "components"),
        "findings",
    ]
    assert set(told["totals"]) == {"duration_s", "spray_s", "travel_mm", "moves", "liquid_l"}
    assert set(told["functions"][0]) == {
        *("function", "nozzle", "solution", "start_s", "duration_s", "spray_s", "spray_mm", "travel_mm")
    }
    assert set(told["sprayed"][0]) == {"made_by", "seconds", "height_mm", "landed_share", "half_landed_mm"}
    assert set(told["components"][0]) == {
        *("name", "class", "because", "package", "pins", "side", "height_mm", "height_source", "area_mm2"),
        *("standoff_mm", "standoff_source", "neighbour_mm", "served_by"),
    }
    assert set(told["findings"][0]) == {"rule", "severity", "message", "made_by", "where"}


def test_the_document_names_every_key(done: Run) -> None:
    told = report(done)
    text = (Path(__file__).parents[3] / "docs" / "command-line.md").read_text("utf-8").partition("## The report")[2]
    firsts = (told[key][0] for key in ("functions", "sprayed", "components", "findings"))
    for section in (told, told["board"], told["totals"], *firsts):
        for key in section:
            assert f"`{key}`" in text


def test_it_is_json_and_the_same_for_the_same_run(done: Run) -> None:
    text = json.dumps(report(done), allow_nan=False)
    again = run(parse_recipe(RECIPE), load_board(board_library()["tiny"]))
    assert json.dumps(report(again), allow_nan=False) == text
    assert json.loads(text) == report(done)


def test_numbers_are_those_of_the_program(done: Run) -> None:
    told, program = report(done), done.program
    instructions = program.instructions
    totals = told["totals"]
    assert totals["moves"] == sum(isinstance(each, MoveTo) for each in instructions)
    assert totals["duration_s"] == pytest.approx(instructions[-1].time_s, abs=1e-4)
    opened, spraying = 0.0, 0.0
    for each in instructions:
        if isinstance(each, SetNozzle):
            opened, spraying = each.time_s, spraying + (0.0 if each.spraying else each.time_s - opened)
    assert totals["spray_s"] == pytest.approx(spraying, abs=1e-3)
    assert totals["liquid_l"] == {name: round(litres, 4) for name, litres in program.totals.liquid_l}
    assert not playback(program, [totals["duration_s"]]).spraying[-1]


def test_functions_add_up_to_the_totals(done: Run) -> None:
    told = report(done)
    names = [
        each.arguments[0]
        for each in done.program.instructions
        if isinstance(each, Command) and each.keyword == "FUNCTION"
    ]
    assert [each["function"] for each in told["functions"]] == names == ["clean", "rinse", "dry"]
    for key in ("duration_s", "spray_s", "travel_mm"):
        assert sum(each[key] for each in told["functions"]) == pytest.approx(told["totals"][key], abs=0.01)
    assert all(0 <= each["spray_mm"] <= each["travel_mm"] for each in told["functions"])


def test_every_component_in_file_order_with_what_serves_it(done: Run) -> None:
    told = {each["name"]: each for each in report(done)["components"]}
    assert list(told) == [each.name for each in done.board.components]
    assert told["U1"]["class"] == "bottom_terminated"
    assert told["U1"]["served_by"] == ["sequence[0]/around"]
    assert told["U1"]["standoff_source"] == "stated"
    assert told["R2"]["served_by"] == []  # it is masked
    assert class_counts(done) == report(done)["classes"]
    assert sum(class_counts(done).values()) == len(told)
    assert list(class_counts(done)) == list(done.recipe.classes)


def test_findings_stand_worst_first(done: Run) -> None:
    found = report(done)["findings"]
    assert len(found) == len(done.findings)
    assert found[0]["rule"] == "mask-conflict"
    ranks = [["error", "warning", "info"].index(each["severity"]) for each in found]
    assert ranks == sorted(ranks)
    assert all(each["where"] is None or len(each["where"]) == 3 for each in found)
    assert any(each["where"] for each in found)


def test_only_errors_that_are_not_allowed_block() -> None:
    findings = [made_finding("a", "error", "1"), made_finding("b", "error", "2"), made_finding("a", "warning", "3")]
    assert [each.message for each in blocking(findings, [])] == ["1", "2"]
    assert [each.message for each in blocking(findings, ["a"])] == ["2"]
    assert blocking(findings, ["a", "b", "c"]) == []


def test_findings_of_one_rule_and_severity_are_told_once() -> None:
    findings = [made_finding("a", "error", "1"), made_finding("a", "warning", "2"), made_finding("a", "warning", "3")]
    assert [(each.message, count) for each, count in grouped_findings(findings)] == [("1", 1), ("2", 2)]


def test_the_facts_of_a_board() -> None:
    facts = dict(board_facts(load_board(board_library()["two-sided"])))
    assert facts["components"] == "43 (24 top, 19 bottom)"
    assert facts["surfaces"] == "top at z = 1.600 mm, bottom at z = 0.000 mm"
    assert facts["tallest"] == "J2, 8.54 mm"
    assert facts["standoff"] == "43 stated"
    assert facts["undersides"] == "41 thin gaps, joints: 41 family"


def test_library_recipes_report_what_they_spray() -> None:
    told = report(run(load_recipe("dry-only"), load_board(board_library()["tiny"])))
    assert [each["solution"] for each in told["functions"]] == ["hot-air"]
    assert told["totals"]["liquid_l"] == {}
    assert told["recipe"]["name"] == "dry-only"


def test_what_was_fitted_to_the_board() -> None:
    text = """
recipe: fitted
extends: smt-aqueous
templates: {wide: {path: raster, height_mm: auto, speed_mm_s: 50}}
sequence:
  - {function: clean, nozzle: ring60, paths: [wide], least_time_s: 60}
  - {function: clean, nozzle: ring60, paths: [wide], side: bottom, only_with_parts: true}
"""
    done = run(parse_recipe(text), board_of(part("C1", 20, 20, 2, 1)))
    told = report(done)["fitted"]
    height, times = told["height_mm"]["wide"], told["again"]["sequence[0]"]
    assert told == {"height_mm": {"wide": height}, "again": {"sequence[0]": times}, "left_out": ["sequence[1]"]}
    assert fitted_words(done) == (
        f"height_mm: wide {height:g}; sequence[0]: wide {times} times more; sequence[1] left out, no components there"
    )
