"""Pads: read from KiCad, carried in a board file, turned into joints beneath the body."""

import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.board import Board, Body, Pad, Surface
from boards.errors import BoardError
from boards.formats.kicad.kicad import read_kicad
from boards.formats.tri.tri import read_tri, write_tri
from boards.undersides.body_rectangle import Rectangle
from boards.undersides.joints import joints_amid, joints_under
from boards.undersides.underside import Underside, coverage, undersides_of
from boards.understand import understand

CORNERS = [(0, 0), (40, 0), (40, 30), (0, 30), (0, 0)]
EDGE = "\n".join(
    f'(gr_line (start {a[0]} {a[1]}) (end {b[0]} {b[1]}) (layer "Edge.Cuts"))' for a, b in pairwise(CORNERS)
)
SQUARE = Rectangle(0.0, 0.0, 0.0, 4.0, 2.0)


def kicad(*footprints: str) -> str:
    return f"(kicad_pcb (version 20221018) (general (thickness 1.6))\n{EDGE}\n" + "\n".join(footprints) + "\n)\n"


def footprint(package: str, half: tuple[float, float], pads: str, at: str = "20 15", side: str = "F") -> str:
    x, y = half
    return (
        f'(footprint "L:{package}" (layer "{side}.Cu") (at {at}) (property "Reference" "U1")'
        f' (fp_rect (start {-x} {-y}) (end {x} {y}) (layer "{side}.Fab"))\n{pads})'
    )


def qfn(turn: float, side: str = "F") -> str:
    """A QFN of 16 lands; a pad's angle in the file is its own and the footprint's."""
    rows: list[str] = []
    for number in range(16):
        row, step = divmod(number, 4)
        along = -0.75 + 0.5 * step
        x, y = [(-1.45, along), (along, 1.45), (1.45, -along), (-along, -1.45)][row]
        angle = turn if row % 2 == 0 else turn + 90
        place = f"(at {x} {y} {angle}) (size 0.85 0.25)"
        rows.append(f'(pad "{number + 1}" smd roundrect {place} (layers "{side}.Cu" "{side}.Mask"))')
    rows.append(f'(pad "17" smd rect (at 0 0 {turn}) (size 1.7 1.5) (layers "{side}.Cu" "{side}.Mask"))')
    rows += [f'(pad "" smd rect (at {x} 0 {turn}) (size 0.7 0.7) (layers "{side}.Paste"))' for x in (-0.4, 0.4)]
    rows += ['(pad "17" thru_hole circle (at 0.5 0) (size 0.5 0.5) (drill 0.2) (layers "*.Cu"))']
    return footprint("QFN-16-1EP_3x3mm_P0.5mm", (1.5, 1.5), "\n".join(rows), f"20 15 {turn}", side)


def read(folder: Path, text: str) -> tuple[Body, ...]:
    (folder / "b.kicad_pcb").write_text(text, encoding="utf-8")
    return read_kicad(folder / "b.kicad_pcb")[0]


def board_of(folder: Path, text: str) -> Board:
    return understand(read(folder, text), "b")


def beneath(folder: Path, text: str) -> Underside:
    (one,) = undersides_of(board_of(folder, text))
    return one


@pytest.mark.parametrize("side", ["F", "B"])
def test_pads_that_are_soldered_flat_on_the_own_side_are_read(tmp_path: Path, side: str) -> None:
    pads = read(tmp_path, kicad(qfn(0.0, side)))[1].pads
    assert len(pads) == 17
    heat = pads[-1]
    assert (heat.x_mm, heat.y_mm, heat.length_mm, heat.width_mm, heat.round) == (20.0, -15.0, 1.7, 1.5, False)
    assert (pads[0].x_mm, pads[0].y_mm) == pytest.approx((18.55, -14.25))


def test_pads_of_other_sides_holes_and_contacts_are_left_out(tmp_path: Path) -> None:
    pads = """(pad "1" smd rect (at 1 0) (size 1 1) (layers "B.Cu"))
        (pad "2" connect rect (at 1 0) (size 1 1) (layers "F.Cu"))
        (pad "3" thru_hole rect (at 1 0) (size 1 1) (drill 0.5) (layers "*.Cu"))
        (pad "4" smd rect (at 1 0) (size 0 1) (layers "F.Cu"))
        (pad "5" smd rect (at 1 0) (size 1 1) (layers "F.Paste"))"""
    assert read(tmp_path, kicad(footprint("SOT-23", (2, 2), pads)))[1].pads == ()


