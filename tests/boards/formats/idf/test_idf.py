"""IDF boards: the geometry that was stated is the geometry that is built, and bad files say what is wrong."""

import math
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.board import Body
from boards.errors import BoardError
from boards.formats.idf.idf import read_idf

DATA = Path(__file__).parents[2] / "data"
EMN = (DATA / "notched.emn").read_text(encoding="utf-8")
EMP = (DATA / "notched.emp").read_text(encoding="utf-8")


def write(folder: Path, emn: str = EMN, emp: str | None = EMP) -> Path:
    (folder / "b.emn").write_text(emn, encoding="utf-8")
    if emp is not None:
        (folder / "b.emp").write_text(emp, encoding="utf-8")
    return folder / "b.emn"


def volume(body: Body) -> float:
    a, b, c = body.patches[:, 0], body.patches[:, 1], body.patches[:, 2]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def by_name(path: Path) -> dict[str, Body]:
    bodies, _ = read_idf(path)
    return {body.name: body for body in bodies}


def extent(body: Body) -> tuple[np.ndarray, np.ndarray]:
    points = body.patches.reshape(-1, 3)
    return points.min(axis=0), points.max(axis=0)


def test_the_board_has_its_arc_its_cut_outs_and_its_mounting_hole(tmp_path: Path) -> None:
    board = by_name(write(tmp_path))["board"]
    rounded = 40 * 30 - 10 * 10 + math.pi * 10**2 / 4
    area = rounded - math.pi * 2**2 - 8 * 3 - math.pi * 1.6**2
    assert board.role == "board"
    assert volume(board) == pytest.approx(area * 1.6, rel=2e-3)
    np.testing.assert_allclose(extent(board), [[0, 0, 0], [40, 30, 1.6]], atol=1e-9)


def test_components_stand_on_their_side_from_offset_to_height(tmp_path: Path) -> None:
    bodies = by_name(write(tmp_path))
    assert list(bodies) == ["board", "U1", "U2", "C1", "clip"]
    assert extent(bodies["U1"])[0][2] == pytest.approx(1.6)
    assert extent(bodies["U1"])[1][2] == pytest.approx(3.1)
    assert extent(bodies["U2"])[0][2] == pytest.approx(-1.5)
    assert extent(bodies["U2"])[1][2] == pytest.approx(0.0)
    assert extent(bodies["C1"])[0][2] == pytest.approx(2.1)
    assert extent(bodies["C1"])[1][2] == pytest.approx(12.1)
    assert bodies["C1"].gap_height_mm == pytest.approx(0.5)
    assert bodies["U1"].gap_height_mm is None
    assert (bodies["U1"].package, bodies["U1"].part, bodies["U1"].side) == ("wedge 4x2", "PN-1", "top")
    assert volume(bodies["C1"]) == pytest.approx(math.pi * 2.54**2 * 10.0, rel=0.01)


def test_a_part_on_the_bottom_is_turned_as_seen_from_there_and_mirrored(tmp_path: Path) -> None:
    bodies = by_name(write(tmp_path))
    # The wedge's corner of 4 x 2 turned by 90° lies left and behind; on the other side it is reflected in x.
    np.testing.assert_allclose(extent(bodies["U1"])[0][:2], [18.0, 15.0], atol=1e-9)
    np.testing.assert_allclose(extent(bodies["U1"])[1][:2], [20.0, 19.0], atol=1e-9)
    np.testing.assert_allclose(extent(bodies["U2"])[0][:2], [20.0, 15.0], atol=1e-9)
    np.testing.assert_allclose(extent(bodies["U2"])[1][:2], [22.0, 19.0], atol=1e-9)
    assert volume(bodies["U2"]) == pytest.approx(6.0)


def test_what_is_left_out_is_said(tmp_path: Path) -> None:
    _, notes = read_idf(write(tmp_path))
    messages = {note.rule.id: note.message for note in notes}
    assert "C2" in messages["idf-unplaced"]
    assert "FD1" in messages["no-body"]
    assert messages["small-drills"].startswith("2 drilled holes")


