"""Deviations: each moves what it names, as far as it states, and nothing else."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from small_boards import board_of, part
from small_programs import program_of

from boards.board import Board
from cleaning.parameters.load import load_parameters
from cleaning.process.stages import stages_of
from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from recipes.load import load_recipe
from specs.source import Source
from studies.run_job import deviate
from studies.study import Deviation

MADE_BY = Source.parse("sequence[0]/sweep")
DOWN = (0.0, 1.0, 0.0, 0.0)
LEANING = tuple(Rotation.from_euler("xz", [150.0, 20.0], degrees=True).as_quat(scalar_first=True).tolist())
RECIPE = load_recipe("smt-aqueous")
BOARD: Board = board_of(part("U1", 20.0, 20.0, 5.0, 5.0))
PLACES = [(0.0, 0.0, 60.0), (30.0, 10.0, 50.0), (80.0, 40.0, 40.0)]


def program() -> TimedProgram:
    poses = [DOWN, LEANING, LEANING]
    moves = [
        MoveTo(float(at), place, pose, 30.0, MADE_BY)
        for at, (place, pose) in enumerate(zip(PLACES, poses, strict=True))
    ]
    function = RECIPE.functions["clean"]
    commands = [
        Command(0.0, "FUNCTION", ("clean",), MADE_BY),
        Command(0.0, "NOZZLE", ("ring60",), MADE_BY),
        Command(0.0, "SET", ("pressure_bar", f"{function.pressure_bar:.3f}"), MADE_BY),
        Command(0.0, "SET", ("temperature_c", "60.000"), MADE_BY),
    ]
    jet = [SetNozzle(0.0, True, MADE_BY), *moves[1:], SetNozzle(2.0, False, MADE_BY)]
    return program_of(moves[0], *commands, *jet, liquid=(("clean", 4.0),))


def moved(*deviation: tuple[str, float]) -> tuple[np.ndarray, Rotation]:
    done, _ = deviate(program(), RECIPE, BOARD, deviation)  # type: ignore[arg-type]
    moves = [each for each in done.instructions if isinstance(each, MoveTo)]
    poses = Rotation.from_quat([each.quaternion for each in moves], scalar_first=True)
    return np.array([each.position for each in moves]), poses


def test_nothing_moves_without_deviation() -> None:
    none: Deviation = tuple((name, 0.0) for name in ("standoff_mm", "turn_deg", "shift_x_mm", "pressure_pct"))  # type: ignore[misc]
    done, recipe = deviate(program(), RECIPE, BOARD, none)
    places, _ = moved(*none)
    np.testing.assert_allclose(places, PLACES, atol=1e-12)
    assert done.totals == program().totals
    assert recipe.functions == RECIPE.functions


def test_standoff_moves_the_orifice_back_along_its_jet() -> None:
    places, poses = moved(("standoff_mm", 2.0))
    jets = poses.apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(jets[0], [0.0, 0.0, -1.0], atol=1e-12)
    np.testing.assert_allclose(places + 2.0 * jets, PLACES, atol=1e-12)


def test_a_board_that_is_displaced_sees_the_program_displaced_the_other_way() -> None:
    places, poses = moved(("shift_x_mm", 1.5), ("shift_y_mm", -0.5))
    np.testing.assert_allclose(places, np.array(PLACES) - [1.5, -0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(poses.as_matrix(), moved()[1].as_matrix(), atol=1e-12)


def test_a_board_is_turned_about_the_centre_of_its_outline() -> None:
    places, poses = moved(("turn_deg", 90.0))
    left, front, right, back = BOARD.outline.bounds
    x, y = 0.5 * (left + right), 0.5 * (front + back)
    # Seen from a board that is turned anticlockwise, what lay to its right lies in front of it.
    expected = [(x + (py - y), y - (px - x), pz) for px, py, pz in PLACES]
    np.testing.assert_allclose(places, expected, atol=1e-9)
    turned_back = Rotation.from_euler("z", 90.0, degrees=True) * poses
    np.testing.assert_allclose(turned_back.as_matrix(), moved()[1].as_matrix(), atol=1e-9)


@pytest.mark.parametrize(
    ("deviation", "pressure", "flow"),
    [((("pressure_pct", -19.0),), 0.81, 1.0), ((("nozzle_wear_pct", 10.0),), 1.0, 1.1)],
)
def test_pressure_and_wear_reach_the_jet_and_the_litres(deviation: Deviation, pressure: float, flow: float) -> None:
    done, recipe = deviate(program(), RECIPE, BOARD, deviation)
    assert dict(done.totals.liquid_l)["clean"] == pytest.approx(4.0 * flow * math.sqrt(pressure))
    parameters = load_parameters()
    (before,) = stages_of(program(), RECIPE, parameters).stages
    (after,) = stages_of(done, recipe, parameters).stages
    assert after.pressure_pa == pytest.approx(before.pressure_pa * pressure)
    assert after.nozzle.flow_lpm == pytest.approx(before.nozzle.flow_lpm * flow)
    assert (after.temperature_c, after.spray_s) == (before.temperature_c, before.spray_s)


def test_what_is_warmer_is_sprayed_warmer() -> None:
    done, recipe = deviate(program(), RECIPE, BOARD, (("temperature_c", -2.5),))
    (stage,) = stages_of(done, recipe, load_parameters()).stages
    assert stage.temperature_c == 57.5
    assert recipe.functions["clean"].temperature_c == (RECIPE.functions["clean"].temperature_c or 0.0) - 2.5