def test_old_and_new_files_have_the_same_pads() -> None:
    data = Path(__file__).parents[1] / "data"
    old, new = (read_kicad(data / f"small_{version}.kicad_pcb")[0] for version in ("v5", "v9"))
    assert [len(body.pads) for body in new] == [0, 8, 2, 0]
    assert [body.pads for body in old] == [body.pads for body in new]


def test_shapes_offsets_and_free_forms_are_boxed(tmp_path: Path) -> None:
    pads = """(pad "1" smd circle (at 1 0) (size 0.6 0.6) (layers "F.Cu"))
        (pad "2" smd oval (at -1 0) (size 0.6 1.2) (layers "F.Cu"))
        (pad "3" smd rect (at 0 0 90) (size 1 0.5) (drill (offset 0.3 0)) (layers "F.Cu"))
        (pad "4" smd custom (at 0 1) (size 0.2 0.2) (layers "F.Cu") (options (anchor rect))
          (primitives (gr_poly (pts (xy -0.5 -0.1) (xy 0.7 -0.1) (xy 0.7 0.3)) (width 0))))"""
    round_, oval, beside, free = read(tmp_path, kicad(footprint("SOT-23", (2, 2), pads)))[1].pads
    assert (round_.round, oval.round) == (True, False)
    assert (oval.length_mm, oval.width_mm) == (0.6, 1.2)
    assert (beside.x_mm, beside.y_mm, beside.turn_rad) == pytest.approx((20.0, -14.7, math.pi / 2))
    assert (free.length_mm, free.width_mm) == pytest.approx((1.2, 0.4))
    assert (free.x_mm, free.y_mm) == pytest.approx((20.1, -16.1))


@pytest.mark.parametrize("side", ["F", "B"])
@pytest.mark.parametrize("turn", [0.0, 30.0, 90.0, 180.0, 225.0])
def test_the_joints_of_a_turned_part_are_those_of_the_part(tmp_path: Path, turn: float, side: str) -> None:
    one = beneath(tmp_path, kicad(qfn(turn, side)))
    assert one.joints_source == "board file"
    joints = one.cases[0].joints
    assert len(joints) == 17
    assert (one.length_mm, one.width_mm) == pytest.approx((3.0, 3.0), abs=1e-3)
    assert sorted((joints[-1].length_mm, joints[-1].width_mm)) == pytest.approx([1.5, 1.7])
    # Of a land 0.85 mm long, 0.475 mm lie beneath the body.
    assert coverage(one.cases[0], one) == pytest.approx((1.7 * 1.5 + 16 * 0.475 * 0.25) / 9.0, rel=1e-3)
    assert {round(abs(joint.turn_rad), 6) for joint in joints} == {0.0}


def test_leads_beside_the_body_do_not_reach_under_it(tmp_path: Path) -> None:
    legs = "\n".join(
        f'(pad "{n}" smd rect (at {x} {y}) (size 1.9 0.6) (layers "F.Cu"))'
        for n, (x, y) in enumerate([(-2.5, -1.9), (-2.5, 1.9), (2.5, 1.9), (2.5, -1.9)])
    )
    plain = beneath(tmp_path, kicad(footprint("SOIC-8_3.9x4.9mm_P1.27mm", (1.95, 2.45), legs)))
    assert (plain.cases[0].joints, plain.joints_source) == ((), "board file")
    heat = legs + '(pad "9" smd rect (at 0 0) (size 2 3) (layers "F.Cu"))'
    (joint,) = beneath(tmp_path, kicad(footprint("HSOIC-8-1EP", (1.95, 2.45), heat))).cases[0].joints
    assert (joint.length_mm, joint.width_mm) == (3.0, 2.0)


def test_solder_under_a_chip_ends_with_its_terminations(tmp_path: Path) -> None:
    pads = "".join(f'(pad "{n}" smd rect (at {x} 0) (size 1.4 1.3) (layers "F.Cu"))' for n, x in ((1, -0.9), (2, 0.9)))
    one = beneath(tmp_path, kicad(footprint("C_0805_2012Metric", (1.0, 0.625), pads)))
    assert [joint.x_mm for joint in one.cases[0].joints] == [-0.7, 0.7]
    assert coverage(one.cases[0], one) == pytest.approx(0.6)
    short = beneath(tmp_path, kicad(footprint("C_0805_2012Metric", (1.0, 0.625), pads.replace("1.4 1.3", "0.6 1.3"))))
    assert coverage(short.cases[0], short) == pytest.approx(0.4)


