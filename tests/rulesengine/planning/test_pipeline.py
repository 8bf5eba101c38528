"""Recipe and board in, plan and program out: commands in order, all of it attributed, nothing silently left out."""

import re
from dataclasses import replace

import numpy as np
import pytest
import yaml
from acceptance import complaints
from hostile import at, board_with
from shapely import box
from small_boards import board_of, part

from boards.errors import BoardError
from programs.plan import Command, Dwell, SprayPass, Transfer
from programs.program import Command as TimedCommand
from programs.program import MoveTo, SetNozzle
from recipes.classes import ComponentClass, Mask
from recipes.errors import RecipeError
from recipes.load import load_recipe
from recipes.paths import BoardPerimeter, ComponentPerimeter, StepFunction
from recipes.recipe import Step, Until
from rulesengine.planning.pipeline import make_plan, run
from specs.finding import Finding
from specs.finding_rules import COMPONENT_OUTSIDE

AROUND = ComponentPerimeter(height_mm=30, speed_mm_s=40, tilt_deg=35)


def recipe_of(*steps, **changes):
    """The default recipe with another sequence; ``changes`` are other keys of the recipe."""
    recipe = load_recipe("smt-aqueous")
    templates = {**recipe.templates, **changes.pop("templates", {})}
    return recipe.model_copy(update={"sequence": list(steps), "templates": templates} | changes)


def step(*paths, **known):
    return Step(**({"function": "clean", "nozzle": "ring60", "paths": list(paths)} | known))


def two_sides():
    return board_with(
        ("U1", at(20, 20, 20, 20), 2), ("J1", at(60, 20, 5, 20), 70), ("U2", at(30, 10, 10, 10), 8, "bottom")
    )


def test_commands_come_in_order_and_nothing_moves_before_them():
    plan = make_plan(recipe_of(step("edge")), board_of())
    words = [item.keyword for item in plan.items if isinstance(item, Command)]
    assert words == ["FUNCTION", "NOZZLE", "SOLUTION", "SET", "SET"]
    assert all(isinstance(item, Command) for item in plan.items[: len(words)])


def test_a_granted_tilt_band_is_said_in_every_step():
    limits = load_recipe("smt-aqueous").limits.model_copy(update={"tilt_band_deg": 12.5})
    plan = make_plan(recipe_of(step("edge"), step("edge", function="rinse"), limits=limits), board_of())
    granted = [item for item in plan.items if isinstance(item, Command) and item.arguments[:1] == ("tilt_band_deg",)]
    assert [(item.keyword, item.arguments[1], str(item.made_by)) for item in granted] == [
        ("SET", "12.500", "sequence[0]"),
        ("SET", "12.500", "sequence[1]"),
    ]


def test_everything_is_attributed_to_a_step_and_a_template_of_it():
    recipe = load_recipe("smt-aqueous")
    done = run(recipe, board_of(part("U1", 20, 20, 10, 10), part("C1", 60, 20, 2, 1)))
    for item in done.plan.items:
        source = item.made_by
        if not isinstance(item, Command):
            assert source.motion == "park" or source.template in recipe.sequence[source.step].paths
    assert {str(each.made_by) for each in done.program.instructions} <= {str(each.made_by) for each in done.plan.items}


def test_a_repeated_body_begins_and_ends_at_the_same_pose():
    until = {"resistivity_mohm_cm": 1.0, "max_repeats": 4}
    done = run(recipe_of(step("edge"), step("sweep", until=until)), board_of())
    pose, seen = None, {}
    for each in done.program.instructions:
        if isinstance(each, MoveTo):
            pose = (each.position, each.quaternion)
        elif isinstance(each, TimedCommand) and each.keyword in ("REPEAT", "ENDREPEAT"):
            seen[each.keyword] = pose
    assert seen["REPEAT"] == seen["ENDREPEAT"]
    (repeat,) = (each for each in done.plan.items if isinstance(each, Command) and each.keyword == "REPEAT")
    assert repeat.arguments == ("4", "UNTIL", "resistivity_mohm_cm", ">=", "1.000")


