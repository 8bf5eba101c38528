"""KiCad boards: old and new words say the same board, and the frame is ours."""

import math
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.board import NOMINAL_HEIGHT, Body
from boards.errors import BoardError
from boards.formats.kicad.kicad import read_kicad
from boards.packages.families import package_family

DATA = Path(__file__).parents[2] / "data"
OLD = (DATA / "small_v5.kicad_pcb").read_text(encoding="utf-8")
NEW = (DATA / "small_v9.kicad_pcb").read_text(encoding="utf-8")


def read(folder: Path, text: str) -> dict[str, Body]:
    (folder / "b.kicad_pcb").write_text(text, encoding="utf-8")
    return {body.name: body for body in read_kicad(folder / "b.kicad_pcb")[0]}


def messages(folder: Path, text: str) -> dict[str, str]:
    (folder / "b.kicad_pcb").write_text(text, encoding="utf-8")
    return {note.rule.id: note.message for note in read_kicad(folder / "b.kicad_pcb")[1]}


def extent(body: Body) -> np.ndarray:
    points = body.patches.reshape(-1, 3)
    return np.array([points.min(axis=0), points.max(axis=0)])


def volume(body: Body) -> float:
    a, b, c = body.patches[:, 0], body.patches[:, 1], body.patches[:, 2]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def edge_only(*items: str) -> str:
    return "(kicad_pcb (version 20221018) (general (thickness 1.6))\n" + "\n".join(items) + "\n)\n"


def line(*ends: float) -> str:
    return '(gr_line (start {} {}) (end {} {}) (layer "Edge.Cuts"))'.format(*ends)


SQUARE = (line(0, 0, 20, 0), line(20, 0, 20, 10), line(20, 10, 0, 10), line(0, 10, 0, 0))


def test_old_and_new_files_hold_the_same_board(tmp_path: Path) -> None:
    old, new = read(tmp_path, OLD), read(tmp_path, NEW)
    assert list(old) == list(new) == ["board", "U1", "C1", "X1"]
    for name, body in old.items():
        np.testing.assert_allclose(extent(new[name]), extent(body), atol=1e-6)
        assert volume(new[name]) == pytest.approx(volume(body), rel=1e-6)
        assert (new[name].package, new[name].pins, new[name].side) == (body.package, body.pins, body.side)
        assert new[name].value == body.value
    assert new["C1"].part == "CL21B104"


@pytest.mark.parametrize("text", [OLD, NEW])
def test_the_board_has_its_rounded_corner_cut_out_and_drilled_holes(tmp_path: Path, text: str) -> None:
    board = read(tmp_path, text)["board"]
    area = 40 * 35 - (1 - math.pi / 4) * 5**2 - math.pi * 3**2
    drilled = math.pi * 1.6**2 + math.pi * 0.55**2 + math.pi * 0.6**2 + 1.2 * 1.8
    assert volume(board) == pytest.approx((area - drilled) * 1.2, rel=2e-3)
    np.testing.assert_allclose(extent(board), [[100, -85, 0], [140, -50, 1.2]], atol=0.01)


def test_a_component_stands_on_its_side_with_its_nominal_height(tmp_path: Path) -> None:
    bodies = read(tmp_path, NEW)
    family = package_family("SOIC-8_3.9x4.9mm_P1.27mm")
    assert family is not None
    top, bottom = extent(bodies["U1"]), extent(bodies["C1"])
    assert top[1][2] == pytest.approx(1.2 + family.height_mm)
    assert top[0][2] == pytest.approx(1.2 + (family.gap_height_mm or 0.0))
    assert bottom[1][2] <= 0.0
    assert bottom[0][2] < -0.3
    assert (bodies["U1"].side, bodies["C1"].side) == ("top", "bottom")
    assert bodies["U1"].gap_height_mm is None
    assert bodies["U1"].extra == (("x-height", "family SOIC (JEDEC MS-012)"),)