@pytest.mark.parametrize(("unit", "length_mm"), [("THOU", 0.0254), ("TNM", 1e-5)])
def test_units_scale_the_board_file_alone(tmp_path: Path, unit: str, length_mm: float) -> None:
    def rescale(match: re.Match[str]) -> str:
        return f"{float(match[0]) / length_mm:.6f}"

    lines: list[str] = []
    section = ""
    for line in EMN.splitlines():
        section = line if line.startswith(".") else section
        head, tail = ("", line) if not section.startswith(".BOARD") or line.count(" ") == 0 else line.split(" ", 1)
        if section.startswith(".BOARD") and re.match(r"[\d.]", tail):
            tail = re.sub(r"^[-\d.]+( [-\d.]+)?", lambda m: re.sub(r"[-\d.]+", rescale, m[0]), tail)
        if section.startswith(".DRILLED") and re.match(r"[\d.]", line):
            tail = re.sub(r"^[-\d.]+ [-\d.]+ [-\d.]+", lambda m: re.sub(r"[-\d.]+", rescale, m[0]), line)
        if section.startswith(".PLACEMENT") and re.match(r"[\d.]", line):
            tail = re.sub(r"^[-\d.]+ [-\d.]+ [-\d.]+", lambda m: re.sub(r"[-\d.]+", rescale, m[0]), line)
        lines.append(f"{head} {tail}".strip())
    scaled = "\n".join(lines).replace("notched MM", f"notched {unit}")
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    before, after = by_name(write(tmp_path / "one")), by_name(write(tmp_path / "two", scaled))
    for name, body in before.items():
        np.testing.assert_allclose(extent(after[name]), extent(body), atol=1e-3)


def test_version_2_has_no_mounting_offset(tmp_path: Path) -> None:
    old = EMN.replace("BOARD_FILE 3.0", "BOARD_FILE 2.0").replace("33.0 8.0 0.5 0.0 TOP", "33.0 8.0 0.0 TOP")
    old = re.sub(r"^([\d.]+ [\d.]+) 0.0 ([\d.]+ (?:TOP|BOTTOM))", r"\1 \2", old, flags=re.MULTILINE)
    bodies = by_name(write(tmp_path, old))
    assert extent(bodies["C1"])[0][2] == pytest.approx(1.6)
    np.testing.assert_allclose(extent(bodies["U1"])[0][:2], [18.0, 15.0], atol=1e-9)


def test_either_file_may_be_named_in_any_case(tmp_path: Path) -> None:
    shutil.copy(DATA / "notched.emn", tmp_path / "Notched.EMN")
    shutil.copy(DATA / "notched.emp", tmp_path / "NOTCHED.emp")
    one, two = read_idf(tmp_path / "Notched.EMN")[0], read_idf(tmp_path / "NOTCHED.emp")[0]
    assert [body.name for body in one] == [body.name for body in two]
    assert len(one) == 5


def test_a_board_that_was_moved_has_the_same_vertices_moved(tmp_path: Path) -> None:
    """Turned by 37° and shifted: every vertex of every body follows, in the same order."""
    turn, shift = math.radians(37.0), np.array([120.0, -45.0])
    matrix = np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])

    def moved(x: str, y: str) -> str:
        px, py = np.array([float(x), float(y)]) @ matrix + shift
        return f"{px:.9f} {py:.9f}"

    lines: list[str] = []
    section = ""
    for line in EMN.splitlines():
        section = line if line.startswith(".") else section
        fields = line.split()
        if section.startswith(".BOARD") and len(fields) == 4:
            line = f"{fields[0]} {moved(fields[1], fields[2])} {fields[3]}"
        elif section.startswith(".DRILLED") and len(fields) == 7:
            line = f"{fields[0]} {moved(fields[1], fields[2])} {' '.join(fields[3:])}"
        elif section.startswith(".PLACEMENT") and len(fields) == 6:
            angle = float(fields[3]) + (37.0 if fields[4] == "TOP" else -37.0)
            line = f"{moved(fields[0], fields[1])} {fields[2]} {angle} {fields[4]} {fields[5]}"
        lines.append(line)
    (tmp_path / "one").mkdir()
    (tmp_path / "two").mkdir()
    before, after = by_name(write(tmp_path / "one")), by_name(write(tmp_path / "two", "\n".join(lines)))
    for name, body in before.items():
        sides = body.surfaces[2].patches
        was, now = body.patches[-sides:], after[name].patches[-sides:]
        np.testing.assert_allclose(now[:, :, :2], was[:, :, :2] @ matrix + shift, atol=1e-6)
        np.testing.assert_allclose(now[:, :, 2], was[:, :, 2], atol=1e-9)


