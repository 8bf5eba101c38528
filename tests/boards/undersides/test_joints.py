"""Joints that are laid out from a package's name."""

import math
from itertools import combinations

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.packages.families import package_families, package_family, package_sizes, pins_of
from boards.packages.undersides import underside_families, underside_family
from boards.undersides.joints import Joint, Package, joints_of, many_joints
from boards.undersides.underside import joint_polygon


def laid_out(name: str, length: float, width: float, pins: int | None = None) -> tuple[Joint, ...]:
    count = pins_of(name) if pins is None else pins
    joints = joints_of(underside_family(package_family(name)), Package(package_sizes(name), count or 0, length, width))
    assert joints is not None
    return joints


def covered(joints: tuple[Joint, ...], length: float, width: float) -> float:
    return sum(joint_polygon(joint).area for joint in joints) / (length * width)


BODIES = [
    ("QFN-16-1EP_3x3mm_P0.5mm", 3.0, 3.0),
    ("QFN-48-1EP_7x7mm_P0.5mm_EP5.15x5.15mm", 7.0, 7.0),
    ("QFN-38-1EP_5x7mm_P0.5mm", 7.0, 5.0),
    ("QFN-20", 4.0, 4.0),
    ("QFN", 4.0, 4.0),
    ("QFN50P400X400X90-24", 4.0, 4.0),
    ("DFN-8-1EP_3x2mm_P0.5mm", 3.0, 2.0),
    ("DFN-10-1EP_2x3mm_P0.5mm", 3.0, 2.0),
    ("WSON-8", 6.0, 5.0),
    ("BGA-144_13.0x13.0mm_Layout12x12_P1.0mm_Ball0.5mm", 13.0, 13.0),
    ("BGA-121_12.0x12.0mm_P1.0mm", 12.0, 12.0),
    ("TFBGA-100_9x9mm_P0.8mm", 9.0, 9.0),
    ("BGA-90_8.0x13.0mm_Layout9x15_P0.8mm", 13.0, 8.0),
    ("WLCSP-12_1.56x1.56mm_Layout4x3_P0.4mm", 1.56, 1.56),
    ("BGA", 10.0, 10.0),
    ("LGA-12_2x2mm_P0.5mm", 2.0, 2.0),
    ("LGA-16_4x4mm_Layout4x4_P0.8mm", 4.0, 4.0),
    ("LGA-64", 8.0, 8.0),
    ("R_Array_Convex_4x0603", 3.2, 1.6),
    ("C_0805_2012Metric", 2.0, 1.25),
    ("Crystal_SMD_3225-4Pin_3.2x2.5mm", 3.2, 2.5),
    ("Crystal_SMD_3215-2Pin_3.2x1.5mm", 3.2, 1.5),
    ("D_SMA", 4.6, 2.6),
    ("TO-252-2", 6.5, 6.1),
    ("SOT-89-3", 4.5, 2.5),
    ("TSSOP-20-1EP_4.4x6.5mm_P0.65mm", 6.5, 4.4),
]


@pytest.mark.parametrize(("name", "length", "width"), BODIES)
def test_joints_lie_under_the_body_and_apart_and_are_symmetrical(name: str, length: float, width: float) -> None:
    joints = laid_out(name, length, width)
    body = shapely.box(-length / 2, -width / 2, length / 2, width / 2).buffer(2e-4)
    polygons = [joint_polygon(joint) for joint in joints]
    assert all(body.contains(polygon) for polygon in polygons)
    assert all(a.intersection(b).area < 1e-3 * min(a.area, b.area) for a, b in combinations(polygons, 2))
    places = sorted((round(joint.x_mm, 3) + 0.0, round(joint.y_mm, 3) + 0.0) for joint in joints)
    assert places == sorted((0.0 - x, 0.0 - y) for x, y in places)


@pytest.mark.parametrize(("name", "length", "width"), BODIES)
def test_no_name_bridges_the_gap_by_itself(name: str, length: float, width: float) -> None:
    assert 0.05 < covered(laid_out(name, length, width), length, width) < 0.7