@pytest.mark.parametrize(("stated", "height_mm", "doubt"), [("1.3 mm", 1.3, False), ("50.8", 1.75, True)])
def test_a_height_among_the_properties_is_checked(tmp_path: Path, stated: str, height_mm: float, doubt: bool) -> None:
    text = re.sub(r'(\(property "Value" "LM358")', rf'(property "Height" "{stated}" (at 0 0) (layer "F.Fab"))\n\1', NEW)
    assert text != NEW
    assert extent(read(tmp_path, text)["U1"])[1][2] == pytest.approx(1.2 + height_mm)
    assert ("U1 (50.8 mm stated, 1.75 mm taken" in messages(tmp_path, text).get("doubtful-height", "")) == doubt


def test_the_body_is_the_fabrication_drawing_turned_with_the_footprint(tmp_path: Path) -> None:
    body = read(tmp_path, NEW)["U1"]
    # 3.9 wide and 4.9 long, turned by 90°: long in x now. The bevel of pin 1 was front left, and goes to the left back.
    np.testing.assert_allclose(extent(body)[:, :2], [[107.55, -61.95], [112.45, -58.05]], atol=1e-3)
    corners = {tuple(np.round(point, 3)) for point in body.patches.reshape(-1, 3)[:, :2]}
    assert (107.55, -61.95) not in corners
    assert {(107.55, -60.95), (108.55, -61.95)} <= corners
    assert (body.package, body.pins, body.value) == ("SOIC-8_3.9x4.9mm_P1.27mm", 8, "LM358")


def test_without_a_drawing_the_courtyard_is_shrunk_and_at_last_the_pads_are_boxed(tmp_path: Path) -> None:
    bodies = read(tmp_path, NEW)
    np.testing.assert_allclose(extent(bodies["C1"])[:, :2], [[118.57, -70.7], [121.43, -69.3]], atol=1e-6)
    np.testing.assert_allclose(extent(bodies["X1"])[:, :2], [[128, -77], [134, -73]], atol=1e-6)
    assert bodies["X1"].pins == 1
    notes = messages(tmp_path, NEW)
    assert "X1" in notes["outline-from-pads"]
    assert dict(bodies["X1"].extra) == {NOMINAL_HEIGHT: "assumed tall"}
    assert extent(bodies["X1"])[1][2] == pytest.approx(1.2 + 25.0)


def test_what_carries_no_body_is_listed(tmp_path: Path) -> None:
    for text in (OLD, NEW):
        assert messages(tmp_path, text)["no-body"].startswith("2 footprints")
        assert "G1, H1" in messages(tmp_path, text)["no-body"]


def test_a_part_that_is_not_mounted_is_left_out(tmp_path: Path) -> None:
    assert "U1" not in read(tmp_path, NEW.replace("(attr smd)", "(attr smd dnp)"))


def test_a_repeated_reference_gets_a_number(tmp_path: Path) -> None:
    assert list(read(tmp_path, NEW.replace('"C1"', '"U1"'))) == ["board", "U1", "U1-2", "X1"]


@pytest.mark.parametrize(
    ("turn_deg", "shift"), [(0.0, (-300.0, 17.25)), (90.0, (0.0, 0.0)), (31.0, (12.3456, -7.891)), (197.5, (3.0, 4.0))]
)
def test_a_board_that_was_moved_has_the_same_vertices_moved(
    tmp_path: Path, turn_deg: float, shift: tuple[float, float]
) -> None:
    """KiCad's y points down, so turning to the left on the screen is turning to the left in our frame."""
    turn = math.radians(turn_deg)
    matrix = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])

    def moved(match: re.Match[str]) -> str:
        x, y = np.array([float(match[2]), -float(match[3])]) @ matrix + shift
        return f"({match[1]} {x:.9f} {-y:.9f}"

    lines: list[str] = []
    for text in NEW.splitlines():
        if text.strip().startswith("(gr_"):
            text = re.sub(r"\((start|mid|end|center) ([-\d.]+) ([-\d.]+)", moved, text)
        elif text.startswith("    (at "):
            x, y, *angle = text.strip(" ()at").split()
            start = re.sub(r"\((at) ([-\d.]+) ([-\d.]+)", moved, f"(at {x} {y}")
            text = f"    {start} {float(angle[0]) + turn_deg if angle else turn_deg})"
        elif text.strip().startswith("(pad "):
            found = re.search(r"\(at ([-\d.]+) ([-\d.]+) ?([-\d.]*)\)", text)
            assert found is not None
            text = text.replace(found[0], f"(at {found[1]} {found[2]} {float(found[3] or 0) + turn_deg})")
        lines.append(text)
    before, after = read(tmp_path, NEW), read(tmp_path, "\n".join(lines))
    assert list(before) == list(after)
    for name, body in before.items():
        sides = body.surfaces[2].patches
        was, now = body.patches[-sides:], after[name].patches[-sides:]
        np.testing.assert_allclose(now[:, :, :2], was[:, :, :2] @ matrix + shift, atol=1e-5)
        np.testing.assert_allclose(now[:, :, 2], was[:, :, 2], atol=1e-9)


