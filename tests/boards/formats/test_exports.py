"""What KiCad exports of a board is the board that KiCad itself holds: both sides, pins, pads and heights."""

import math
import re
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from ecad_writers import EcadBoard, EcadPart, allegro, gencad, ipc2581, odb, write_folder
from shapely import Point, box

from boards.board import Board, Body
from boards.errors import BoardError
from boards.load import load_board

DATA = Path(__file__).parents[1] / "data" / "exported"
NEAR_MM = 0.01
NEAR_DEG = 0.01
FILES = {"ipc_b.zip": None, "ipc_c.zip": None, "odb_mm.tgz": None, "odb_inch.zip": None, "gerber.zip": "pos.csv"}


@cache
def board(name: str) -> Board:
    table = FILES.get(name)
    return load_board(DATA / name, DATA / table if table else None)


def bodies(of: Board) -> dict[str, Body]:
    return {body.name: body for body in of.bodies if body.role == "component"}


@pytest.mark.parametrize("name", FILES)
def test_components_are_those_of_the_kicad_file(name: str) -> None:
    here, there = board(name), board("exported.kicad_pcb")
    found = {each.name: each for each in here.components}
    assert set(found) == {each.name for each in there.components}
    for known in there.components:
        each = found[known.name]
        assert (each.side, each.package, each.pins, each.value) == (known.side, known.package, known.pins, known.value)
        if known.name != "X1" and not (name.startswith("gerber") and known.name.startswith("C")):
            # X1 has no name that states a height, and C1 has its own in a property that Gerber files do not carry.
            assert each.height_mm == pytest.approx(known.height_mm, abs=NEAR_MM)
        assert each.gap_height_mm == known.gap_height_mm


@pytest.mark.parametrize("name", FILES)
def test_pads_lie_where_kicad_has_them(name: str) -> None:
    here, there = bodies(board(name)), bodies(board("exported.kicad_pcb"))
    assert sum(len(body.pads) for body in there.values()) > 70
    for known in there.values():
        pads = here[known.name].pads
        assert len(pads) == len(known.pads)
        for one, other in zip(pads, known.pads, strict=True):
            assert math.hypot(one.x_mm - other.x_mm, one.y_mm - other.y_mm) < NEAR_MM
            sizes, turn = (one.length_mm, one.width_mm), one.turn_rad
            if abs(math.remainder(turn - other.turn_rad, math.pi)) > 0.7:  # a rectangle that lies the other way round
                sizes, turn = sizes[::-1], turn + math.pi / 2.0
            assert sizes == pytest.approx((other.length_mm, other.width_mm), abs=NEAR_MM)
            if abs(sizes[0] - sizes[1]) > NEAR_MM:
                assert abs(math.degrees(math.remainder(turn - other.turn_rad, math.pi))) < NEAR_DEG


@pytest.mark.parametrize("name", ["ipc_b.zip", "ipc_c.zip"])
def test_bodies_of_ipc_2581_are_drawn_as_in_kicad(name: str) -> None:
    there = {each.name: each for each in board("exported.kicad_pcb").components}
    for each in board(name).components:
        if each.name != "X1":  # nothing is drawn of its body
            assert each.outline.hausdorff_distance(there[each.name].outline) < NEAR_MM


@pytest.mark.parametrize("name", FILES)
def test_the_edge_is_that_of_the_kicad_file(name: str) -> None:
    here, there = board(name), board("exported.kicad_pcb")
    edge = np.asarray(here.outline.exterior.coords)
    assert max(Point(point).distance(there.outline.exterior) for point in edge) < 0.02
    assert here.outline.exterior.hausdorff_distance(there.outline.exterior) < 0.1  # arcs as chords of a program's own
    if not name.startswith("odb"):  # KiCad's ODB++ states no thickness
        assert here.top_z_mm == pytest.approx(there.top_z_mm, abs=NEAR_MM)
    if name.startswith("odb"):
        assert len(here.outline.interiors) == len(there.outline.interiors)


PLACED = EcadBoard(
    box(-5, -3, 70, 50).difference(box(30, 20, 36, 24)),
    1.2,
    (
        EcadPart("U1", 10.0, 12.5, 8.0, 6.0, 1.5, 30.0, "top", pins=8),
        EcadPart("U2", 55.0, 12.5, 8.0, 6.0, 1.5, 12.345, "bottom", pins=8),
        EcadPart("C1", 20.0, 40.0, 2.0, 1.2, 0.8, 270.0, "bottom"),
        EcadPart("R1", 40.0, 40.0, 1.6, 0.8, 0.45, -45.0, "top"),
    ),
    holes=((62.0, 44.0, 3.2), (2.0, 2.0, 0.6)),
)


