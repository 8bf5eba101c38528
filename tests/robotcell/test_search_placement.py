import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_findings import made_finding
from placed_parts import flat_top
from small_cells import CELL
from tracked import line_program, lines_program, split_program

import robotcell.placement.optimise
import robotcell.search_placement
from boards.load import board_library, load_board
from programs.program import MoveTo
from recipes.load import load_recipe
from reports.files.robot_programs import write_tracked
from robotcell.cell.cell import Cell, place_pose
from robotcell.cell.cell_edits import format_place, place_of, with_place
from robotcell.cell.load import read_cell_text
from robotcell.cell.spec import Hold, Place
from robotcell.collision.collision import build_collider
from robotcell.errors import CellError
from robotcell.motion.sampled_path import sample_path
from robotcell.placement.configurations import describe_placement
from robotcell.placement.evaluate import PlacementGoal
from robotcell.placement.optimise import Placement, find_placements
from robotcell.placement.reachability import Metric, Targets, thinned
from robotcell.robot.robot import flange_poses, pose, roll_pitch_yaw
from robotcell.search_placement import find_place, room_of, targets_of
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.pipeline import run

_FILE = Path("cell.yaml")
angles = st.floats(-np.pi, np.pi)


@pytest.fixture
def short_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at fewer places than a user's search does: what is asserted here holds for any that is found."""
    monkeypatch.setattr("robotcell.placement.optimise.MOST_EVALUATIONS", 130)


@settings(max_examples=100)
@given(roll=angles, pitch=st.one_of(angles, st.sampled_from([np.pi / 2, -np.pi / 2])), yaw=angles)
def test_the_turns_of_a_pose_give_the_pose(roll: float, pitch: float, yaw: float) -> None:
    turned = pose((1, 2, 3), (roll, pitch, yaw))
    np.testing.assert_allclose(pose((1, 2, 3), roll_pitch_yaw(turned)), turned, atol=1e-8)