@pytest.mark.parametrize(
    ("old", "new", "line", "says"),
    [
        ("BOARD_FILE", "PANEL_FILE", 2, "BOARD_FILE"),
        ("BOARD_FILE 3.0", "BOARD_FILE 4.0", 2, "IDF 3.0"),
        ("notched MM", "notched FURLONG", 3, "FURLONG"),
        ("0 40.0 20.0 0.0", "0 40.0 nan 0.0", 10, "'nan'"),
        ("0 40.0 20.0 0.0", "0 40.0", 10, "'nothing'"),
        ("0 0.0 30.0 0.0\n0 0.0 0.0 0.0\n", "0 0.0 30.0 0.0\n", 12, "line 8"),
        ("0 40.0 20.0 0.0", "0 0.0 0.0 0.0", 10, "encloses nothing"),
        ("0 40.0 20.0 0.0", "0 40.0 20.0 359.99", 10, "more than 10 m away"),
        ("\n1.6\n", "\n0\n", 7, "thickness"),
        ("20.0 15.0 0.0 90.0 TOP PLACED", "20.0 15.0 0.0 90.0 LEFT PLACED", 32, "LEFT"),
        ("can PN-2 C1", "can PN-2", 35, "package, part number"),
        ("can PN-2 C1", "tub PN-2 C1", 35, "tub"),
        (".END_NOTES\n", "", 29, ".END_NOTES"),
        (".END_PLACEMENT\n", "", 30, ".END_PLACEMENT"),
    ],
)
def test_a_bad_board_file_names_the_line(tmp_path: Path, old: str, new: str, line: int, says: str) -> None:
    assert old in EMN
    with pytest.raises(BoardError, match=re.escape(says)) as caught:
        read_idf(write(tmp_path, EMN.replace(old, new, 1)))
    assert caught.value.line == line
    assert str(caught.value).startswith(f"{tmp_path / 'b.emn'}:{line}: ")


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"wedge 4x2" PN-1 MM 1.5', '"wedge 4x2" PN-1 MM', 5),
        ('"wedge 4x2" PN-1 MM 1.5', '"wedge 4x2" PN-1 MM 0.0', 5),
        ('"wedge 4x2" PN-1 MM 1.5', '"wedge 4x2" PN-1 MM -1', 5),
    ],
)
def test_a_package_without_height_names_its_line_in_the_library(tmp_path: Path, old: str, new: str, line: int) -> None:
    with pytest.raises(BoardError, match="height") as caught:
        read_idf(write(tmp_path, EMN, EMP.replace(old, new)))
    assert (caught.value.file, caught.value.line) == (tmp_path / "b.emp", line)


def test_a_missing_partner_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(BoardError, match=r"b\.emp is not beside"):
        read_idf(write(tmp_path, emp=None))
    (tmp_path / "b.emn").unlink()
    (tmp_path / "b.emp").write_text(EMP, encoding="utf-8")
    with pytest.raises(BoardError, match=r"b\.emn is not beside"):
        read_idf(tmp_path / "b.emp")


@given(place=st.integers(0, len(EMN) - 1), length=st.integers(0, 60), text=st.text(max_size=8))
@settings(max_examples=60)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, place: int, length: int, text: str) -> None:
    damaged = EMN[:place] + text + EMN[place + length :]
    (tmp_path / "b.emn").write_bytes(damaged.encode("utf-8", "replace"))
    (tmp_path / "b.emp").write_text(EMP, encoding="utf-8")
    message, bodies = "", ()
    try:
        bodies, _ = read_idf(tmp_path / "b.emn")
    except BoardError as error:
        message = str(error)
    assert message.startswith(str(tmp_path)) or bodies
    assert all(np.isfinite(body.patches).all() and np.isfinite(body.normals).all() for body in bodies)


@pytest.mark.parametrize("height", ["0.0", "0.05", "0.254"])
def test_copper_of_hardly_any_height_is_left_out(tmp_path: Path, height: str) -> None:
    names = by_name(write(tmp_path, emp=EMP.replace("FID_1mm none MM 0.0", f"FID_1mm none MM {height}")))
    assert "FD1" not in names


def seated(folder: Path, package: str, thou: float, reference: str = "C1") -> tuple[float, Body, dict[str, str]]:
    """Height above its offset of one part of a package, the part, and what was noticed by rule."""
    emn = EMN.replace("can PN-2 C1", f"{package} PN-2 {reference}").replace("can PN-2 C2", f"{package} PN-2 C2")
    bodies, notes = read_idf(
        write(folder, emn, EMP.replace("can PN-2 THOU 393.7007874", f"{package} PN-2 THOU {thou}"))
    )
    body = next(body for body in bodies if body.name == reference)
    return extent(body)[1][2] - 1.6 - 0.5, body, {note.rule.id: note.message for note in notes}