def test_edges_in_any_order_and_direction_close_and_doubles_do_not_matter(tmp_path: Path) -> None:
    mixed = (SQUARE[2], line(0, 0, 0, 10), SQUARE[0], line(20.003, 10, 20, 0.004), SQUARE[0], line(5, 5, 5, 5))
    assert volume(read(tmp_path, edge_only(*mixed))["board"]) == pytest.approx(20 * 10 * 1.6, rel=1e-3)


@pytest.mark.parametrize(
    ("item", "area"),
    [
        ('(gr_rect (start 5 2) (end 9 4) (layer "Edge.Cuts"))', 8.0),
        ('(gr_poly (pts (xy 5 2) (xy 9 2) (xy 9 5)) (layer "Edge.Cuts"))', 6.0),
        ('(gr_poly (pts (arc (start 5 5) (mid 7 3) (end 9 5))) (layer "Edge.Cuts"))', math.pi * 2),
        ('(gr_curve (pts (xy 5 5) (xy 5 2) (xy 9 2) (xy 9 5)) (layer "Edge.Cuts"))' + line(9, 5, 5, 5), 7.2),
        (
            '(footprint "a:b" (layer "F.Cu") (at 10 5 90) (fp_circle (center 1 0) (end 2 0) (layer "Edge.Cuts")))',
            math.pi,
        ),
    ],
)
def test_every_kind_of_edge_is_cut_out(tmp_path: Path, item: str, area: float) -> None:
    board = read(tmp_path, edge_only(*SQUARE, item))["board"]
    assert volume(board) == pytest.approx((200.0 - area) * 1.6, rel=2e-3)


def test_an_arc_that_leads_out_of_sight_is_refused_at_once(tmp_path: Path) -> None:
    beyond = '(gr_arc (start 20 0) (mid 20 30) (end 20 10) (layer "Edge.Cuts"))'
    with pytest.raises(BoardError, match=r"points of this .gr_arc .* are in a row, with mid beside start and end"):
        read(tmp_path, edge_only(SQUARE[0], beyond, *SQUARE[2:]))
    straight = '(gr_arc (start 20 0) (mid 20 3) (end 20 10) (layer "Edge.Cuts"))'
    assert volume(read(tmp_path, edge_only(SQUARE[0], straight, *SQUARE[2:]))["board"]) == pytest.approx(200.0 * 1.6)


def test_an_edge_of_very_short_pieces_closes(tmp_path: Path) -> None:
    """The corner of a panel that a program rounded: pieces of 0.011 mm with a gap of 0.0013 mm between them."""
    corner = (line(20, 0.0123, 19.9997, 0.0013), line(19.9988, 0.0004, 19.9878, 0))
    sides = (line(19.9878, 0, 0, 0), line(0, 0, 0, 10), line(0, 10, 20, 10), line(20, 10, 20, 0.0123))
    assert volume(read(tmp_path, edge_only(*corner, *sides))["board"]) == pytest.approx(20 * 10 * 1.6, rel=1e-4)
    steps = [(0.004 * step, 0.0) for step in range(9)]
    tiny = [line(*start, *end) for start, end in pairwise(steps)]
    rest = (line(0.032, 0, 20, 0), *SQUARE[1:])
    assert volume(read(tmp_path, edge_only(*tiny, *rest))["board"]) == pytest.approx(20 * 10 * 1.6, rel=1e-4)