def test_a_turned_place_is_written_in_millimetres_and_degrees_and_read_back() -> None:
    quarter = np.pi / 2
    assert place_of(pose((0.4, -0.05, 0.15), (0, 0, quarter))) == Place(xyz_mm=(400, -50, 150), rpy_deg=(0, 0, 90))
    assert place_of(pose((0, 0, 0), (np.pi, 0, 0.5))).rpy_deg == (180, 0, 28.65)
    turned = pose((0.4, -0.05, 0.15), (0.1, -0.2, 2.5))
    np.testing.assert_allclose(place_pose(place_of(turned)), turned, atol=2e-4)
    text = CELL.replace("board:\n  pose: {xyz_mm: [400, -50, 150]}\n", format_place(place_of(turned)))
    np.testing.assert_allclose(read_cell_text(text).cell.T_cell_board, turned, atol=2e-4)


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
def test_a_better_place_is_found_and_confirmed_as_it_is_written() -> None:
    loaded = read_cell_text(CELL)
    found = find_place(line_program(), loaded, None)
    assert found.best is not None
    assert found.best.placement.least > found.present.placement.least
    assert not found.best.stopped_by
    report = found.best.report
    written = place_pose(place_of(found.best.placement.T_cell_board))
    np.testing.assert_allclose(report.cell.T_cell_board, written, atol=1e-12)
    # The joints of the confirmed motion do bring the orifice to where the program asks for it, on the moved board.
    tcp = np.linalg.inv(written) @ report.cell.T_cell_base @ flange_poses(report.cell.robot, report.joints)
    off = np.linalg.norm((tcp @ loaded.cell.tools[0].T_flange_tcp)[:, :3, 3] - (0.02, 0.02, 0.11), axis=1)
    assert off.min() < 1e-5  # it comes from home
    assert loaded.cell.T_cell_board[2, 3] == pytest.approx(written[2, 3])


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
@pytest.mark.parametrize("metric", ["condition", "clearance"])
def test_each_measure_finds_a_place_of_a_program_and_of_targets(metric: Metric) -> None:
    loaded, program = read_cell_text(CELL), line_program()
    targets = targets_of(sample_path(program, loaded.cell, terms_of(loaded).round_nozzles, {}))
    of_program, of_targets = (find_place(what, loaded, None, PlacementGoal(metric)) for what in (program, targets))
    present = of_program.present.placement.value
    assert present > 0.0
    assert of_program.best is None or of_program.best.placement.value > present  # in the open all are as far as that
    assert of_targets.tried[-1].placement.value >= of_targets.present.placement.value


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
def test_turning_the_whole_cell_turns_the_place_and_nothing_else() -> None:
    loaded = read_cell_text(CELL)
    turn = pose((0.2, -0.1, 0.0), (0, 0, 0.7))
    cell = loaded.cell
    fixtures = tuple(
        dataclasses.replace(body, T_carrier_shape=turn @ body.T_carrier_shape) for body in loaded.cell.fixtures
    )
    turned = dataclasses.replace(cell, T_cell_base=turn @ cell.T_cell_base, fixtures=fixtures)
    x, y, z = (1e3 * (turn @ cell.T_cell_board)[:3, 3]).tolist()
    hold = Hold(pose=Place(xyz_mm=(x, y, z), rpy_deg=(0, 0, float(np.degrees(0.7)))))
    spec = loaded.spec.model_copy(update={"board": hold})
    one = find_place(line_program(), loaded, None).best
    two = find_place(line_program(), dataclasses.replace(loaded, spec=spec, cell=turned), None).best
    assert one is not None
    assert two is not None
    # Each is rounded to what can be written in its own frame.
    np.testing.assert_allclose(two.placement.T_cell_board, turn @ one.placement.T_cell_board, atol=3e-4)
    assert two.placement.least == pytest.approx(one.placement.least, rel=1e-3)


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
def test_a_board_out_of_reach_is_brought_into_it() -> None:
    loaded = read_cell_text(CELL.replace("[400, -50, 150]}", "[1900, -50, 150]}"))
    found = find_place(line_program(), loaded, None)
    assert set(found.present.stopped_by) == {"board-out-of-reach", "out-of-reach"}
    assert found.present.placement.value == -2.0
    assert found.best is not None
    assert found.best.placement.distance < 1.0


def _refusing(monkeypatch: pytest.MonkeyPatch, moved: int) -> None:
    """Have the check refuse so many of the places that are tried."""
    calls: list[int] = []

    def refuse(*requested: object, **how: object) -> CellReport:
        report = track(*requested, **how)  # type: ignore[arg-type]
        calls.append(0)
        wrong = made_finding("made-up", "error", "no")
        return dataclasses.replace(report, findings=(wrong,)) if 1 < len(calls) <= 1 + moved else report

    monkeypatch.setattr(robotcell.search_placement, "track", refuse)


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
def test_the_next_best_is_taken_where_the_check_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    _refusing(monkeypatch, 1)
    found = find_place(line_program(), read_cell_text(CELL), None)
    assert [each.stopped_by for each in found.tried] == [("made-up",), ()]
    assert found.best is found.tried[1]
    assert found.tried[0].placement.value >= found.tried[1].placement.value - 1e-4  # both as they are written


@pytest.mark.slow
@pytest.mark.usefixtures("short_search")
def test_no_more_than_three_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    _refusing(monkeypatch, 9)
    found = find_place(line_program(), read_cell_text(CELL), None)
    assert found.best is None
    assert 2 <= len(found.tried) <= 3


@pytest.mark.slow
def test_a_place_that_is_refused_leads_to_the_one_that_would_help(monkeypatch: pytest.MonkeyPatch) -> None:
    """The best by some of the points is a little beyond what the whole program reaches."""

    def by_some(cell: Cell, targets: Targets, *requested: object, **how: object) -> tuple[Placement, ...]:
        return find_placements(cell, thinned(targets, 4), *requested, **how)[:1]  # type: ignore[arg-type]

    monkeypatch.setattr(robotcell.search_placement, "find_placements", by_some)
    loaded = read_cell_text(CELL.replace("[400, -50, 150]}", "[1900, -50, 150]}"))
    board = load_board(Path("tiny"))
    program = run(load_recipe("rinse-only"), board).program
    found = find_place(program, loaded, board, PlacementGoal(metric="limits", criterion="mean"))
    assert found.best is not None
    refused, best = found.tried
    assert refused.stopped_by
    assert refused.report.remedy is not None
    np.testing.assert_allclose(best.placement.T_cell_board, refused.report.remedy.cell.T_cell_board, atol=1e-9)
    assert best.placement.distance < refused.placement.distance