def test_pads_far_from_a_leadless_body_are_not_believed(tmp_path: Path) -> None:
    pads = (
        '(pad "1" smd rect (at -9 0) (size 1 1) (layers "F.Cu")) (pad "2" smd rect (at 9 0) (size 1 1) (layers "F.Cu"))'
    )
    one = beneath(tmp_path, kicad(footprint("R_0805_2012Metric", (1, 0.6), pads)))
    assert "family" in one.joints_source
    assert len(one.cases[0].joints) == 2


def test_a_board_file_carries_pads(tmp_path: Path) -> None:
    bodies = read(tmp_path, kicad(qfn(30.0)))
    text = write_tri(bodies)
    (tmp_path / "b.tri").write_text(text)
    again = read_tri(tmp_path / "b.tri")[0]
    assert write_tri(again) == text
    assert len(again[1].pads) == 17
    straight, carried = understand(bodies, "b"), understand(again, "b")
    assert straight.sha256 == carried.sha256
    assert coverage(undersides_of(straight)[0].cases[0], undersides_of(straight)[0]) == pytest.approx(
        coverage(undersides_of(carried)[0].cases[0], undersides_of(carried)[0]), rel=1e-3
    )


def test_pads_are_part_of_the_fingerprint(tmp_path: Path) -> None:
    bodies = read(tmp_path, kicad(qfn(0.0)))
    without = (bodies[0], replace(bodies[1], pads=()))
    assert understand(bodies, "b").sha256 != understand(without, "b").sha256
    assert "pads=" not in write_tri(without)


NUMBER = st.floats(-500.0, 500.0)
SIZE = st.floats(0.001, 50.0)
PADS = st.lists(st.builds(Pad, NUMBER, NUMBER, SIZE, SIZE, st.floats(-7.0, 7.0), st.booleans()), max_size=5)


