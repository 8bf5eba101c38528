"""The whole chain on small boards: recipe, program, jets, surfaces, gaps, verdicts.

Rays of a sketch tell the mean volume on a part to about a tenth; what happens in gaps does not hang on rays. On a board
that is moved they hit nearly the same places: of its volumes a fiftieth may differ, because the surface is cut anew.
"""

import json
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from analysed import (
    DRY,
    PARAMETERS,
    RINSE,
    THICKNESS,
    WASH,
    board_of,
    bodies_of,
    parts_of,
    prepared_of,
    recipe_of,
    report_of,
    rules_of,
    usual,
)
from hostile import at, body
from rigid import Motion, moved_bodies, moved_recipe

from boards.load import load_board
from boards.understand import understand
from cleaning.analyse import analyse, analyse_on
from cleaning.errors import CleaningError
from cleaning.prepared_board import prepare
from cleaning.report import cleaning_report
from cleaning.verdicts.rules import VERDICTS
from programs.program import SetNozzle
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run

MASK = "masks: [{avoid: [J1], margin_mm: 3}]"


def volume(part, stage=0):
    """Mean volume on a part in one stage, mm."""
    return part.exposed[stage].volume_mm[2]


@cache
def washed(change=""):
    return report_of(recipe_of(WASH, change=change))


@pytest.mark.slow
def test_a_report_speaks_of_every_stage_and_every_part():
    report = usual()
    assert [stage.function for stage in report.stages] == ["clean", "rinse", "dry"]
    assert [part.component for part in report.parts] == ["U1", "C1", "J1"]
    for part in (report.bare, *report.parts):
        assert len(part.exposed) == len(report.exposures) == 3
        assert part.verdict == part.judgements[0].verdict
        assert part.verdict == min((each.verdict for each in part.judgements), key=VERDICTS.index)
        assert all(len(gap.stages) == 3 for gap in part.gaps)
        assert 1 - 1e-9 < sum(share for _, share in part.makers) < 1 + 1e-9
    rows = (report.bare, *report.parts)
    assert report.verdict == min((part.verdict for part in rows), key=VERDICTS.index)


@pytest.mark.slow
def test_what_is_not_clean_is_a_finding():
    report = usual()
    wrong = [each for part in (report.bare, *report.parts) for each in part.judgements if each.verdict != "clean"]
    wrong += [each for each in report.process if each.verdict != "clean"]
    assert wrong
    told = [finding.message for finding in report.findings]
    assert all(any(each.because in message for message in told) for each in wrong)
    assert len([finding for finding in report.findings if finding.severity == "warning"]) == len(
        [each for each in wrong if each.verdict == "dirty"]
    )


def test_liquid_lands_or_misses_and_every_drop_on_a_part_has_a_maker():
    report = usual()
    for stage, exposure in zip(report.stages, report.exposures, strict=True):
        assert 0 <= exposure.landed_mm3 <= exposure.sprayed_mm3 * 1.01
        assert exposure.by_maker_mm3.sum() == pytest.approx(exposure.landed_mm3, rel=1e-6)
        on_cells = float(exposure.volume_mm @ report.facets.cell_areas_mm2)
        assert on_cells == pytest.approx(exposure.landed_mm3, rel=1e-6)
        assert stage.use == "dry" or on_cells > 0


@pytest.mark.slow
def test_twice_the_same_to_the_last_bit():
    board, recipe = board_of("U1", "C1", "J1"), recipe_of(WASH, RINSE, DRY)
    again = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    assert json.dumps(cleaning_report(again)) == json.dumps(cleaning_report(usual()))
    for one, other in zip(usual().exposures, again.exposures, strict=True):
        np.testing.assert_array_equal(one.volume_mm, other.volume_mm)
        np.testing.assert_array_equal(one.growth.volume_mm, other.growth.volume_mm)


def test_progress_goes_from_nothing_to_all_and_never_back():
    told = []
    board, recipe = board_of("U1"), recipe_of(WASH)
    report = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch", lambda _, at: told.append(at))
    assert report.parts
    assert (told[0], told[-1]) == (0.0, 1.0)
    assert all(before <= after + 1e-12 for before, after in pairwise(told))


MOTIONS = [Motion(90, (200.0, -35.0, 4.0)), Motion(37, (-11.0, 320.0, -2.5))]


