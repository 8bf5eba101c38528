"""What is understood of a board made of boxes, whose measures are known."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import shapely
from shapely import Polygon, box

from boards.board import Board, Body, Pad, Surface
from boards.errors import BoardError
from boards.formats.tri.tri import read_tri, write_tri
from boards.understand import understand
from geometry.mesh import areas_and_normals

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
FACES = [(0, 2, 6, 4), (1, 5, 7, 3), (0, 4, 5, 1), (2, 3, 7, 6), (0, 1, 3, 2), (4, 6, 7, 5)]
Span = tuple[float, float, float, float, float, float]


def cuboid(span: Span) -> np.ndarray:
    """Twelve outward triangles of a box x0 y0 z0 x1 y1 z1."""
    low, high = np.array(span[:3]), np.array(span[3:])
    corners = CORNERS * (high - low) + low
    return np.array([corners[list(part)] for a, b, c, d in FACES for part in ((a, b, c), (a, c, d))])


def body(name: str, *spans: Span, role: str = "component", **stated: object) -> Body:
    patches = np.concatenate([cuboid(span) for span in spans])
    surfaces = (Surface("1", len(patches)),)
    return Body(name, role, patches, areas_and_normals(patches)[1], surfaces, **stated)  # type: ignore[arg-type]


BOARD = body("board", (0, 0, 0, 100, 80, 1.6), role="board")
CHIP = body("R1", (10, 10, 1.6, 12, 11.25, 2.1), package="R_0805_2012Metric", side="top")
FAR_CHIP = body("R2", (13.5, 10, 1.6, 15.5, 11.25, 2.1), side="top", pins=2)
BELOW = body("C1", (50, 50, -1.0, 53, 52, 0), gap_height_mm=0.07)
SOIC = body(
    "U1",
    (40, 30, 1.75, 44, 35, 3.3),
    *[(x, 30.4 + 1.27 * step, 1.6, x + 1.0, 30.8 + 1.27 * step, 2.4) for step in range(4) for x in (39.0, 44.0)],
    package="SOIC-8 3.9x4.9",
)


def moved(bodies: Sequence[Body], angle: float, shift: tuple[float, float, float]) -> list[Body]:
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return [replace(one, patches=one.patches @ turn.T + shift, normals=one.normals @ turn.T) for one in bodies]


def refuse(*bodies: Body) -> str:
    with pytest.raises(BoardError) as caught:
        understand(bodies, "wrong")
    return str(caught.value)


def test_the_planes_and_the_outline_are_the_boards() -> None:
    board = understand([CHIP, BOARD], "plain")
    assert (board.top_z_mm, board.bottom_z_mm, board.surface_z_mm("bottom")) == (1.6, 0.0, 0.0)
    assert board.outline.equals(box(0, 0, 100, 80))
    assert sorted(map(abs, board.axis)) == [0.0, 1.0]
    assert board.axis[1] == 0.0
    assert board.findings == ()


def test_burrs_and_pockets_do_not_move_the_planes() -> None:
    rough = body("board", (0, 0, 0, 100, 80, 1.6), (5, 5, 1.6, 7, 7, 1.9), (9, 9, -0.4, 9.5, 9.5, 0), role="board")
    board = understand([rough], "rough")
    assert (board.top_z_mm, board.bottom_z_mm) == (1.6, 0.0)


def test_holes_and_slots_go_through_the_outline() -> None:
    frame = body(
        "board",
        (0, 0, 0, 60, 20, 1),
        (0, 40, 0, 60, 60, 1),
        (0, 20, 0, 10, 40, 1),
        (50, 20, 0, 60, 40, 1),
        role="board",
    )
    outline = understand([frame], "frame").outline
    assert outline.symmetric_difference(box(0, 0, 60, 60).difference(box(10, 20, 50, 40))).area < 1e-3
    assert len(outline.interiors) == 1


def test_a_chip_is_measured_from_its_own_side() -> None:
    below, chip = understand([BOARD, CHIP, BELOW], "two sides").components
    assert (chip.side, below.side) == ("top", "bottom")
    assert (chip.height_mm, below.height_mm) == pytest.approx((0.5, 1.0))
    assert chip.footprint.equals(box(10, 10, 12, 11.25))
    assert chip.area_mm2 == pytest.approx(2.5)
    assert chip.outline.symmetric_difference(chip.footprint).area < 1e-4


def test_what_is_stated_wins_and_what_is_assumed_says_from_where() -> None:
    below, chip, other, soic = understand([BOARD, CHIP, FAR_CHIP, BELOW, SOIC], "attributes").components
    assert (other.pins, other.pins_source, other.gap_height_mm, other.gap_height_source) == (
        2,
        "stated",
        None,
        "unknown",
    )
    assert (below.pins, below.pins_source) == (0, "unknown")
    assert (below.gap_height_mm, below.gap_height_source) == (0.07, "stated")
    assert (chip.pins, chip.pins_source) == (2, "package R_0805_2012Metric")
    assert soic.pins == 8
    assert soic.gap_height_mm is not None
    assert soic.gap_height_source.startswith("family SOIC (")


def test_an_outline_closes_the_gaps_between_pins_and_a_footprint_does_not() -> None:
    (soic,) = understand([BOARD, SOIC], "pins").components
    assert soic.area_mm2 == pytest.approx(20 + 8 * 0.4)
    assert soic.outline.symmetric_difference(box(39, 30.4, 45, 35.01 - 0.4).union(box(40, 30, 44, 35))).area < 0.02
    assert soic.outline.buffer(1e-3).covers(soic.footprint)


def test_a_component_in_pieces_becomes_one() -> None:
    parts = body("J1", (20, 20, 1.6, 22, 22, 4), (25, 20, 1.6, 27, 22, 4))
    (joined,) = understand([BOARD, parts], "pieces").components
    assert isinstance(joined.footprint, Polygon)
    assert joined.footprint.symmetric_difference(box(20, 20, 27, 22)).area < 1e-3


def test_a_through_hole_part_stands_where_more_of_it_is_and_is_in_the_way_on_both_sides() -> None:
    header = body("P1", (30, 60, 1.6, 40, 62.5, 10), (31, 61, -2, 31.6, 61.6, 1.6))
    clamp = body("clamp", (-5, 30, -4, 3, 40, 8), role="fixture")
    board = understand([BOARD, header, clamp], "tht")
    assert [one.name for one in board.components] == ["P1"]
    assert board.components[0].side == "top"
    tops = {one.name: one.height_mm for one in board.obstacles("top")}
    bottoms = {one.name: one.height_mm for one in board.obstacles("bottom")}
    assert tops == pytest.approx({"P1": 8.4, "clamp": 6.4})
    assert bottoms == pytest.approx({"P1": 2.0, "clamp": 4.0})
    assert board.obstacles("bottom")[0].outline.equals(box(30, 60, 40, 62.5))


def test_an_obstacle_holds_its_whole_body() -> None:
    turns = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    rim = np.column_stack((20 + 5 * np.cos(turns), 20 + 5 * np.sin(turns), np.full(48, 9.0)))
    round_ = np.stack([np.full((48, 3), (20.0, 20.0, 9.0)), rim, np.roll(rim, -1, axis=0)], axis=1)
    can = Body("C9", "component", round_, areas_and_normals(round_)[1], (Surface("1", 48),), side="top")
    board = understand([BOARD, can], "round")
    points = shapely.points(round_[:, :, :2].reshape(-1, 2))
    assert shapely.distance(points, board.top_obstacles[0].outline).max() < 2e-3
    footprint = board.components[0].footprint
    assert shapely.distance(points, footprint).max() <= 0.05
    assert len(footprint.exterior.coords) < 48


def test_neighbours_are_of_the_same_side_and_nearest_first() -> None:
    below, chip, other, soic = understand([BOARD, CHIP, FAR_CHIP, BELOW, SOIC], "near").components
    assert chip.neighbours[0] == ("R2", 1.5)
    assert [name for name, _ in chip.neighbours] == ["R2", "U1"]
    assert other.neighbour_mm == 1.5
    assert below.neighbours == ()
    assert below.neighbour_mm == float("inf")
    assert soic.neighbours[0][0] == "R2"


def test_a_crowd_keeps_its_six_nearest() -> None:
    crowd = [body(f"R{i}", (3.0 * i, 10, 1.6, 3 * i + 2, 11, 2)) for i in range(20)]
    parts = understand([BOARD, *crowd], "crowd").components
    assert parts[0].neighbours == tuple((f"R{i}", pytest.approx(3.0 * i - 2)) for i in range(1, 7))
    assert [name for name, _ in parts[10].neighbours] == ["R9", "R11", "R8", "R12", "R7", "R13"]


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 2, 2.5, -1.234])
def test_a_moved_board_is_understood_the_same(angle: float) -> None:
    shift = (123.456, -78.9, 1 / 3)
    bodies = [BOARD, CHIP, FAR_CHIP, BELOW, SOIC, *moved([CHIP], 0.7, (30, 10, 0))]
    bodies[-1] = replace(bodies[-1], name="R3")
    one, other = understand(bodies, "here"), understand(moved(bodies, angle, shift), "there")
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def check(polygon: Polygon, expected: Polygon) -> None:
        points = shapely.get_coordinates(expected) @ turn.T + shift[:2]
        np.testing.assert_allclose(shapely.get_coordinates(polygon), points, atol=1e-9)

    check(other.outline, one.outline)
    np.testing.assert_allclose(other.axis, turn @ one.axis, atol=1e-12)
    for there, here in zip(other.components, one.components, strict=True):
        check(there.footprint, here.footprint)
        check(there.outline, here.outline)
        assert (there.side, there.neighbours) == (here.side, here.neighbours)
        assert there.height_mm == pytest.approx(here.height_mm)
    for there, here in zip(other.top_obstacles, one.top_obstacles, strict=True):
        check(there.outline, here.outline)


def test_the_fingerprint_is_of_the_content(tmp_path: pytest.TempPathFactory) -> None:
    board = understand([BOARD, SOIC], "one")
    file = tmp_path / "b.tri"  # type: ignore[operator]
    file.write_text(write_tri(board.bodies))
    again = understand(read_tri(file)[0], "another name")
    assert again.sha256 == board.sha256
    assert understand([BOARD, CHIP], "one").sha256 != board.sha256


def test_no_board_and_two_boards_are_refused() -> None:
    assert "no board" in refuse(CHIP)
    assert "2 boards" in refuse(BOARD, replace(BOARD, name="b2"))


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1e-3, "metres. Write 'units m'"),
        (1 / 25.4, "inches. Write 'units in'"),
        (25.4, "millimetres read as inches"),
        (1e5, "no circuit board"),
    ],
)
def test_wrong_units_are_guessed_and_said(factor: float, words: str) -> None:
    assert words in refuse(replace(BOARD, patches=BOARD.patches * factor))


def test_a_thin_flexible_board_is_a_board() -> None:
    thin = replace(BOARD, patches=BOARD.patches * (1, 1, 0.05 / 1.6))
    assert understand([thin], "flex").top_z_mm == pytest.approx(0.05)


@pytest.mark.parametrize(("axes", "words"), [((2, 0, 1), "along x"), ((0, 2, 1), "along y")])
def test_a_board_on_its_edge_is_refused(axes: tuple[int, int, int], words: str) -> None:
    assert words in refuse(replace(BOARD, patches=BOARD.patches[:, :, axes]))


@pytest.mark.parametrize("degrees", [0.3, 2.0, 45.0])
def test_a_tilted_board_is_refused(degrees: float) -> None:
    angle = np.radians(degrees)
    turn = np.array([[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]])
    assert "level" in refuse(replace(BOARD, patches=BOARD.patches @ turn.T))


def test_a_board_without_thickness_is_refused() -> None:
    sheet = BOARD.patches[BOARD.patches[:, :, 2].min(axis=1) > 1]
    assert "no thickness" in refuse(replace(BOARD, patches=sheet, normals=sheet[:, 0]))


@pytest.mark.parametrize(
    ("across_mm", "thick_mm", "words"),
    [
        (3.0, 1.6, None),  # a flex tail's stiffener
        (2.9, 1.6, "no circuit board"),
        (2500.0, 20.0, None),
        (2501.0, 1.6, "no circuit board"),
        (100.0, 20.1, "no circuit board"),
        (100.0, 0.021, None),
        (100.0, 0.019, "no circuit board"),
        (0.1, 0.0016, "looks like metres"),
        (4.0, 0.063, "looks like inches"),
        (1500.0, 40.0, "millimetres read as inches"),
    ],
)
def test_sizes_that_are_no_boards_are_refused_with_their_unit(
    across_mm: float, thick_mm: float, words: str | None
) -> None:
    slab = body("board", (0, 0, 0, 0.6 * across_mm, 0.8 * across_mm, thick_mm), role="board")
    if words is None:
        assert understand([slab], "sized").top_z_mm == thick_mm
    else:
        assert words in refuse(slab)


def test_a_board_narrower_than_the_grid_is_refused() -> None:
    hair = body("board", (0, 0, 0, 60, 1e-7, 1.6), role="board")
    level = np.ptp(hair.patches[:, :, 2], axis=1) == 0.0
    assert "has no area seen from above" in refuse(
        replace(hair, patches=hair.patches[level], normals=hair.normals[level], surfaces=(Surface("1", 4),))
    )


def test_a_board_upside_down_is_said() -> None:
    over = [replace(one, patches=one.patches * (1, -1, -1)) for one in (BOARD, CHIP, FAR_CHIP)]
    assert "upside down" in refuse(*over)


def test_a_board_with_everything_below_may_be_upside_down() -> None:
    over = [replace(one, patches=one.patches * (1, -1, -1), side=None) for one in (BOARD, CHIP, FAR_CHIP)]
    assert [finding.rule.id for finding in understand(over, "over").findings] == ["all-on-bottom"]
    stated = [replace(one, side=None if one.role == "board" else "bottom") for one in over]
    assert understand(stated, "stated").findings == ()
    assert understand([BOARD, BELOW], "one part").findings == ()


def test_a_component_below_its_surface_is_refused_by_name() -> None:
    assert refuse(BOARD, CHIP, FAR_CHIP, replace(BELOW, side="top")).startswith("C1 has no height above the top")
    assert "R9" in refuse(BOARD, body("R9", (10, 10, 0.2, 12, 12, 1.6)))


def test_a_sliver_has_no_area() -> None:
    # It has one until its corners are rounded to the grid.
    triangle = np.array([[[50.5, 68.0, 1.6], [35.8, 67.9, 1.6], [43.885, 67.955, 2.0]]])
    sliver = Body("R7", "component", triangle, areas_and_normals(triangle)[1], (Surface("1", 1),))
    assert refuse(BOARD, sliver) == "R7 has no area as seen from the top. Correct its model or leave it out."


def test_components_in_strange_places_are_noticed() -> None:
    away = body("R7", (120, 10, 1.6, 122, 11, 2))
    high = body("R8", (20, 20, 9, 22, 21, 10))
    sunk = body("R9", (30, 20, 0.5, 32, 21, 1.7))
    overhang = body("J1", (95, 20, 1.6, 110, 30, 8))
    findings = understand([BOARD, away, high, sunk, overhang], "strange").findings
    assert [finding.rule.id for finding in findings] == ["component-outside", "component-floating", "component-sunk"]
    assert [finding.message[:2] for finding in findings] == ["R7", "R8", "R9"]
    assert all(finding.where is not None for finding in findings)


def test_a_body_beside_its_pads_is_noticed() -> None:
    ends = (Pad(10.2, 10.6, 0.6, 1.2), Pad(11.8, 10.6, 0.6, 1.2))
    under = replace(CHIP, pads=ends)
    beside = replace(FAR_CHIP, pads=tuple(replace(pad, y_mm=pad.y_mm + 9.0) for pad in ends))
    (found,) = understand([BOARD, under, beside], "off").findings
    assert (found.rule.id, found.severity) == ("component-off-pads", "warning")
    assert found.message.startswith("R2 lies 8.5 mm beside its pads.")


def test_components_that_mostly_lie_outside_are_one_error() -> None:
    parts = [body(f"R{n}", (90 + 20 * n, 10, 1.6, 92 + 20 * n, 11, 2)) for n in range(4)]
    (found,) = understand([BOARD, *parts], "foreign").findings
    assert (found.rule.id, found.severity) == ("component-outside", "error")
    assert found.message.startswith("3 components, the worst R3, which lies 50.0 mm outside")


def test_a_board_in_pieces_is_joined_and_said() -> None:
    panel = body("board", (0, 0, 0, 50, 40, 1.6), (52, 0, 0, 100, 40, 1.6), role="board")
    board = understand([panel], "panel")
    assert [finding.rule.id for finding in board.findings] == ["board-in-pieces", "no-components"]
    assert board.outline.area == pytest.approx(4000, rel=1e-4)


def test_the_gap_between_boards_is_no_board() -> None:
    pair = body("board", (0, 0, 0, 40, 30, 1.6), (50, 0, 0, 70, 30, 1.6), role="board")
    assert understand([pair], "pair").outline.area == pytest.approx(1800, abs=1.0)
    corner = body("board", (0, 0, 0, 40, 30, 1.6), (50, 0, 0, 70, 30, 1.6), (20, 50, 0, 40, 60, 1.6), role="board")
    assert understand([corner], "three").outline.area == pytest.approx(2000, abs=2.0)


def test_the_same_bodies_give_the_same_board() -> None:
    def tell(board: Board) -> str:
        return repr([(one.footprint.wkt, one.outline.wkt, one.neighbours) for one in board.components])

    assert tell(understand([BOARD, SOIC, CHIP], "a")) == tell(understand([BOARD, SOIC, CHIP], "a"))