def test_the_targets_are_all_points_of_a_program_with_the_board_in_its_place() -> None:
    cell = read_cell_text(CELL).cell
    path = sample_path(line_program(length=90.0), cell, frozenset(), {})
    targets = targets_of(path)
    assert len(targets.tool) == len(path.times)
    for axis, low, high in ((0, 0.02, 0.11), (1, 0.02, 0.04), (2, 0.06, 0.11)):
        along = targets.T_board_tcp[:, axis, 3]
        assert (along.min(), along.max()) == pytest.approx((low, high))
    assert targets.free.any()
    assert not targets.free.all()


def test_a_program_that_never_has_the_board_there_is_refused() -> None:
    path = sample_path(line_program(), read_cell_text(CELL).cell, frozenset(), {})
    with pytest.raises(CellError, match="never used"):
        targets_of(dataclasses.replace(path, placement=np.ones_like(path.placement)))


@pytest.mark.slow
@pytest.mark.parametrize("over_mm", [140, 110], ids=["over a height", "level"])
def test_regions_of_two_configurations_are_what_the_robot_does_with_the_program(over_mm: float) -> None:
    """Limits of two joints leave each line to one configuration; the check changes it on the flight between them."""
    limits = "joints:\n  shoulder_lift: {position_deg: [-112, 60]}\n  elbow: {position_deg: [0, 160]}\nhome_deg_mm"
    loaded = read_cell_text(CELL.replace("home_deg_mm", limits))
    program, terms = split_program(over_mm), terms_of(loaded)
    targets = targets_of(sample_path(program, loaded.cell, terms.round_nozzles, terms.placements))
    collider = build_collider(loaded.cell, None)
    one, two = (
        describe_placement(loaded.cell, targets, PlacementGoal(configurations=count), collider) for count in (1, 2)
    )
    assert one.score.value < -1.0
    assert (two.score.value > 0.0, two.failing, len(two.score.branches)) == (True, (), 2)
    report = track(program, loaded.cell, None, terms=terms)
    assert not [each for each in report.findings if each.severity == "error"]
    # In front of the elbow the wrist bends one way near the robot, and the other way far from it.
    moves = [each for each in report.program.instructions if isinstance(each, MoveTo)]
    x, q = np.array([each.position[0] for each in moves]), report.joints
    wrist = q[:, 4] > 0.0
    sprayed = np.array([each.position[2] < 61.0 for each in moves])
    assert sprayed.sum() > 50
    assert (wrist[sprayed] == (x[sprayed] < 0.0)).all()
    flip = np.array([each.name.endswith(", J5-") for each in two.configurations])
    used = [each.branch for each, flipped in zip(two.configurations, flip, strict=True) if flipped]
    near = targets.T_board_tcp[:, 0, 3] < -0.1
    assert set(two.region[near].tolist()).isdisjoint(used)
    assert set(two.region[targets.T_board_tcp[:, 0, 3] > 0.25].tolist()) == set(used)