@pytest.mark.parametrize(
    ("name", "side", "low", "high"),
    [("QFN-48-1EP_7x7mm_P0.5mm", 7.0, 0.55, 0.69), ("QFN-16-1EP_3x3mm_P0.5mm", 3.0, 0.4, 0.65)],
)
def test_a_heat_pad_takes_most_of_what_a_qfn_covers(name: str, side: float, low: float, high: float) -> None:
    joints = laid_out(name, side, side)
    assert low < covered(joints, side, side) < high
    assert joint_polygon(joints[-1]).area > 0.5 * covered(joints, side, side) * side * side


def test_a_heat_pad_is_left_out_only_where_a_full_name_has_none() -> None:
    assert len(laid_out("QFN-32-1EP_5x5mm_P0.5mm", 5.0, 5.0)) == 33
    assert len(laid_out("QFN-32_5x5mm_P0.5mm", 5.0, 5.0)) == 32
    assert len(laid_out("QFN-32", 5.0, 5.0)) == 33
    assert laid_out("QFN-32-1EP_5x5mm_P0.5mm_EP3.1x3.2mm", 5.0, 5.0)[-1].width_mm == 3.1


def test_a_rectangular_quad_has_more_lands_along_its_longer_sides() -> None:
    lands = laid_out("QFN-38-1EP_5x7mm_P0.5mm", 7.0, 5.0)[:-1]
    front = [land for land in lands if abs(land.y_mm) > 2.2 and abs(land.x_mm) < 3.2]
    assert len(lands) == 38
    assert len(front) == 24
    assert math.isclose(front[1].x_mm - front[0].x_mm, 0.5)


def test_rows_of_a_dual_stand_along_the_second_size_of_its_name() -> None:
    along_width = laid_out("DFN-8-1EP_3x2mm_P0.5mm", 3.0, 2.0)[:-1]
    along_length = laid_out("DFN-8-1EP_2x3mm_P0.5mm", 3.0, 2.0)[:-1]
    assert {land.x_mm for land in along_width} == {-1.3, 1.3}
    assert {land.y_mm for land in along_length} == {-0.8, 0.8}


def test_a_ball_grid_is_as_its_name_says() -> None:
    balls = laid_out("BGA-144_13.0x13.0mm_Layout12x12_P1.0mm_Ball0.5mm", 13.0, 13.0)
    assert len(balls) == 144
    assert all(ball.round and ball.length_mm == 0.5 for ball in balls)
    assert {ball.x_mm for ball in balls} == {-5.5 + k for k in range(12)}


def test_a_ball_grid_without_a_layout_is_full() -> None:
    assert len(laid_out("BGA-144_13x13mm_P1.0mm", 13.0, 13.0)) == 144
    assert len(laid_out("LFBGA-289_14x14mm_P0.8mm", 14.0, 14.0)) == 17 * 17
    assert len(laid_out("BGA-240_14x14mm_P0.8mm", 14.0, 14.0)) == 16 * 16


def test_leads_beside_the_body_leave_the_gap_free() -> None:
    for name in ("SOIC-8_3.9x4.9mm_P1.27mm", "LQFP-64_10x10mm_P0.5mm", "SOT-23", "SOT-223", "SOD-123", "PLCC-44"):
        assert laid_out(name, 5.0, 4.0) == ()
    for name in ("HTSSOP-20-1EP_4.4x6.5mm_P0.65mm", "TQFP-48-1EP_7x7mm_P0.5mm", "HTSSOP-16"):
        assert len(laid_out(name, 6.5, 4.4)) == 1


def test_a_chip_stands_on_its_two_ends() -> None:
    left, right = laid_out("R_0402_1005Metric", 1.0, 0.5)
    assert (left.x_mm, right.x_mm) == (-0.4, 0.4)
    assert left.width_mm == right.width_mm == 0.5
    assert math.isclose(covered((left, right), 1.0, 0.5), 0.4)