def check(found: Board) -> None:
    """Sizes, sides, pins, heights and pads are those that were written."""
    assert found.top_z_mm == pytest.approx(PLACED.thickness, abs=1e-4)
    assert len(found.outline.interiors) == 2  # the cut-out and the large hole
    assert len(found.components) == len(PLACED.parts)
    own = bodies(found)
    for part in PLACED.parts:
        component = next(each for each in found.components if each.name == part.name)
        assert (component.side, component.pins, component.value) == (part.side, part.pins, part.value)
        assert component.part == part.part
        assert component.height_mm == pytest.approx(part.height, abs=1e-3)
        corners = [(x, y) for x in (-part.width / 2, part.width / 2) for y in (-part.depth / 2, part.depth / 2)]
        for corner in corners:
            assert component.outline.exterior.distance(Point(part.on_board(*corner))) < NEAR_MM
        for pad, place in zip(own[part.name].pads, part.pin_places(), strict=True):
            assert (pad.x_mm, pad.y_mm) == pytest.approx(part.on_board(*place), abs=1e-3)


@pytest.mark.parametrize("copper", [False, True])
@pytest.mark.parametrize(("revision", "units"), [("B", "INCH"), ("C", "MILLIMETER"), ("C", "MICRON")])
def test_ipc_2581_after_its_standard(revision: str, units: str, copper: bool, tmp_path: Path) -> None:
    file = tmp_path / "card.xml"
    file.write_text(ipc2581(PLACED, revision, units, copper), "utf-8")
    check(load_board(file))


@pytest.mark.parametrize("named", ["card", "other"])
def test_of_several_boards_in_ipc_2581_the_one_that_the_content_names_is_read(named: str, tmp_path: Path) -> None:
    text = ipc2581(PLACED).replace('StepRef name="card"', f'StepRef name="{named}"')
    begin, end = text.index("<Step name"), text.index("</CadData>")
    one = text[begin:end]
    other = one.replace('<Step name="card"', '<Step name="other"').replace('refDes="R1"', 'refDes="R9"')
    for steps in (one + other, other + one):
        (tmp_path / "card.xml").write_text(text[:begin] + steps + text[end:], "utf-8")
        names = {each.name for each in load_board(tmp_path / "card.xml").components}
        assert names >= {"U1", "R1" if named == "card" else "R9"}
        assert not names >= {"R1", "R9"}


@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_odb_after_its_standard(unit: str, tmp_path: Path) -> None:
    write_folder(odb(PLACED, unit), tmp_path / "job")
    check(load_board(tmp_path / "job"))


@pytest.mark.parametrize("first", ["panel", "orig", "net"])
def test_of_several_steps_of_odb_the_one_with_components_is_read(first: str, tmp_path: Path) -> None:
    """Some tools put an empty step, or one that repeats the board, before it."""
    files = odb(PLACED)
    step = f"STEP {{\n COL=1\n NAME={first.upper()}\n}}\n"
    files["matrix/matrix"] = step + files["matrix/matrix"].replace("COL=1\n", "COL=2\n", 1)
    files[f"steps/{first}/stephdr"] = "UNITS=MM\n"
    if first == "net":
        files["steps/net/profile"] = files["steps/card/profile"]
    write_folder(files, tmp_path / "job")
    check(load_board(tmp_path / "job"))


@pytest.mark.parametrize("turn", [lambda deg: deg, lambda deg: -deg, lambda deg: deg + 90.0, lambda deg: 180.0 - deg])
def test_rotations_are_understood_by_the_copper_whatever_the_program_means(turn: object, tmp_path: Path) -> None:
    """Components whose stated rotation is another than the standard's still lie on their toeprints."""
    files = odb(PLACED)
    for side in ("top", "bot"):
        name = f"steps/card/layers/comp_+_{side}/components"
        lines = files[name].splitlines()
        for number, line in enumerate(lines):
            words = line.split(" ")
            if words[0] == "CMP":
                words[4] = f"{turn(float(words[4])) % 360.0:.6f}"  # type: ignore[operator]
                lines[number] = " ".join(words)
        files[name] = "\n".join(lines) + "\n"
    write_folder(files, tmp_path / "job")
    check(load_board(tmp_path / "job"))


def test_parts_that_are_not_populated_are_left_out(tmp_path: Path) -> None:
    file = tmp_path / "card.xml"
    text = ipc2581(PLACED).replace(
        '<RefDes name="C1" packageRef="Box-C1_2x1.2mm" populate="true"',
        '<RefDes name="C1" packageRef="Box-C1_2x1.2mm" populate="false"',
    )
    file.write_text(text, "utf-8")
    assert {each.name for each in load_board(file).components} == {"U1", "U2", "R1"}