@pytest.mark.parametrize(
    ("package", "thou", "height_mm"),
    [
        ("SOIC_8", 2000.0, 1.75),
        ("0603", 2000.0, 1.0),
        ("SOIC_8", 0.0, 1.75),
        ("SOIC_8", 1.0, 1.75),
        ("SOIC_8", 240.0, 1.75),
        ("TO-220", 1000.0, 23.0),
        ("L_12x12mm_H4.5mm", 40.0, 4.5),
        ("CP_Axial_L18.0mm_D6.5mm_P25.00mm_Horizontal", 1417.0, 6.5),
    ],
)
def test_a_height_that_contradicts_the_package_is_reported_and_not_believed(
    tmp_path: Path, package: str, thou: float, height_mm: float
) -> None:
    found_mm, body, messages = seated(tmp_path, package, thou)
    assert found_mm == pytest.approx(height_mm)
    assert messages["doubtful-height"].startswith("1 components")
    assert f"C1 ({thou * 0.0254:g} mm stated, {height_mm:g} mm taken: " in messages["doubtful-height"]
    assert dict(body.extra)["x-height"] in messages["doubtful-height"]


@pytest.mark.parametrize(
    ("package", "thou"), [("SOIC_8", 61.0), ("SOIC_8", 180.0), ("Relay_X", 206.0), ("mystery", 900.0)]
)
def test_a_height_that_may_be_true_is_believed(tmp_path: Path, package: str, thou: float) -> None:
    found_mm, body, messages = seated(tmp_path, package, thou)
    assert found_mm == pytest.approx(thou * 0.0254)
    assert not body.extra
    assert "doubtful-height" not in messages


def test_the_default_of_a_layout_tool_is_kept_where_nothing_is_known_and_reported(tmp_path: Path) -> None:
    found_mm, _, messages = seated(tmp_path, "mystery", 2000.0)
    assert found_mm == pytest.approx(50.8)
    assert "C1 (50.8 mm stated, a layout tool's default, kept)" in messages["doubtful-height"]


def test_next_to_no_height_of_an_unknown_package_is_taken_for_tall(tmp_path: Path) -> None:
    found_mm, body, messages = seated(tmp_path, "mystery", 1.0)
    assert found_mm == pytest.approx(25.0)
    assert "doubtful-height" not in messages
    assert body.extra == (("x-height", "assumed tall"),)


def test_a_capacitor_on_the_lands_of_a_resistor_is_a_capacitor(tmp_path: Path) -> None:
    assert seated(tmp_path, "R_1210", 2000.0, "C1")[0] == pytest.approx(2.8)
    assert seated(tmp_path, "R_1210", 2000.0, "R1")[0] == pytest.approx(0.7)


def test_a_point_that_is_there_twice_does_not_matter(tmp_path: Path) -> None:
    first = EMN[EMN.index(".BOARD_OUTLINE") :].splitlines()[2]
    (tmp_path / "twice").mkdir()
    doubled = by_name(write(tmp_path / "twice", EMN.replace(first, f"{first}\n{first}", 1)))
    assert volume(doubled["board"]) == pytest.approx(volume(by_name(write(tmp_path))["board"]))


def test_the_order_of_packages_in_the_library_has_no_effect(tmp_path: Path) -> None:
    """Of packages with one name, and with one part number as well, the highest is taken, of equal ones the same."""
    wedge = EMP[EMP.index('.ELECTRICAL\n"wedge') : EMP.index(".ELECTRICAL\ncan")]
    head, rest = EMP.split(wedge)
    placed = EMN.replace("PN-1 U2", "PN-8 U2")
    twins = [
        wedge.replace("MM 1.5", "MM 1.2"),
        wedge.replace("PN-1", "PN-9").replace("2.0", "3.0"),
        wedge.replace("PN-1", "PN-9"),
        wedge,
    ]
    found: list[list[tuple[str, list[float]]]] = []
    for order in (twins, twins[::-1], [twins[2], twins[0], twins[3], twins[1]]):
        bodies = by_name(write(tmp_path, placed, head + "".join(order) + rest))
        found.append([(name, body.patches.ravel().tolist()) for name, body in bodies.items()])
        assert extent(bodies["U1"])[1][2] == pytest.approx(3.1)
    assert found[0] == found[1] == found[2]