@pytest.mark.slow
@settings(max_examples=50)
@given(pads=PADS, unit=st.sampled_from(["mm", "m", "in"]))
def test_pads_read_back_as_they_were_written(
    tmp_path_factory: pytest.TempPathFactory, pads: list[Pad], unit: str
) -> None:
    folder = tmp_path_factory.getbasetemp()
    triangle = np.array([[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    body = Body("b", "board", triangle, np.array([[0.0, 0.0, 1.0]]), (Surface("1", 1),), pads=tuple(pads))
    (folder / "p.tri").write_text(write_tri([body]))
    again = read_tri(folder / "p.tri")[0]
    assert write_tri(again) == write_tri([body])
    for one, other in zip(pads, again[0].pads, strict=True):
        assert (other.x_mm, other.width_mm) == pytest.approx((one.x_mm, one.width_mm), abs=1e-4)
        assert other.round == one.round
    (folder / "p.tri").write_text(write_tri([body]).replace("units mm", f"units {unit}"))
    factor = {"mm": 1.0, "m": 1000.0, "in": 25.4}[unit]
    for one, other in zip(again[0].pads, read_tri(folder / "p.tri")[0][0].pads, strict=True):
        assert (other.y_mm, other.length_mm) == pytest.approx((factor * one.y_mm, factor * one.length_mm))
        assert other.turn_rad == one.turn_rad


@pytest.mark.parametrize(
    "wrong", ["1,2,3,4,0", "1,2,3,4,0,oval", "1,2,0,4,0,rect", "a,2,3,4,0,rect", "nan,2,3,4,0,rect", ";"]
)
def test_a_wrong_pad_is_refused_with_its_line(tmp_path: Path, wrong: str) -> None:
    rows = "surface 1 patches 1\n0 0 0 9 0 0 0 9 0 0 0 1\n"
    text = f"board-tri 1\nunits mm\nobjects 1\nobject b surfaces 1 role=board pads={wrong}\n{rows}"
    (tmp_path / "b.tri").write_text(text)
    with pytest.raises(BoardError, match=r"b\.tri:4: pad .* of b: write x,y,length,width,degrees,rect"):
        read_tri(tmp_path / "b.tri")


def test_a_pad_is_cut_off_at_the_edge_of_the_body() -> None:
    (joint,) = joints_under([Pad(2.0, 0.0, 1.0, 3.0)], SQUARE)
    assert (joint.x_mm, joint.y_mm, joint.length_mm, joint.width_mm) == (1.75, 0.0, 0.5, 2.0)
    (turned,) = joints_under([Pad(2.0, 0.0, 3.0, 1.0, math.pi / 2)], SQUARE)
    assert turned == joint
    assert joints_under([Pad(2.5, 0.0, 1.0, 1.0)], SQUARE) == ()


def test_round_and_askew_pads_count_as_a_whole_or_not_at_all() -> None:
    ball, askew = Pad(1.9, 0.0, 0.5, 0.5, 0.0, True), Pad(0.0, 0.5, 1.0, 0.2, 0.3)
    joints = joints_under([ball, askew, replace(ball, x_mm=2.1), replace(askew, y_mm=1.05)], SQUARE)
    assert [(joint.round, joint.length_mm, joint.turn_rad) for joint in joints] == [(True, 0.5, 0.0), (False, 1.0, 0.3)]


def test_pads_whose_middle_is_beside_the_body_belong_to_leads() -> None:
    inside, beside = Pad(1.0, 0.0, 1.0, 1.0), Pad(2.0, 0.0, 1.0, 1.0)
    assert len(joints_under([inside, beside], SQUARE)) == 2
    assert len(joints_amid([inside, beside], SQUARE)) == 1


@settings(max_examples=50)
@given(angle=st.floats(-3.0, 3.0), x=st.floats(-100.0, 100.0), y=st.floats(-100.0, 100.0))
def test_joints_turn_with_the_board(angle: float, x: float, y: float) -> None:
    pads = [Pad(1.8, 0.3, 1.0, 0.5), Pad(-0.5, 0.2, 0.4, 0.4, 0.0, True), Pad(0.5, -0.5, 0.8, 0.2, 0.6)]
    cos, sin = math.cos(angle), math.sin(angle)
    moved = [
        replace(
            pad,
            x_mm=cos * pad.x_mm - sin * pad.y_mm + x,
            y_mm=sin * pad.x_mm + cos * pad.y_mm + y,
            turn_rad=pad.turn_rad + angle,
        )
        for pad in pads
    ]
    assert joints_under(moved, replace(SQUARE, x_mm=x, y_mm=y, turn_rad=angle)) == joints_under(pads, SQUARE)


def legs(size: str) -> str:
    spots = [(x, round(-1.905 + 1.27 * n, 3)) for x in (-2.7, 2.7) for n in range(4)]
    return "\n".join(
        f'(pad "{n}" smd rect (at {x} {y}) (size {size}) (layers "F.Cu"))' for n, (x, y) in enumerate(spots)
    )


def test_an_outline_around_the_leads_is_cut_back_to_what_lies_between_their_pads(tmp_path: Path) -> None:
    boxed = beneath(tmp_path, kicad(footprint("SOIC-8", (3.4, 2.2), legs("1.5 0.6"))))
    assert (boxed.length_mm, boxed.width_mm) == pytest.approx((4.4, 3.9))
    assert abs(math.sin(boxed.turn_rad)) == pytest.approx(1.0)
    assert boxed.cases[0].joints == ()
    drawn = beneath(tmp_path, kicad(footprint("SOIC-8", (2.0, 2.5), legs("1.5 0.6"))))
    assert (drawn.length_mm, drawn.width_mm) == pytest.approx((5.0, 4.0))


def test_the_heat_pad_stays_where_leads_are_cut_off(tmp_path: Path) -> None:
    heat = '(pad "9" smd rect (at 0 0) (size 2 3) (layers "F.Cu"))'
    one = beneath(tmp_path, kicad(footprint("HSOIC-8-1EP", (3.4, 2.2), legs("1.5 0.6") + heat)))
    (joint,) = one.cases[0].joints
    assert (one.length_mm, one.width_mm) == pytest.approx((4.4, 3.9))
    assert (joint.length_mm, joint.width_mm) == (3.0, 2.0)


@pytest.mark.parametrize(
    ("package", "half", "size"),
    [
        ("C_0805", (1.8, 0.7), (2.0, 1.25)),
        ("SOT-23", (1.2, 1.45), (2.9, 1.3)),
        ("SOT-223", (3.5, 3.25), (6.5, 3.5)),
        ("D_SOD-323", (1.5, 0.8), (1.7, 1.25)),
        ("D_SMA", (3.5, 1.3), (4.3, 2.6)),
        ("C_0805", (1.05, 0.65), (2.1, 1.3)),
    ],
)
def test_an_outline_much_larger_than_the_package_is_not_its_body(
    tmp_path: Path, package: str, half: tuple[float, float], size: tuple[float, float]
) -> None:
    hidden = '(pad "1" smd rect (at 9 9) (size 1 1) (layers "B.Cu"))'
    one = beneath(tmp_path, kicad(footprint(package, half, hidden)))
    assert (one.length_mm, one.width_mm) == pytest.approx(size)
