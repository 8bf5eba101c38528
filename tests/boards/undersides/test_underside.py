"""What is beneath the components of a board."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from boards.board import Board, Body, Surface
from boards.load import board_library, load_board
from boards.undersides.underside import GapCase, Joint, Underside, coverage, undersides_of
from boards.understand import understand
from geometry.mesh import areas_and_normals

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
Span = tuple[float, float, float, float, float, float]


def cuboid(span: Span) -> np.ndarray:
    """Twelve outward triangles of a box x0 y0 z0 x1 y1 z1."""
    corners = CORNERS * (np.array(span[3:]) - np.array(span[:3])) + np.array(span[:3])
    return np.array([corners[list(part)] for a, b, c, d in FACES for part in ((a, b, c), (a, c, d))])


def body(name: str, *spans: Span, role: str = "component", **stated: object) -> Body:
    patches = np.concatenate([cuboid(span) for span in spans])
    surfaces = (Surface("1", len(patches)),)
    return Body(name, role, patches, areas_and_normals(patches)[1], surfaces, **stated)  # type: ignore[arg-type]


BOARD = body("board", (0, 0, 0, 100, 80, 1.6), role="board")
QFN = (10.0, 10.0, 1.65, 15.0, 15.0, 2.5)
CHIP = (30.0, 30.0, 1.6, 32.0, 31.25, 2.1)


def moved(bodies: Sequence[Body], angle: float, shift: tuple[float, float, float]) -> list[Body]:
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return [replace(one, patches=one.patches @ turn.T + shift, normals=one.normals @ turn.T) for one in bodies]


def beneath_of(*bodies: Body) -> dict[str, Underside]:
    return {underside.component: underside for underside in undersides_of(understand([BOARD, *bodies], "test"))}


@cache
def sample(name: str) -> Board:
    return load_board(board_library()[name])


@cache
def beneath_sample(name: str) -> dict[str, Underside]:
    return {underside.component: underside for underside in undersides_of(sample(name))}


def test_a_stated_standoff_gives_one_case() -> None:
    one = beneath_of(body("U1", QFN, package="QFN-32-1EP_5x5mm_P0.5mm", gap_height_mm=0.05))["U1"]
    (case,) = one.cases
    assert (case.gap_height_mm, one.gap_height_source) == (0.05, "stated")
    assert len(case.joints) == 33
    assert "QFN" in one.joints_source


def test_a_family_gives_both_bounds_the_lower_first() -> None:
    one = beneath_of(body("R1", CHIP, package="R_0805_2012Metric"))["R1"]
    assert [case.gap_height_mm for case in one.cases] == [0.025, 0.05]
    assert one.cases[0].joints == one.cases[1].joints
    assert "chip resistor 0805" in one.gap_height_source


def test_unknown_joints_give_many_and_none() -> None:
    one = beneath_of(body("U1", QFN, gap_height_mm=0.1))["U1"]
    hard, easy = one.cases
    assert hard.gap_height_mm == easy.gap_height_mm == 0.1
    assert 0.25 < coverage(hard, one) < 0.7
    assert easy.joints == ()
    assert one.joints_source == "unknown: none and many"


@pytest.mark.parametrize(
    "stated",
    [
        {},
        {"package": "XYZ-9"},
        {"package": "CP_Elec_6.3x7.7"},
        {"package": "PinHeader_1x02_P2.54mm_Vertical", "gap_height_mm": 0.1},
        {"package": "DIP-8_W7.62mm"},
        {"package": "USB_C_Receptacle", "gap_height_mm": 0.1},
        {"package": "SOIC-8_3.9x4.9mm_P1.27mm", "gap_height_mm": 1.2},
        {"package": "C_0805_2012Metric", "gap_height_mm": 0.0},
    ],
)
def test_what_has_no_thin_gap_is_left_out(stated: dict[str, Any]) -> None:
    assert beneath_of(body("U1", QFN, **stated)) == {}


@pytest.mark.slow
def test_leads_are_not_part_of_the_body() -> None:
    one = beneath_sample("smt-demo")["U3"]
    assert (one.length_mm, one.width_mm) == pytest.approx((7.0, 7.0), abs=2e-3)
    assert abs(math.degrees(one.turn_rad)) == pytest.approx(45.0)
    soic = beneath_sample("two-sided")["U2"]
    assert (soic.length_mm, soic.width_mm) == pytest.approx((9.9, 3.9), abs=2e-3)
    assert abs(math.sin(soic.turn_rad)) == pytest.approx(1.0)


def test_the_name_says_how_large_the_body_is_in_an_outline_with_its_leads() -> None:
    box = (10.0, 10.0, 1.75, 16.0, 19.9, 3.3)
    one = beneath_of(body("U1", box, package="SOIC-16_3.9x9.9mm_P1.27mm"))["U1"]
    assert (one.length_mm, one.width_mm) == (9.9, 3.9)
    assert (one.x_mm, one.y_mm) == pytest.approx((13.0, 14.95))
    assert abs(math.sin(one.turn_rad)) == pytest.approx(1.0)


def test_a_small_body_is_not_blown_up_by_its_name() -> None:
    one = beneath_of(body("U1", (10, 10, 1.75, 13, 14, 3.3), package="SOIC-16_3.9x9.9mm_P1.27mm"))["U1"]
    assert (one.length_mm, one.width_mm) == (4.0, 3.0)


@pytest.mark.slow
def test_every_underside_is_under_its_component() -> None:
    for name in ("smt-demo", "two-sided", "tiny"):
        components = {component.name: component for component in sample(name).components}
        for one in beneath_sample(name).values():
            outline = components[one.component].outline
            assert one.length_mm >= one.width_mm > 0.0
            assert one.length_mm * one.width_mm <= 1.02 * outline.minimum_rotated_rectangle.area
            assert abs(outline.centroid.x - one.x_mm) < 0.5
            assert abs(outline.centroid.y - one.y_mm) < 0.5
            assert 1 <= len(one.cases) <= 2
            assert all(0.0 <= coverage(case, one) < 0.7 for case in one.cases)


def test_tabs_stand_at_the_ends_where_they_come_out() -> None:
    one = beneath_sample("two-sided")["C1"]
    assert (one.length_mm, one.width_mm) == pytest.approx((6.6, 6.6), abs=2e-3)
    assert abs(math.sin(one.turn_rad)) == pytest.approx(1.0)
    assert {joint.y_mm for joint in one.cases[0].joints} == {0.0}


def test_the_bottom_side_is_measured_from_the_bottom() -> None:
    top = body("U1", (10, 10, 1.7, 14, 15, 3.3), (9, 11, 1.6, 15, 11.4, 1.8), package="SOIC-8")
    low = body("U2", (10, 10, -1.7, 14, 15, -0.1), (9, 11, -0.2, 15, 11.4, 0.0), package="SOIC-8")
    found = beneath_of(top, low)
    assert replace(found["U2"], component="U1") == found["U1"]
    assert (found["U1"].length_mm, found["U1"].width_mm) == (5.0, 4.0)


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.3, math.pi / 2, 2.5, -1.234])
@pytest.mark.parametrize("name", ["two-sided", "tiny"])
def test_undersides_move_with_the_board_and_change_nothing_else(name: str, angle: float) -> None:
    shift = (123.456, -78.9, 1 / 3)
    there = undersides_of(understand(moved(sample(name).bodies, angle, shift), "there"))
    here = undersides_of(sample(name))
    assert len(here) == len(there)
    for one, other in zip(here, there, strict=True):
        assert one.cases == other.cases
        assert (one.component, one.length_mm, one.width_mm) == (other.component, other.length_mm, other.width_mm)
        x = math.cos(angle) * one.x_mm - math.sin(angle) * one.y_mm + shift[0]
        y = math.sin(angle) * one.x_mm + math.cos(angle) * one.y_mm + shift[1]
        assert (other.x_mm, other.y_mm) == pytest.approx((x, y), abs=1e-6)
        assert math.remainder(other.turn_rad - one.turn_rad - angle, 2 * math.pi) == pytest.approx(0.0, abs=1e-6)


def test_coverage_counts_what_joints_share_once_and_leaves_out_what_is_outside() -> None:
    one = beneath_of(body("R1", CHIP, package="R_0805_2012Metric"))["R1"]
    whole = Joint(0.0, 0.0, one.length_mm, one.width_mm)
    half = Joint(one.length_mm / 2.0, 0.0, one.length_mm, one.width_mm)
    assert coverage(GapCase(0.05, (half,)), one) == pytest.approx(0.5)
    assert coverage(GapCase(0.05, (half, half)), one) == pytest.approx(0.5)
    assert coverage(GapCase(0.05, (whole, half)), one) == pytest.approx(1.0)
    assert coverage(GapCase(0.05, ()), one) == 0.0
    ball = Joint(0.0, 0.0, 1.0, 1.0, round=True)
    assert coverage(GapCase(0.05, (ball,)), one) == pytest.approx(math.pi / 4.0 / 2.5, rel=1e-3)
    turned = Joint(0.0, 0.0, 1.2, 0.2, turn_rad=math.pi / 2.0)
    assert coverage(GapCase(0.05, (turned,)), one) == pytest.approx(0.24 / 2.5)