def test_boards_side_by_side_and_within_a_frame_are_pieces_of_one(tmp_path: Path) -> None:
    def square(x: float, y: float, size: float) -> str:
        return f'(gr_rect (start {x} {y}) (end {x + size} {y + size}) (layer "Edge.Cuts"))'

    beside = read(tmp_path, edge_only(square(0, 0, 10), square(12, 0, 8), square(14, 2, 2)))["board"]
    assert volume(beside) == pytest.approx((100 + 64 - 4) * 1.6)
    framed = read(tmp_path, edge_only(square(5, 5, 10), square(0, 0, 20), square(3, 3, 14), square(9, 9, 1)))["board"]
    assert volume(framed) == pytest.approx((400 - 196 + 100 - 1) * 1.6)


def test_a_scoring_line_is_left_out_and_said(tmp_path: Path) -> None:
    scored = edge_only(*SQUARE, line(8, 1, 8, 9), line(20, 5, 15, 5))
    assert volume(read(tmp_path, scored)["board"]) == pytest.approx(20 * 10 * 1.6)
    note = messages(tmp_path, scored)["open-edge"]
    assert note.startswith("2 lines")
    assert "x 8.000, y 1.000" in note
    with pytest.raises(BoardError, match="open between"):
        read(tmp_path, edge_only(*SQUARE, line(8, -1, 8, 9)))


@pytest.mark.parametrize(
    "item",
    [
        '(footprint "a:VIA-0.4mm" (layer "F.Cu") (at 5 5) (pad "1" thru_hole circle (at 0 0) (size 1 1) (drill 0.4)))',
        '(footprint "a:Wire" (layer "F.Cu") (at 5 5) (pad "1" smd rect (at 0 0) (size 4 5)))',
        '(footprint "a:Plain_3mm" (layer "F.Cu") (at 5 5) (pad "" np_thru_hole circle (at 0 0) (size 3 3) (drill 3)))',
        '(footprint "a:Tag-Connect_TC2030-IDC_2x03" (layer "F.Cu") (at 5 5) (fp_rect (start 0 0) (end 4 3) '
        '(layer "F.CrtYd")) (pad "1" connect circle (at 0 0) (size 1 1)) (pad "2" connect circle (at 2 0) (size 1 1)))',
    ],
)
def test_copper_and_holes_without_a_body_are_left_out(tmp_path: Path, item: str) -> None:
    text = edge_only(*SQUARE, item)
    assert list(read(tmp_path, text)) == ["board"]
    assert messages(tmp_path, text)["no-body"].startswith("1 footprints")


def test_a_connector_with_mounting_holes_is_a_part(tmp_path: Path) -> None:
    pads = "".join(f'(pad "{n}" thru_hole circle (at {2.77 * n} 0) (size 2 2) (drill 1))' for n in range(1, 4))
    name = "DSUB-9_Female_Horizontal_P2.77x2.84mm_EdgePinOffset7.70mm_Housed_MountingHolesOffset9.12mm"
    text = edge_only(*SQUARE, f'(footprint "a:{name}" (layer "F.Cu") (at 5 5) {pads})')
    assert list(read(tmp_path, text)) == ["board", name]


def test_one_pad_with_a_model_is_a_part(tmp_path: Path) -> None:
    pad = '(pad "1" smd rect (at 0 0) (size 4 5))'
    spring = f'(footprint "a:Spring" (layer "F.Cu") (at 5 5) {pad} (model "a.wrl"))'
    assert list(read(tmp_path, edge_only(*SQUARE, spring))) == ["board", "Spring"]


@pytest.mark.parametrize("offset", ["", " (offset 3 1)"])
def test_a_hole_is_where_its_pad_is_and_the_copper_beside_it(tmp_path: Path, offset: str) -> None:
    pad = f'(pad "1" thru_hole circle (at 0 0) (size 3 3) (drill 2{offset}) (layers "*.Cu"))'
    item = f'(footprint "MountingHole" (layer "F.Cu") (at 10 5 90) {pad})'
    hole = read(tmp_path, edge_only(*SQUARE, item))["board"].patches.reshape(-1, 3)
    inside = hole[(hole[:, 0] > 1.0) & (hole[:, 0] < 19.0)]
    np.testing.assert_allclose([inside.min(axis=0), inside.max(axis=0)], [[9, -6, 0], [11, -4, 1.6]], atol=0.02)