def test_a_table_places_parts_on_a_gerber_profile_from_either_side(tmp_path: Path) -> None:
    """Programs state the turn of parts on the bottom as seen from the top or from below: the pads decide."""
    from ecad_writers import gerber_copper, gerber_profile, placement_table

    for name, text in (
        ("edge.gbr", gerber_profile(PLACED)),
        ("top.gbr", gerber_copper(PLACED, "top")),
        ("bottom.gbr", gerber_copper(PLACED, "bottom", "INCH")),
    ):
        (tmp_path / name).write_text(text, "utf-8")
    below = replace(
        PLACED, parts=tuple(replace(p, turn_deg=-p.turn_deg) if p.side == "bottom" else p for p in PLACED.parts)
    )
    for stated in (PLACED, below):
        table = tmp_path / "place.csv"
        table.write_text(placement_table(stated), "utf-8")
        found = load_board(tmp_path, table)
        assert {each.name for each in found.components} == {part.name for part in PLACED.parts}
        own = bodies(found)
        for part in PLACED.parts:
            component = next(each for each in found.components if each.name == part.name)
            centre = component.outline.centroid
            assert math.hypot(centre.x - part.x, centre.y - part.y) < 0.5
            assert component.height_mm == pytest.approx(part.height)
            for pad, place in zip(own[part.name].pads, part.pin_places(), strict=True):
                assert (pad.x_mm, pad.y_mm) == pytest.approx(part.on_board(*place), abs=1e-3)


NO_HOLES = replace(PLACED, holes=(), outline=PLACED.outline.difference(box(60, 42, 64, 46)))
"""Neither format states holes besides those of parts."""


@pytest.mark.parametrize("dialect", ["mirrorx", "mirrory", "clockwise"])
@pytest.mark.parametrize("units", ["INCH", "MM", "USER 1000"])
@pytest.mark.parametrize("name", ["card.cad", "card.gcd", "card.txt"])
def test_gencad_of_programs_that_mirror_and_turn_otherwise(units: str, dialect: str, name: str, tmp_path: Path) -> None:
    """Which turns are meant is settled by where the tracks of each pin's net end."""
    file = tmp_path / name
    file.write_text(gencad(NO_HOLES, units, dialect), "utf-8")
    check(load_board(file))


@pytest.mark.parametrize("underscores", [False, True])
@pytest.mark.parametrize("units", ["MILS", "MILLIMETERS"])
@pytest.mark.parametrize("name", ["card.fab", "extract.txt"])
def test_views_of_an_allegro_extract(units: str, underscores: bool, name: str, tmp_path: Path) -> None:
    file = tmp_path / name
    file.write_text(allegro(NO_HOLES, units, underscores=underscores), "utf-8")
    check(load_board(file))


@pytest.mark.parametrize("write", [gencad, allegro])
def test_in_an_order_a_text_with_an_edge_is_the_board_and_one_without_is_a_table(
    write: Callable[[EcadBoard], str], tmp_path: Path
) -> None:
    (tmp_path / "export.txt").write_text(write(NO_HOLES), "utf-8")
    places = allegro(NO_HOLES).split("A!PAD_NAME")[0]
    (tmp_path / "placement.txt").write_text(places.replace("PN-1", "PN-7"), "utf-8")
    board = load_board(tmp_path)
    assert [each.name for each in board.sources] == ["export.txt", "placement.txt"]
    assert {each.part for each in board.components} == {"PN-7"}
    assert len(board.components) == len(PLACED.parts)


@pytest.mark.parametrize(
    ("name", "old", "new", "reason"),
    [
        ("gerber.zip", r"(?m)^(%ADD\d+R,[\d.]+X)", r"\1-", "an aperture of the template R has a negative size"),
        ("gerber.zip", r"(?m)^(%ADD\d+C,)", r"\1-", "an aperture of the template C has a negative size"),
        ("ipc_b.zip", '<RectCenter width="', '<RectCenter width="-', "width of <RectCenter> is negative"),
        ("ipc_b.zip", '<Circle diameter="', '<Circle diameter="-', "diameter of <Circle> is negative"),
    ],
)
def test_a_negative_size_of_copper_is_refused(name: str, old: str, new: str, reason: str, tmp_path: Path) -> None:
    changed = 0
    with zipfile.ZipFile(DATA / name) as before, zipfile.ZipFile(tmp_path / name, "w") as after:
        for each in before.namelist():
            text, count = re.subn(old, new, before.read(each).decode())
            after.writestr(each, text)
            changed += count
    assert changed
    with pytest.raises(BoardError, match=rf"{name}.*: {reason}"):
        load_board(tmp_path / name, DATA / "pos.csv" if name == "gerber.zip" else None)