def test_repeat_does_all_paths_so_often():
    once, thrice = (make_plan(recipe_of(step("edge", "sweep", repeat=n)), board_of()) for n in (1, 3))
    count = [sum(isinstance(item, SprayPass) for item in plan.items) for plan in (once, thrice)]
    assert count[1] == 3 * count[0]


def test_between_sides_the_jet_is_off_and_the_speed_is_that_of_the_function_that_holds():
    recipe = recipe_of(
        step("flush", function="dry", nozzle="knife"),
        step("sweep", "around", function="rinse", side="bottom"),
        step("around", repeat=2),
    )
    done = run(recipe, two_sides())
    assert complaints(done) == []
    calls = [each for each in done.program.instructions if isinstance(each, TimedCommand) and each.keyword == "CALL"]
    assert [each.arguments for each in calls] == [("flip_to_bottom",), ("flip_to_top",)]
    switches = [each for each in done.program.instructions if isinstance(each, SetNozzle)]
    for call in calls:
        assert not [each for each in switches if each.time_s <= call.time_s][-1].spraying


def test_a_step_that_is_not_enabled_leaves_nothing_behind():
    plan = make_plan(recipe_of(step("edge"), step("sweep", enabled=False)), board_of())
    assert not [item for item in plan.items if item.made_by.step == 1]


@pytest.mark.parametrize("board", [board_of(), board_of(part("U2", 20, 20, 10, 10, side="bottom"))])
def test_a_recipe_that_sprays_nothing_is_refused(board):
    with pytest.raises(RecipeError, match=r"^sequence: there is nothing to spray on boxes.*around on the top"):
        make_plan(recipe_of(step("around")), board)


def test_a_component_without_a_class_is_refused():
    recipe = recipe_of(step("edge"), classes={"big": ComponentClass(area_mm2={"min": 500})})
    with pytest.raises(RecipeError, match="no class takes C1"):
        make_plan(recipe, board_of(part("C1", 20, 20, 2, 1)))


def test_what_is_not_done_is_said():
    board = board_of(part("U1", 20, 20, 10, 10), part("MK1", 42, 20, 4, 4), part("U2", 50, 20, 10, 10, side="bottom"))
    low = AROUND.model_copy(update={"height_mm": 12.0})
    recipe = recipe_of(step("around"), masks=[Mask(avoid=["MK1"]), Mask(clean=["U2"])], templates={"around": low})
    found = {each.rule.id: each for each in make_plan(recipe, board).findings}
    assert "Not followed all around: U1" in found["cut-by-mask"].message
    assert found["not-served"].severity == "error"
    assert found["side-not-sprayed"].severity == "warning"
    assert found["side-not-sprayed"].message == (
        "No step sprays the bottom side, where 1 component is: U2. Add to the sequence: "
        "`- {function: clean, nozzle: ring60, paths: [around], side: bottom}`"
    )


def test_the_steps_to_add_for_an_unsprayed_side_can_be_pasted_and_mend_it():
    board = board_of(*(part(f"C{index}", 20 * index, 20, 2, 1, side="bottom") for index in (1, 2, 3)))
    until = Until(resistivity_mohm_cm=1.5, max_repeats=4)
    steps = [step("sweep", repeat=2), step("sweep", "edge", until=until), step("sweep", repeat=2)]
    (found,) = (each for each in make_plan(recipe_of(*steps), board).findings if each.rule.id == "side-not-sprayed")
    assert found.severity == "error"
    lines = re.findall(r"`(- .*?)`", found.message)
    added = [Step.model_validate(each) for each in yaml.safe_load("\n".join(lines))]
    assert added == [each.model_copy(update={"side": "bottom"}) for each in steps[:2]]
    mended = make_plan(recipe_of(*steps, *added), board)
    assert "side-not-sprayed" not in {each.rule.id for each in mended.findings}


def test_a_board_whose_parts_are_all_masked_may_be_sprayed_on_either_side():
    board = board_of(part("C1", 20, 20, 2, 1, side="bottom"))
    findings = make_plan(recipe_of(step("sweep"), masks=[Mask(ignore=["C1"])]), board).findings
    assert "error" not in {each.severity for each in findings}


