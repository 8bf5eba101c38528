"""In every cell of the library the stated board pose serves boards up to 160 x 100 mm, however the jet leans."""

import numpy as np
import pytest
from library_cells import CELLS

from robotcell.cell.load import cell_library, read_cell
from robotcell.collision.collision import build_collider, collides
from robotcell.kinematics.inverse import solve
from robotcell.robot.robot import Poses, inverse, is_inside, pose

SLACK_MM = 8.0


def requested() -> Poses:
    """Orifices over and around the largest board, 40 and 110 mm high, straight and tilted by 35 degrees to 8 sides."""
    poses: list[Poses] = []
    for x in (-SLACK_MM, 80.0, 160.0 + SLACK_MM):
        for y in (-SLACK_MM, 50.0, 100.0 + SLACK_MM):
            for height in (40.0, 110.0):
                place = pose((x / 1e3, y / 1e3, height / 1e3), (np.pi, 0.0, 0.0))
                poses.append(place)
                poses += [
                    place @ pose((0, 0, 0), (0, 0, turn)) @ pose((0, 0, 0), (np.radians(35.0), 0, 0))
                    for turn in np.arange(0, 2 * np.pi, np.pi / 4)
                ]
    return np.array(poses)


@pytest.mark.slow
@pytest.mark.parametrize("name", CELLS)
def test_some_configuration_reaches_every_pose_without_collision(name: str) -> None:
    cell = read_cell(name).cell
    collider = build_collider(cell, None)
    for tool in cell.tools:
        served = np.zeros(len(requested()), dtype=bool)
        for azimuth in np.radians(np.arange(0, 360, 60)):
            targets = requested() @ pose((0, 0, 0), (0, 0, azimuth)) @ inverse(tool.T_flange_tcp)
            found = solve(
                cell.robot, inverse(cell.T_cell_base) @ cell.T_cell_board @ targets, T_flange_tcp=tool.T_flange_tcp
            )
            rows, branches = np.nonzero(is_inside(cell.robot, found.q))
            clear = ~collides(collider, found.q[rows, branches], tool.number)
            served[rows[clear]] = True
        assert np.flatnonzero(~served).tolist() == []


@pytest.mark.parametrize("name", CELLS)
def test_the_knife_leans_along_its_travel_in_any_direction(name: str) -> None:
    """A slot lies across the travel and leans along it: the azimuth is not free, also on a gantry of five axes."""
    cell = read_cell(name).cell
    (knife,) = (tool for tool in cell.tools if tool.name == "knife")
    middle = pose((0.08, 0.05, 0.05), (np.pi, 0.0, 0.0))
    tilt = pose((0, 0, 0), (np.radians(35.0), 0, 0))  # about tool +x, which lies along the slot
    targets = np.array([middle @ pose((0, 0, 0), (0, 0, turn)) @ tilt for turn in np.arange(0, 2 * np.pi, np.pi / 6)])
    flange = inverse(cell.T_cell_base) @ cell.T_cell_board @ targets @ inverse(knife.T_flange_tcp)
    found = solve(cell.robot, flange, T_flange_tcp=knife.T_flange_tcp)
    true = is_inside(cell.robot, found.q) & (np.abs(np.angle(np.exp(1j * found.azimuth))) < 1e-6)
    assert np.any(true, axis=1).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", cell_library())
def test_home_is_free_within_its_limits_and_looks_down_at_the_board(name: str) -> None:
    cell = read_cell(name).cell
    collider = build_collider(cell, None)
    assert not any(collides(collider, cell.home[None], tool.number)[0] for tool in cell.tools)
