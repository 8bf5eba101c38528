"""Eagle boards: what is drawn is what is built, on both sides, and what is no such board is refused in a sentence."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.board import NOMINAL_HEIGHT, Body
from boards.errors import BoardError
from boards.formats.eagle.eagle import read_eagle
from boards.load import load_board

BOARD = (Path(__file__).parents[2] / "data" / "small.brd").read_text(encoding="utf-8")


def write(folder: Path, text: str = BOARD) -> Path:
    (folder / "b.brd").write_text(text, encoding="utf-8")
    return folder / "b.brd"


def read(folder: Path, text: str = BOARD) -> dict[str, Body]:
    return {body.name: body for body in read_eagle(write(folder, text))[0]}


def messages(folder: Path, text: str = BOARD) -> dict[str, str]:
    return {note.rule.id: note.message for note in read_eagle(write(folder, text))[1]}


def extent(body: Body) -> np.ndarray:
    points = body.patches.reshape(-1, 3)
    return np.array([points.min(axis=0), points.max(axis=0)])


def volume(body: Body) -> float:
    a, b, c = body.patches[:, 0], body.patches[:, 1], body.patches[:, 2]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_the_board_has_its_rounded_corner_cut_outs_holes_and_thickness(tmp_path: Path) -> None:
    board = read(tmp_path)["board"]
    area = 40 * 30 - (1 - math.pi / 4) * 5**2 - math.pi * 2**2 - 6 * 2
    drilled = math.pi * (1.6**2 + 1.1**2 + 2 * 0.508**2)
    thickness = 4 * 0.05 + 0.2 + 0.6 + 0.2
    assert volume(board) == pytest.approx((area - drilled) * thickness, rel=2e-3)
    np.testing.assert_allclose(extent(board), [[0, 0, 0], [40, 30, thickness]], atol=1e-9)


def test_a_turned_rectangle_is_turned_about_its_middle(tmp_path: Path) -> None:
    holes = load_board(write(tmp_path)).outline.interiors
    slot = min(holes, key=lambda ring: abs(ring.centroid.x - 20) + abs(ring.centroid.y - 21))
    np.testing.assert_allclose(slot.bounds, [19, 18, 21, 24], atol=1e-6)


@pytest.mark.parametrize("corners", [((5, 5), (9, 5), (5, 8)), ((5, 5), (9, 5), (9, 8), (5, 8))])
def test_a_polygon_on_the_outline_is_a_hole(tmp_path: Path, corners: tuple[tuple[int, int], ...]) -> None:
    vertices = "".join(f'<vertex x="{x}" y="{y}"/>' for x, y in corners)
    text = BOARD.replace("</plain>", f'<polygon width="0" layer="20">{vertices}</polygon></plain>')
    removed = load_board(write(tmp_path)).outline.area - load_board(write(tmp_path, text)).outline.area
    assert removed == pytest.approx(6.0 if len(corners) == 3 else 12.0)


@pytest.mark.parametrize("layers", ["", "(1*99)", "(1*16", "0", "(0*16)"])
def test_without_a_layer_setup_the_board_is_of_the_usual_thickness(tmp_path: Path, layers: str) -> None:
    text = BOARD.replace("(1*2+15*16)", layers)
    thickness = 9.1 if "1*16" in layers and "0" not in layers else 1.6
    thickness = 0.2 + 0.1 if layers == "(1*16" else thickness
    assert extent(read(tmp_path, text)["board"])[1][2] == pytest.approx(thickness)


def test_parts_lie_on_their_sides_as_they_are_drawn(tmp_path: Path) -> None:
    bodies = read(tmp_path)
    assert list(bodies) == ["board", "U1", "U2", "C1", "J1", "X1", "C4"]
    top = 1.2
    np.testing.assert_allclose(
        extent(bodies["U1"]), [[18.05, 7.55, top + 0.175], [21.95, 12.45, top + 1.75]], atol=1e-6
    )
    np.testing.assert_allclose(extent(bodies["U2"]), [[6.05, 5.55, -1.75], [9.95, 10.45, -0.175]], atol=1e-6)
    np.testing.assert_allclose(extent(bodies["C1"])[:, :2], [[28.5, 19.1], [31.5, 20.9]], atol=1e-6)
    np.testing.assert_allclose(extent(bodies["J1"])[:, :2], [[27.46, 4.1], [32.54, 6.5]], atol=1e-2)
    assert [bodies[name].side for name in ("U1", "U2", "C1", "J1")] == ["top", "bottom", "bottom", "top"]


def test_pads_are_those_of_the_own_side_turned_first_and_then_mirrored(tmp_path: Path) -> None:
    bodies = read(tmp_path)
    first, turned, dot = bodies["U1"].pads  # the one on the other side is left out
    assert (first.x_mm, first.y_mm) == pytest.approx((20 + 2.7, 10 - 1.905))
    assert (first.length_mm, first.width_mm, first.turn_rad) == pytest.approx((0.6, 1.6, math.pi / 2))
    assert abs(turned.turn_rad) == pytest.approx(math.pi)
    assert (first.round, dot.round) == (False, True)
    below = bodies["U2"].pads[0]
    assert (below.x_mm, below.y_mm) == pytest.approx((8 - 2.7, 8 - 1.905))
    assert math.cos(below.turn_rad) == pytest.approx(0.0, abs=1e-9)
    mirrored = bodies["C1"].pads[0]
    assert (mirrored.x_mm, mirrored.y_mm) == pytest.approx((30 + 0.9, 20 + 0.2))
    assert not bodies["J1"].pads


def test_package_value_part_pins_and_the_source_of_the_height_come_along(tmp_path: Path) -> None:
    bodies = read(tmp_path)
    assert (bodies["U1"].package, bodies["U1"].value, bodies["U1"].part, bodies["U1"].pins) == (
        *("SO08", "LM358", "LM358DR"),
        4,
    )
    heights = {name: dict(body.extra)["x-height"] for name, body in bodies.items() if name != "board"}
    assert heights["U1"] == "family SOIC (JEDEC MS-012)"
    assert heights["J1"].startswith("family pin header")
    assert heights["X1"].startswith("description, 2.1")
    assert extent(bodies["X1"])[1][2] == pytest.approx(1.2 + 0.9 + 0.25)


def test_the_name_of_a_3d_package_states_a_height(tmp_path: Path) -> None:
    models = '<packages3d><package3d name="CAPC2012X90" urn="urn:1" type="model"/></packages3d></library>'
    text = BOARD.replace("</library>", models).replace('x="30" y="15"', 'package3d_urn="urn:1" x="30" y="15"')
    body = read(tmp_path, text)["C4"]
    assert dict(body.extra)["x-height"] == "model states CAPC2012X90"
    assert extent(body)[1][2] == pytest.approx(1.2 + 0.9)


@pytest.mark.parametrize(("stated", "height_mm", "doubt"), [("1.3mm", 1.3, False), ("2000 mil", 1.75, True)])
def test_a_height_among_the_attributes_is_checked(tmp_path: Path, stated: str, height_mm: float, doubt: bool) -> None:
    text = BOARD.replace(
        '<attribute name="MPN" value="LM358DR"', f'<attribute name="MAXIMUM_PACKAGE_HEIGHT" value="{stated}"'
    )
    assert extent(read(tmp_path, text)["U1"])[1][2] == pytest.approx(1.2 + height_mm)
    assert ("U1 (50.8 mm stated, 1.75 mm taken" in messages(tmp_path, text).get("doubtful-height", "")) == doubt


def test_what_carries_no_body_is_listed(tmp_path: Path) -> None:
    notes = messages(tmp_path)
    assert "left out: C2, C3, FD1, H1, LOGO1." in notes["no-body"]
    assert "body: J1, X1." in notes["outline-from-pads"]
    assert set(notes) == {"no-body", "outline-from-pads"}


def test_an_unknown_package_is_assumed_tall(tmp_path: Path) -> None:
    text = BOARD.replace("Body Size: 2.1 x 2.4 x .9 mm", "unknown")
    bodies = {body.name: body for body in read_eagle(write(tmp_path, text))[0]}
    assert dict(bodies["X1"].extra) == {NOMINAL_HEIGHT: "assumed tall"}
    assert extent(bodies["X1"])[1][2] - extent(bodies["board"])[1][2] == pytest.approx(6.0)


@pytest.mark.parametrize("version", ["10.1", "", "new"])
def test_an_unknown_version_is_read_and_reported(tmp_path: Path, version: str) -> None:
    assert "eagle-version" in messages(tmp_path, BOARD.replace('version="9.6.2"', f'version="{version}"'))


def test_lines_that_cross_instead_of_meeting_enclose_the_board(tmp_path: Path) -> None:
    start = BOARD.index("<wire")
    end = BOARD.index("<circle")
    scores = [(-2, 0, 42, 0), (-2, 30, 42, 30), (0, -2, 0, 32), (40, -2, 40, 32)]
    lines = [f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="0" layer="20"/>' for a, b, c, d in scores]
    with pytest.raises(BoardError, match="is open between"):
        read(tmp_path, BOARD[:start] + "".join(lines) + BOARD[end:])
    halves = [(0, 0, 40, 0), (40, 0, 40, 30), (0, 30, 0, 0), (40, 30, -0, 30)]
    parts = [((a, b), ((a + c) / 2 + (c - a) / 8, (b + d) / 2 + (d - b) / 8), (c, d)) for a, b, c, d in halves]
    lines = [
        f'<wire x1="{p[0]}" y1="{p[1]}" x2="{q[0]}" y2="{q[1]}" width="0" layer="20"/>'
        for a, middle, c in parts
        for p, q in ((a, middle), (((a[0] + c[0]) / 2, (a[1] + c[1]) / 2), c))
    ]
    board = read(tmp_path, BOARD[:start] + "".join(lines) + BOARD[end:])["board"]
    np.testing.assert_allclose(extent(board)[:, :2], [[0, 0], [40, 30]], atol=1e-9)


BOMB = '<!DOCTYPE eagle [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
REFUSED = [
    # What is replaced, by what, words of the message.
    ('<!DOCTYPE eagle SYSTEM "eagle.dtd">', BOMB, "declares entities"),
    (
        '<!DOCTYPE eagle SYSTEM "eagle.dtd">',
        '<!DOCTYPE e [<!ENTITY x SYSTEM "file:///x">]>',
        "declares entities",
    ),
    ("<plain>", "<plain>" + "<a>" * 40 + "</a>" * 40, "nested more than"),
    ("</board>", "", "not valid XML"),
    (
        "</plain>",
        '<polygon layer="20"><vertex x="5" y="5"/><vertex x="9" y="5"/></polygon></plain>',
        "a polygon has fewer than three corners",
    ),
    ('encoding="utf-8"', 'encoding="klingon"', "encoding"),
    ('drill="3.2"', 'drill="1e300"', "drill of <hole> must be a number from -10000 to 10000"),
    ('x1="40" y1="25"', 'x1="4e5" y1="25"', "x1 of <wire>"),
    ('x1="40" y1="25"', 'y1="25"', "x1 of <wire> must be a number from -10000 to 10000, not 'nothing'"),
    ('dx="0.8"', 'dx="nan"', "dx of <smd>"),
    ('dx="0.8"', 'dx="1_0"', "dx of <smd>"),
    ('curve="90"', 'curve="4000"', "curve of <wire>"),
    ('curve="90"', 'curve="360"', "such an arc leads more than 10 m away"),
    ('rot="MR0"', 'rot="MRinf"', "rot of <element>"),
    ('rot="MR0"', 'rot="Q90"', "rot of <element>"),
    ('rot="MR0"', 'rot="90"', "rot of <element>"),
    ('package="MYSTERY"', 'package="GONE"', "is of the package 'GONE', which is in no library"),
    ('x2="0" y2="0"', 'x2="0" y2="5"', "is open between"),
    ("board>", "schematic>", "an Eagle schematic, not a board"),
    ("eagle", "hawk", "it begins with <hawk>"),
]


@pytest.mark.parametrize(("old", "new", "words"), REFUSED)
def test_what_cannot_be_read_is_refused_in_a_sentence(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(BoardError) as caught:
        read(tmp_path, BOARD.replace(old, new))
    assert str(caught.value).startswith(str(tmp_path / "b.brd"))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    "data",
    [
        b"\x10\x80\x00\x41binary",
        b"\x10\x00\x00\x41",
        b"\x00\x13\x04\x00allegro",
        b"PCBNEW-BOARD Version 1 date 1.1.2010",
        b"",
        b"\xff\xfe<\x00",
    ],
)
def test_other_boards_of_this_suffix_are_to_be_saved_again(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "b.brd").write_bytes(data)
    with pytest.raises(BoardError, match=r"Open it in Eagle 6 or newer, or in KiCad, and save it there\.$"):
        load_board(tmp_path / "b.brd")


def test_an_idf_board_of_this_suffix_is_read_as_idf(tmp_path: Path) -> None:
    data = Path(__file__).parents[2] / "data"
    (tmp_path / "b.brd").write_bytes((data / "notched.emn").read_bytes())
    (tmp_path / "b.emp").write_bytes((data / "notched.emp").read_bytes())
    assert load_board(tmp_path / "b.brd").components


@pytest.mark.slow
@given(place=st.integers(0, len(BOARD) - 1), length=st.integers(0, 60), text=st.text(max_size=8))
@settings(max_examples=60)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, place: int, length: int, text: str) -> None:
    damaged = BOARD[:place] + text + BOARD[place + length :]
    (tmp_path / "b.brd").write_bytes(damaged.encode("utf-8", "replace"))
    message, bodies = "", ()
    try:
        bodies, _ = read_eagle(tmp_path / "b.brd")
    except BoardError as error:
        message = str(error)
    assert message.startswith(str(tmp_path)) or bodies
    assert all(np.isfinite(body.patches).all() and np.isfinite(body.normals).all() for body in bodies)