@pytest.mark.parametrize(
    ("steps", "message"),
    [
        (
            [step("around")],
            "The steps on the top side do not spray 2 of its 3 components: C1, C2. Add to the sequence: "
            "`- {function: clean, nozzle: ring60, paths: [sweep]}`, or give their classes passes",
        ),
        ([step("around", "sweep")], ""),
        (
            [step("sweep", side="bottom")],
            "Only the other side is sprayed, and all 3 components are on the top. Add to the sequence: `- {function: ",
        ),
        ([step("around"), step("around", "sweep", side="bottom")], "The steps on the top side do not spray 2 of its 3"),
        ([step("sweep"), step("around", side="bottom")], ""),
    ],
)
def test_a_side_with_components_that_are_not_sprayed(steps, message):
    chips = [part(f"C{index}", 20 + 20 * index, 20, 2, 1) for index in (1, 2, 3)]
    board = board_of(part("U1", 10, 20, 10, 10), *chips)
    masks = [Mask(ignore=["C3"])]
    some = AROUND.model_copy(update={"passes": {"small": 0, "default": 1}})
    found = make_plan(recipe_of(*steps, masks=masks, templates={"around": some}), board).findings
    said = [each for each in found if each.rule.id == "side-not-sprayed"]
    severity = "error" if message.startswith("Only") else "warning"
    assert [each.severity for each in said] == [severity] * bool(message)
    assert all(each.message.startswith(message) for each in said)


def test_a_few_components_of_a_side_that_are_left_are_named_with_the_step_to_add():
    board = board_of(*(part(f"U{index}", 30 * index, 20, 10, 10) for index in range(1, 6)), part("C1", 15, 60, 2, 1))
    some = AROUND.model_copy(update={"passes": {"small": 0, "default": 1}})
    recipe = recipe_of(step("around", side="top"), templates={"around": some})
    (found,) = (each for each in make_plan(recipe, board).findings if each.rule.id == "side-not-sprayed")
    assert found.severity == "warning"
    assert found.message.startswith("The steps on the top side do not spray 1 of its 6 components: C1. Add to the")
    (line,) = re.findall(r"`(- .*?)`", found.message)
    added = [Step.model_validate(each) for each in yaml.safe_load(line)]
    mended = make_plan(recipe_of(step("around"), *added, templates={"around": some}), board)
    assert "side-not-sprayed" not in {each.rule.id for each in mended.findings}


def test_without_a_template_across_the_side_one_is_to_be_added():
    board = board_of(part("U1", 10, 20, 10, 10), part("C1", 40, 20, 2, 1))
    some = AROUND.model_copy(update={"passes": {"small": 0, "default": 1}})
    recipe = recipe_of(step("around")).model_copy(update={"templates": {"around": some}})
    (found,) = (each for each in make_plan(recipe, board).findings if each.rule.id == "side-not-sprayed")
    assert found.message.endswith(
        "do not spray 1 of its 2 components: C1. Add a template that goes across it, such as a raster, or give their "
        "classes passes"
    )


def test_what_must_be_cleaned_but_is_kept_out_by_a_mask_is_said():
    board = board_of(part("U1", 10, 20, 6, 6), part("MK1", 17, 20, 4, 4), part("U2", 60, 20, 6, 6))
    masks = [Mask(avoid=["MK1"], margin_mm=30.0), Mask(clean=["U1", "U2"])]
    found = make_plan(recipe_of(step("around"), masks=masks), board).findings
    (finding,) = (each for each in found if each.rule.id == "not-served")
    assert finding.message.startswith("U1 must be cleaned, but no pass goes around it.")
    assert finding.severity == "error"
    assert finding.where == (13.0, 23.0, board.top_z_mm)


def test_a_path_far_inside_the_edge_is_said():
    inside = BoardPerimeter(height_mm=30, speed_mm_s=40, offset_mm=-200)
    plan = make_plan(recipe_of(step("edge"), templates={"edge": inside}), board_of())
    (finding,) = [each for each in plan.findings if each.rule.id == "no-path-inside"]
    assert str(finding.made_by) == "sequence[0]/edge"