def test_a_hole_through_the_edge_is_a_notch(tmp_path: Path) -> None:
    pad = '(pad "1" thru_hole circle (at 0 0) (size 3 3) (drill 2) (layers "*.Cu"))'
    board = read(tmp_path, edge_only(*SQUARE, f'(footprint "MountingHole" (layer "F.Cu") (at 10 0) {pad})'))["board"]
    assert volume(board) == pytest.approx((200.0 - math.pi / 2) * 1.6, rel=2e-3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (edge_only(*SQUARE[:3]), r"open between .*x 0\.000, y 0\.000 mm.* and .*x 0\.000, y 10\.000"),
        (edge_only(*SQUARE[:3], line(0, 10, 0, 0.03)), r"y 0\.030"),
        (edge_only(), "no board outline"),
        (edge_only(line(0, 0, 9, 9), line(9, 9, 9, 0), line(9, 0, 0, 9), line(0, 9, 0, 0)), "crosses itself"),
        (edge_only(*SQUARE, '(gr_rect (start 15 -5) (end 35 9) (layer "Edge.Cuts"))'), "crosses another one"),
        (edge_only(*SQUARE).replace("1.6", "0"), r":1: the board's thickness"),
        (edge_only(*SQUARE, '(footprint "a" (layer "F.Cu"))'), r":6: .* no \(at x y\)"),
        (edge_only(*SQUARE, '(footprint "a" (at 1 nan))'), r":6: .*'nan'"),
        (edge_only(*SQUARE, "(gr_line (start 1 1) (layer Edge.Cuts))"), r":6: .*no \(end x y\)"),
        (edge_only(*SQUARE, "(gr_line (start 1 1"), r"ends inside a list"),
        (edge_only(*SQUARE) + ")", "bracket too many"),
        (edge_only(*SQUARE, "(" * 200 + ")" * 200), "nested too deep"),
        (edge_only(*SQUARE, '(footprint "x] (at 1 1))'), r":6: .*a quote is not closed"),
        ("", "not a KiCad board"),
        ("(kicad_sch (version 1))", "not a KiCad board"),
    ],
)
def test_a_bad_board_says_what_is_wrong(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(BoardError, match=says) as caught:
        read(tmp_path, text)
    assert str(caught.value).startswith(str(tmp_path / "b.kicad_pcb"))


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "b.kicad_pcb").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe")
    with pytest.raises(BoardError, match="UTF-8"):
        read_kicad(tmp_path / "b.kicad_pcb")
    with pytest.raises(BoardError, match="is a directory"):
        read_kicad(tmp_path)


def test_a_newer_version_is_read_with_a_warning(tmp_path: Path) -> None:
    assert "kicad-version" in messages(tmp_path, NEW.replace("20241229", "20991229"))
    assert "kicad-version" not in messages(tmp_path, OLD)


@pytest.mark.slow
@given(place=st.integers(0, len(NEW) - 1), length=st.integers(0, 80), text=st.text(max_size=6))
@settings(max_examples=60)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, place: int, length: int, text: str) -> None:
    damaged = NEW[:place] + text + NEW[place + length :]
    (tmp_path / "b.kicad_pcb").write_bytes(damaged.encode("utf-8", "replace"))
    message, bodies = "", ()
    try:
        bodies, _ = read_kicad(tmp_path / "b.kicad_pcb")
    except BoardError as error:
        message = str(error)
    assert message.startswith(str(tmp_path)) or bodies
    assert all(np.isfinite(body.patches).all() and np.isfinite(body.normals).all() for body in bodies)


@pytest.mark.parametrize("end", ["", "\\"])
def test_a_string_without_an_end_is_looked_at_once(end: str, tmp_path: Path) -> None:
    """Each of its quotes would be followed to the end again: hours for a megabyte."""
    (tmp_path / "b.kicad_pcb").write_text('(kicad_pcb\n(x "' + '\\"' * 500_000 + end)
    with pytest.raises(BoardError, match=r"b\.kicad_pcb:2: a quote is not closed"):
        read_kicad(tmp_path / "b.kicad_pcb")