@pytest.mark.slow
def test_a_split_that_is_found_is_checked_and_exported() -> None:
    """One configuration reaches the lines to the right of the robot's middle, another those to the left."""
    limits = "joints:\n  shoulder_pan: {position_deg: [-160, -20]}\nhome_deg_mm: [-21"
    loaded = read_cell_text(CELL.replace("home_deg_mm: [-16", limits))
    goal = PlacementGoal(floor=0.035, configurations=2)
    found = find_place(lines_program(), loaded, None, goal)
    assert found.present.stopped_by
    assert found.best is not None
    one = describe_placement(found.details.cell, found.details.targets, dataclasses.replace(goal, configurations=1))
    assert one.score.value < -1.0
    assert found.details.score.least >= 0.035
    # Each line stays in the configuration of its region.
    details = found.details
    sprayed = details.targets.T_board_tcp[:, 2, 3] < 0.061
    regions = [
        set(details.region[sprayed & (np.abs(details.targets.T_board_tcp[:, 1, 3] - y) < 1e-6)].tolist())
        for y in (0.0, 0.045, 0.09)
    ]
    assert [len(each) for each in regions] == [1, 1, 1]
    assert len(set.union(*regions)) == 2
    exported = write_tracked(found.best.report, loaded, "ur")
    assert not [each for each in (*found.best.report.findings, *exported.findings) if each.severity == "error"]
    assert exported.agreement.place_mm < 0.01


def test_a_board_has_no_room_in_the_table_or_in_the_robot() -> None:
    loaded = read_cell_text(CELL)
    room = room_of(loaded.cell, load_board(board_library()["tiny"]))
    assert room(loaded.cell.T_cell_board)
    assert not room(place_pose(Place(xyz_mm=(400, -50, -5))))
    assert not room(place_pose(Place(xyz_mm=(-10, -10, 50))))


TEXT = """cell: placed  # a name
board:                        # measured on a Monday
  pose: {xyz_mm: [400, -50, 150]}   # to be measured again
fixtures: {}   # none


home_deg_mm: [ 0,0 , 0]
"""


def test_only_the_place_is_changed_in_the_text() -> None:
    changed = with_place(TEXT, Place(xyz_mm=(410.5, -50, 150), rpy_deg=(0, 0, 30.25)), file=_FILE)
    new = "  pose: {xyz_mm: [410.5, -50, 150], rpy_deg: [0, 0, 30.25]} # to be measured again"
    assert changed == TEXT.replace("  pose: {xyz_mm: [400, -50, 150]}   # to be measured again", new)


def test_three_measured_points_give_way_to_the_place() -> None:
    points = "".join(f"    - {{board_mm: {at}, cell_mm: {at}}}\n" for at in ("[0, 0, 0]", "[9, 0, 0]", "[0, 9, 0]"))
    text = CELL.replace("  pose: {xyz_mm: [400, -50, 150]}\n", f"  points:\n{points}  largest_residual_mm: 0.2\n")
    place = Place(xyz_mm=(410, -50, 150.5))
    changed = with_place(text, place, file=_FILE)
    assert format_place(place) in changed
    assert read_cell_text(changed).spec.board.pose == place
    assert changed.partition("tools:")[2] == text.partition("tools:")[2]


def test_a_place_that_is_shared_is_not_changed() -> None:
    text = CELL.replace("board:\n", "board: &here\n").replace("tools:", "placements:\n  flipped: *here\ntools:")
    with pytest.raises(CellError, match=r"cell\.yaml.*anchor"):
        with_place(text, Place(xyz_mm=(1, 2, 3)), file=_FILE)


@pytest.mark.slow
def test_targets_on_a_surface_are_placed_where_they_are_reached_best_without_a_program() -> None:
    loaded = read_cell_text(CELL)
    found = find_place(flat_top(3, 2), loaded, None)
    assert found.best is not None
    assert found.best is found.tried[0]
    assert found.best.checked is None
    assert not found.refused
    assert found.best.placement.value > found.present.placement.value
    assert found.evaluated == found.best.placement.tried > 1
    assert found.moved_to == place_of(found.details.cell.held_pose)
    np.testing.assert_allclose(found.best.cell.T_cell_board, found.details.cell.T_cell_board, atol=1e-12)


def test_targets_that_no_place_reaches_well_enough_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robotcell.placement.optimise, "MOST_EVALUATIONS", 6)
    found = find_place(flat_top(2, 1), read_cell_text(CELL), None, PlacementGoal(floor=100.0))
    assert found.refused
    assert found.best is None
    assert found.moved_to is None
    assert [each.stopped_by for each in found.tried] == [("out-of-reach",)]