def test_a_path_inside_a_group_that_leaves_a_part_out_is_said():
    board = board_of(part("U1", 10, 10, 30, 30), part("C1", 41, 20, 2, 1))
    deep = AROUND.model_copy(update={"distance_mm": -9.0, "align": "axis", "tilt_deg": 0.0})
    found = make_plan(recipe_of(step("around"), templates={"around": deep}), board).findings
    (finding,) = (each for each in found if each.rule.id == "not-circled")
    assert "does not go around C1." in finding.message
    assert finding.where is not None


def test_findings_about_a_raised_stroke_carry_a_place_over_the_body():
    board = board_of(part("J1", 40, 20, 20, 20, 80))
    raised = [
        each for each in make_plan(recipe_of(step("sweep")), board).findings if each.rule.id == "raised-over-body"
    ]
    assert raised
    for each in raised:
        x, y, z = each.where
        assert 34 <= x <= 66
        assert 14 <= y <= 46
        assert z >= 85


def test_pauses_of_a_raised_and_tilted_line_are_where_the_jet_meets_the_edges():
    board = board_of(part("J1", 30, 0, 20, 60, 40), part("U1", 70, 0, 10, 60, 1))
    spec = StepFunction(height_mm=20, speed_mm_s=40, direction_deg=0, tilt_deg=30)
    plan = make_plan(recipe_of(step("step"), templates={"step": spec}), board)
    met, last = [], None
    for item in plan.items:
        if isinstance(item, SprayPass):
            last = item
        elif isinstance(item, Dwell):
            tip, jet = last.tcp[-1], last.approach[-1]
            met.append(float((tip - jet * tip[2] / jet[2])[0]))
    lines = len(met) // 4
    assert lines >= 1
    np.testing.assert_allclose(np.sort(met), np.repeat([30, 50, 70, 80], lines), atol=1e-3)


def test_what_cannot_be_a_board_is_not_planned():
    doubt = Finding(COMPONENT_OUTSIDE, "3 components lie elsewhere.")
    recipe, board = load_recipe("rinse-only"), board_of(part("U1", 20, 20, 10, 10))
    assert run(recipe, replace(board, findings=(doubt,))).program.instructions
    with pytest.raises(BoardError, match=r"not planned: 3 components lie elsewhere. \(component-outside\)"):
        run(recipe, replace(board, findings=(replace(doubt, override="error"),)))


def test_transfers_never_spray_and_passes_always_do():
    done = run(load_recipe("smt-aqueous"), board_of(part("U1", 20, 20, 10, 10), part("U2", 70, 40, 10, 10)))
    dry = {str(each.made_by) for each in done.plan.items if isinstance(each, Transfer)}
    wet = {str(each.made_by) for each in done.plan.items if isinstance(each, SprayPass)}
    assert not dry & wet
    spraying = False
    for each in done.program.instructions:
        if isinstance(each, SetNozzle):
            spraying = each.spraying
        elif isinstance(each, MoveTo) and each.speed_mm_s > 0:
            assert spraying == (str(each.made_by) in wet)
    assert not spraying


def test_without_what_is_merely_worth_knowing_the_program_and_every_other_finding_are_the_same():
    recipe, board = load_recipe("rinse-only"), board_of(part("U1", 12, 12, 6, 6), outline=box(0, 0, 24, 24, ccw=True))
    whole, short = run(recipe, board), run(recipe, board, notices="errors and warnings")
    assert short.program.instructions == whole.program.instructions
    left_out = [finding for finding in whole.findings if finding not in short.findings]
    assert {finding.rule.id for finding in left_out} == {"spray-beside-board"}
    assert {finding.severity for finding in left_out} == {"info"}
    assert [finding for finding in whole.findings if finding not in left_out] == list(short.findings)


def test_the_strokes_are_shown_before_they_are_timed_also_where_no_order_is_searched_for():
    board, recipe = two_sides(), load_recipe("rinse-only")
    stages, shown = [], []
    first = run(recipe, board)
    done = run(recipe, board, lambda what, _: stages.append(what), lambda plan: shown.append((plan, *stages)), first)
    plan, *before = shown[0]
    assert "timing" not in before
    assert "timing" in stages
    assert len(shown) == 1
    sprayed = [[item.made_by for item in each.items if isinstance(item, SprayPass)] for each in (plan, done.plan)]
    assert sprayed[0] == sprayed[1] != []