def test_what_is_unknown_has_no_joints_but_may_have_many() -> None:
    assert joints_of(underside_family(None), Package(package_sizes("XYZ"), 0, 5.0, 4.0)) is None
    assert 0.25 < covered(many_joints(Package(package_sizes("XYZ"), 0, 5.0, 4.0)), 5.0, 4.0) < 0.69


def test_every_family_of_packages_is_in_the_table_once() -> None:
    families = {
        f"chip {family.name[-5:].strip()}" if family.name.startswith("chip ") else family.name
        for family in package_families()
    }
    assert sorted(families) == sorted(underside_families())


def test_the_bounds_of_a_standoff_hold_its_nominal_value() -> None:
    for family in package_families():
        row = underside_family(family)
        if row.joints == "none" or family.gap_height_mm is None:
            continue
        assert row.gap_height_mm is not None, family.name
        assert 0.0 < row.gap_height_mm[0] <= family.gap_height_mm <= row.gap_height_mm[1] <= 1.0, family.name


def test_a_fine_pitch_stands_lower() -> None:
    row = underside_family(package_family("TFBGA-100_9x9mm_P0.8mm"))
    coarse, fine = row.gap_heights_mm(0.8), row.gap_heights_mm(0.5)
    assert coarse is not None
    assert fine is not None
    assert fine[0] < coarse[0]
    assert row.gap_heights_mm(None) == coarse


@pytest.mark.parametrize(
    ("name", "body", "pitch", "pad"),
    [
        ("Package_DFN_QFN:QFN-32-1EP_5x5mm_P0.5mm_EP3.45x3.45mm", (5.0, 5.0), 0.5, (3.45, 3.45)),
        ("QFN50P700X500X90-48N", (7.0, 5.0), 0.5, None),
        ("QFP50P900X900X160-48N", None, 0.5, None),
        ("SOIC-8_3.9x4.9mm_P1.27mm", (3.9, 4.9), 1.27, None),
        ("C_0805_2012Metric", None, None, None),
        ("L_6.3x6.3_H3", None, None, None),
        ("QFN-8_0x0mm_P0mm", None, None, None),
        ("LQFP64_10X10", (10.0, 10.0), None, None),
        ("BGA84_8X12P5_P8MM", (8.0, 12.5), None, None),
        ("PinHeader_1x04_P2.54mm_Vertical", None, 2.54, None),
        ("R_Array_Convex_4x0603", None, None, None),
        ("CP_Elec_6.3x7.7", None, None, None),
    ],
)
def test_sizes_are_read_from_names(
    name: str, body: tuple[float, float] | None, pitch: float | None, pad: tuple[float, float] | None
) -> None:
    sizes = package_sizes(name)
    assert (sizes.body_mm, sizes.pitch_mm, sizes.pad_mm) == (body, pitch, pad)


FAMILIES = [
    "QFN",
    "DFN",
    "BGA",
    "TFBGA",
    "WLCSP",
    "LGA",
    "R_0402",
    "C_1812",
    "Crystal_SMD",
    "D_SMA",
    "TO-252",
    "HTSSOP",
]


@pytest.mark.slow
@settings(max_examples=60)
@given(
    family=st.sampled_from(FAMILIES),
    pins=st.integers(0, 400),
    sides=st.tuples(st.floats(0.4, 30.0), st.floats(0.4, 30.0)),
    words=st.lists(st.sampled_from(["-1EP", "_P0.5mm", "_P1.27mm", "_3x5mm", "_Layout7x9", "_EP9x2mm"]), max_size=3),
)
def test_whatever_a_name_says_joints_are_sound(
    family: str, pins: int, sides: tuple[float, float], words: list[str]
) -> None:
    length, width = max(sides), min(sides)
    name = f"{family}-{pins}{''.join(words)}"
    joints = laid_out(name, length, width, pins)
    body = shapely.box(-length / 2, -width / 2, length / 2, width / 2).buffer(1e-3)
    for joint in joints:
        assert min(joint.length_mm, joint.width_mm) > 0.0
        assert body.contains(joint_polygon(joint))