def check_moved(bodies, recipe, motion, before):
    """Plan and analyse a moved board with a moved recipe. Rays move with the nozzle, so they say nearly the same."""
    board, recipe = understand(moved_bodies(bodies, motion), "moved"), moved_recipe(recipe, motion)
    moved = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    assert len(moved.parts) == len(before.parts)
    found_parts = {part.component: part for part in (moved.bare, *moved.parts)}
    for part in (before.bare, *before.parts):
        other = found_parts[part.component]
        assert (part.verdict, rules_of(part)) == (other.verdict, rules_of(other))
        assert part.limiting == other.limiting
        for gap, found in zip(part.gaps, other.gaps, strict=True):
            assert found.residue == pytest.approx(gap.residue, abs=2e-5)
            assert found.stages[0].margin_pa == pytest.approx(gap.stages[0].margin_pa, rel=1e-3)
        for seen, found in zip(part.exposed, other.exposed, strict=True):
            assert found.volume_mm[2] == pytest.approx(seen.volume_mm[2], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_board_that_is_moved_and_planned_anew_is_as_clean(motion):
    check_moved(bodies_of("U1", "C1", "J1"), recipe_of(WASH, RINSE, DRY), motion, usual())


@pytest.mark.slow
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_board_of_the_library_is_as_clean_when_it_is_moved(motion):
    board, recipe = load_board(Path("tiny")), load_recipe("smt-aqueous")
    before = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    check_moved(board.bodies, recipe, motion, before)


@pytest.mark.slow
def test_finer_rays_and_samples_tell_the_same():
    fine = report_of(recipe_of(WASH, RINSE, DRY), effort="fast")
    for part, other in zip(usual().parts, fine.parts, strict=True):
        assert volume(other) == pytest.approx(volume(part), rel=0.15)
        for gap, found in zip(part.gaps, other.gaps, strict=True):
            assert found.residue == pytest.approx(gap.residue, abs=0.01)


@pytest.mark.slow
def test_a_slower_wash_leaves_no_more_and_brings_no_less():
    reports = [washed(f"templates: {{around: {{speed_mm_s: {speed}}}}}") for speed in (60, 30, 15)]
    for faster, slower in pairwise(reports):
        assert slower.duration_s > faster.duration_s
        for part, other in zip(faster.parts, slower.parts, strict=True):
            assert volume(other) > volume(part)
            for gap, found in zip(part.gaps, other.gaps, strict=True):
                assert found.residue <= gap.residue
                assert found.stages[0].exchanges >= gap.stages[0].exchanges


@pytest.mark.slow
def test_two_washes_add_up():
    once, twice = washed(), report_of(recipe_of(WASH, WASH))
    for part, other in zip(once.parts, twice.parts, strict=True):
        assert volume(other, 0) == pytest.approx(volume(part), rel=1e-6)
        reach = next(each for each in other.judgements if each.rule.id == "R2")
        alone = next(each for each in part.judgements if each.rule.id == "R2")
        assert reach.numbers[0].value == pytest.approx(2 * alone.numbers[0].value, rel=0.02)
        for gap, found in zip(part.gaps, other.gaps, strict=True):
            assert found.residue < gap.residue
            assert found.stages[0].residue == pytest.approx(gap.stages[0].residue, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("side", "dry"), [("top", "C2"), ("bottom", "U1")])
def test_a_side_that_is_not_sprayed_is_said_to_be(side, dry):
    step = WASH.replace("}", f", side: {side}}}")
    parts = parts_of(report_of(recipe_of(step), prepared_of(("U1", "C2"), ("C2",))))
    (other,) = set(parts) - {dry}
    assert rules_of(parts[dry]) == {("R1", "not sprayed")}
    assert parts[dry].verdict == "dirty"
    assert parts[dry].exposed == (None,)
    assert parts[dry].residue == 1.0
    assert parts[other].exposed[0].missed_share == 0.0
    assert parts[other].residue < 1.0


@pytest.mark.slow
def test_parts_on_the_other_side_change_nothing():
    alone = report_of(recipe_of(WASH), prepared_of(("U1",)))
    both = report_of(recipe_of(WASH), prepared_of(("U1", "C2"), ("C2",)))
    one, other = alone.parts[0], parts_of(both)["U1"]
    assert volume(other) == pytest.approx(volume(one), rel=1e-6)
    for gap, found in zip(one.gaps, other.gaps, strict=True):
        np.testing.assert_allclose(found.residue, gap.residue, rtol=1e-9)


def test_a_masked_part_gets_less_and_is_still_judged():
    free, masked = parts_of(washed())["J1"], parts_of(washed(MASK))["J1"]
    assert volume(masked) < 0.8 * volume(free)
    assert masked.judgements


def test_drying_alone_wets_nothing():
    report = report_of(recipe_of(DRY))
    assert all(rules_of(part) == {("R1", "not sprayed")} for part in (report.bare, *report.parts))
    assert all(gap.stages == (None,) for part in report.parts for gap in part.gaps)
    assert not np.any(report.exposures[0].volume_mm)
    assert report.exposures[0].cone_s.max() > 0


def test_rinsing_alone_softens_nothing_and_asks_for_no_wash():
    report = report_of(recipe_of(RINSE))
    assert report.process == ()
    for part in report.parts:
        assert not rules_of(part) & {("R7", "residue"), ("R6", "not flushed"), ("R10", "incomplete rinse")}
        assert all(gap.residue == 1.0 for gap in part.gaps)


def test_a_wash_that_is_never_rinsed_is_told():
    assert [(each.rule.id, each.verdict) for each in washed().process] == [("R10", "dirty")]
    assert washed().verdict == "dirty"


def test_a_board_without_parts_has_its_surface_judged():
    step = "{function: clean, nozzle: ring60, paths: [spot]}"
    line = "templates: {spot: {path: straight_line, from: [-40, 18], to: [90, 18], height_mm: 50, speed_mm_s: 5}}"
    report = report_of(recipe_of(step, change=line), prepared_of(()))
    assert report.parts == ()
    assert rules_of(report.bare) >= {("R1", "missed")}
    # From above the middle line everything sprays outwards, so that only the walls along it are never hit.
    board = report.bare.exposed[0]
    assert board.area_mm2 == pytest.approx(48 * 36 + 2 * (48 + 36) * THICKNESS)
    assert board.missed_share == pytest.approx(2 * 48 * THICKNESS / board.area_mm2, abs=1e-6)
    assert [(str(maker), share) for maker, share in report.bare.makers] == [("sequence[0]/spot", 1.0)]


def test_a_part_without_a_known_gap_is_judged_by_its_surface():
    connector = parts_of(usual())["J1"]
    assert connector.underside is None
    assert (connector.gaps, connector.residue, connector.elasticity, connector.limiting) == ((), None, {}, "")
    assert {each.rule.id for each in connector.judgements} <= {"R1", "R2"}


@pytest.mark.slow
@pytest.mark.parametrize("height", [1.0, 20.0])
@pytest.mark.parametrize("place", [(14, 12, 1, 12), (23, 12, 1, 12), (12, 14, 12, 1), (14, 23, 12, 1)])
def test_a_wall_beside_a_part_never_makes_it_cleaner(place, height):
    recipe = recipe_of(WASH)
    program = run(recipe, board_of("U1")).program
    free = analyse_on(prepared_of(("U1",)), program, recipe, "sketch")
    wall = body("W1", "component", at(*place), 0.0, height, package="Shield", pins=2, side="top")
    walled = prepare(understand(bodies_of("U1", more=(wall,)), "small"), PARAMETERS, lambda *_: None)
    behind = analyse_on(walled, program, recipe, "sketch")
    assert behind.exposures[0].by_maker_mm3[[0]].sum() <= free.exposures[0].by_maker_mm3[[0]].sum() * (1 + 1e-9)
    for gap, found in zip(free.parts[0].gaps, parts_of(behind)["U1"].gaps, strict=True):
        assert found.residue > gap.residue
        assert found.stages[0].exchanges < gap.stages[0].exchanges
        assert np.all(np.array(found.stages[0].edge_pa) <= np.array(gap.stages[0].edge_pa) + 1e-9)


def test_an_unknown_solution_is_taken_for_a_known_one_and_said():
    report = washed("functions: {clean: {solution: magic}}")
    said = [finding for finding in report.findings if finding.rule.id == "liquid-unknown"]
    assert len(said) == 1
    assert "magic" in said[0].message
    assert said[0].severity == "warning"
    assert report.parts[0].residue == pytest.approx(washed().parts[0].residue)


def test_a_program_of_another_recipe_is_refused_in_one_sentence():
    program = run(recipe_of(WASH), board_of("U1")).program
    with pytest.raises(CleaningError, match=r"uses function clean, which the recipe rinse-only does not have") as told:
        analyse_on(prepared_of(("U1",)), program, load_recipe("rinse-only"), "sketch")
    assert "\n" not in str(told.value)


def test_a_program_that_never_sprays_is_refused():
    recipe = recipe_of(WASH)
    program = run(recipe, board_of("U1")).program
    silent = replace(
        program, instructions=tuple(each for each in program.instructions if not isinstance(each, SetNozzle))
    )
    with pytest.raises(CleaningError, match="never sprays"):
        analyse_on(prepared_of(("U1",)), silent, recipe, "sketch")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["smt-demo", "two-sided"])
def test_the_boards_of_the_library(name):
    board, recipe = load_board(Path(name)), load_recipe("smt-aqueous")
    report = analyse(run(recipe, board).program, board, recipe, PARAMETERS, "sketch")
    assert len(report.parts) == len(board.components)
    data = cleaning_report(report)
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    for part, component in zip(report.parts, board.components, strict=True):
        assert part.component == component.name
        assert ("R1", "not sprayed") not in rules_of(part)
        assert all(0.0 <= gap.residue <= gap.residue_worst <= 1.0 for gap in part.gaps)
