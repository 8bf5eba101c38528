"""Usual mistakes in the dialects of further tools: what one format is read right of, the others are as well."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from command import washboard
from ecad_writers import EcadBoard, EcadPart, allegro, gencad, ipc2581, odb, write_folder
from orders import gerbers, rules, table
from shapely import box
from trimesh.transformations import translation_matrix

from boards.board import Board
from boards.load import load_board
from boards.parts_table.read import read_table

CHIP = EcadPart("U1", 10.0, 15.0, 6.0, 4.0, 0.0, 0.0, "top", "XQ1", 8)
EDGE = box(0, 0, 40, 30)
FORMATS = ("GenCAD", "Allegro", "IPC-2581", "ODB++")


def write(folder: Path, kind: str, card: EcadBoard) -> Path:
    match kind:
        case "GenCAD":
            (folder / "b.cad").write_text(gencad(card))
            return folder / "b.cad"
        case "Allegro":
            (folder / "b.fab").write_text(allegro(card))
            return folder / "b.fab"
        case "IPC-2581":
            (folder / "b.xml").write_text(ipc2581(card))
            return folder / "b.xml"
        case _:
            write_folder(odb(card), folder / "job")
            return folder / "job"


def changed(file: Path, pattern: str, text: str, *, inner: str = "") -> Path:
    """A file in which something stands otherwise."""
    path = file / inner if inner else file
    found, count = re.subn(pattern, text, path.read_text(), flags=re.DOTALL)
    assert count
    path.write_text(found)
    return file


@pytest.mark.parametrize("kind", ["IPC-2581", "ODB++"])
def test_vias_in_a_flat_part_are_no_leads(kind: str, tmp_path: Path) -> None:
    file = write(tmp_path, kind, EcadBoard(EDGE, 1.6, (CHIP, replace(CHIP, name="U2", x=28.0, package="XQ2"))))
    if kind == "IPC-2581":
        via = '<Pin number="V1" type="THRU"><Location x="0" y="0"/><Circle diameter="0.5"/></Pin>'
        changed(file, r'(<Package name="XQ2".*?)(</Package>)', rf"\1{via}\2")
    else:
        changed(
            file, r"(PKG XQ2 [^\n]*\nRC [^\n]*\n)", r"\1PIN V1 T 0 0 0 E T\nCR 0 0 0.25\n", inner="steps/card/eda/data"
        )
    heights = {each.name: each.height_mm for each in load_board(file).components}
    assert heights["U1"] == heights["U2"]


@pytest.mark.parametrize(
    "line", ["X-5000000Y-5000000D02*\nX45000000Y-5000000D01*", "X60000000Y0D02*\nX60000000Y9000000D01*"]
)
def test_a_line_beside_the_edge_of_gerber_is_left_out(line: str, tmp_path: Path) -> None:
    layers = gerbers(tmp_path, named=True)
    changed(layers / "b.gko", r"M02\*", f"{line}\nM02*")
    board = load_board(layers)
    assert board.outline.area == pytest.approx(1200.0, abs=1.0)
    assert "open-edge" in rules(board)


BLANKS = {
    "blanks collapsed": "# Ref Val Package PosX PosY Rot Side\nR1 100 n  R_0603_1608Metric 10.0 20.0 0.0 top\n"
    "U1 LM358 dual opamp  SOIC-8 25.0 15.0 90.0 bottom\n",
    "KiCad": "### Module positions - created on today ###\n## Unit = mm, Angle = deg.\n"
    "# Ref     Val               Package              PosX       PosY       Rot  Side\n"
    "R1        100 n             R_0603_1608Metric    10.0000    20.0000    0.0  top\n"
    "U1        LM358 dual opamp  SOIC-8               25.0000    15.0000   90.0  bottom\n",
    "Altium": "Designator  Comment           Footprint          Mid X    Mid Y    TB  Rotation\n"
    "R1          100 n             R_0603_1608Metric  10.0     20.0     T   0\n"
    "U1          LM358 dual opamp  SOIC-8             25.0     15.0     B   90\n",
}


@pytest.mark.parametrize("tool", BLANKS)
def test_blanks_in_a_value_do_not_move_the_cells_after_it(tool: str, tmp_path: Path) -> None:
    one, other = read_table(table(tmp_path, "t.pos", BLANKS[tool])).rows
    assert (one.ref, one.xy_mm, one.side, one.package) == ("R1", (10.0, 20.0), "top", "R_0603_1608Metric")
    assert (other.ref, other.xy_mm, other.side, other.turn_deg) == ("U1", (25.0, 15.0), "bottom", 90.0)
    assert one.value == "100 n"
    assert other.value == "LM358 dual opamp" or tool == "blanks collapsed"  # where the value ends is open there


@pytest.mark.parametrize("kind", FORMATS)
def test_an_outline_that_holds_hardly_any_part_is_not_planned(kind: str, tmp_path: Path) -> None:
    parts = tuple(EcadPart(f"R{n}", 8.0 * n, 15.0, 1.6, 0.8, 0.5, 0.0, "top", "R0603") for n in range(1, 20))
    file = write(tmp_path, kind, EcadBoard(EDGE, 1.6, parts))
    found = [each for each in load_board(file).findings if each.rule.id == "component-outside"]
    assert [each.severity for each in found] == ["error"]
    outcome = washboard("plan", file, "-o", tmp_path / "a.wash")
    assert outcome.code == 2
    assert not (tmp_path / "a.wash").exists()


@pytest.mark.parametrize("kind", FORMATS)
def test_a_layout_without_components_is_noted(kind: str, tmp_path: Path) -> None:
    assert "no-components" in rules(load_board(write(tmp_path, kind, EcadBoard(EDGE, 1.6, ()))))


@pytest.mark.parametrize("kind", ["IPC-2581", "GenCAD"])
def test_print_between_the_pads_is_not_the_body(kind: str, tmp_path: Path) -> None:
    file = write(tmp_path, kind, EcadBoard(EDGE, 1.6, (CHIP,)))
    if kind == "IPC-2581":
        corners = "".join(f'<PolyStepSegment x="{x}" y="{y}"/>' for x, y in ((0.5, -2), (0.5, 2), (-0.5, 2)))
        changed(file, r"(<Package.*?<Polygon>).*?(</Polygon>)", rf'\1<PolyBegin x="-0.5" y="-2"/>{corners}\2')
    else:
        changed(
            file, r'(SHAPE "XQ1"\nINSERT SMD\nHEIGHT [^\n]*\n)RECTANGLE [^\n]*', r"\1RECTANGLE -0.02 -0.08 0.04 0.16"
        )
    (found,) = load_board(file).components
    assert found.outline.bounds[2] - found.outline.bounds[0] > 5.0


Solid = tuple[str, str, tuple[float, float, float], tuple[float, float, float]]
"""Node, the node it is in, size, middle of the underside."""


def write_model(file: Path, solids: Sequence[Solid]) -> Board:
    scene = trimesh.Scene()
    for parent in dict.fromkeys(each[1] for each in solids if each[1]):
        scene.graph.update(frame_to=parent, matrix=np.eye(4))
    for name, parent, size, (x, y, z) in solids:
        lies = translation_matrix((x, y, z + size[2] / 2))
        where = {"parent_node_name": parent} if parent else {}
        scene.add_geometry(trimesh.creation.box(size), node_name=name, geom_name=name, transform=lies, **where)
    file.write_bytes(bytes(scene.export(file_type=file.suffix[1:])))
    return load_board(file)


@pytest.mark.parametrize("inner", ["P2", "R7", "U1_body"])
def test_a_solid_in_a_part_of_gltf_does_not_split_it(inner: str, tmp_path: Path) -> None:
    board = write_model(tmp_path / "b.glb", [
        ("PCB", "", (60, 40, 1.6), (30, 20, 0)), ("R1", "", (2, 1, 1), (10, 30, 1.6)),
        (inner, "J1", (4, 4, 3), (30, 20, 1.6)), ("shell", "J1", (6, 4, 5), (30, 20, 1.6)),
    ])  # fmt: skip
    assert {each.name for each in board.components} == {"J1", "R1"}


@pytest.mark.parametrize("names", ["board {n}", "PCB.{n}"])
def test_boards_on_a_carrier_of_gltf_are_no_component(names: str, tmp_path: Path) -> None:
    solids: list[Solid] = [("plate", "", (140.0, 60.0, 3.0), (60.0, 30.0, 0.0))]
    for n, x in enumerate((15.0, 60.0, 105.0)):
        solids += [(names.format(n=n), "", (25.0, 30.0, 1.0), (x, 30.0, 4.0)),
                   (f"R{n}1", "", (1.6, 0.8, 0.5), (x - 6.0, 25.0, 5.0)),
                   (f"U{n}2", "", (5.0, 4.0, 1.7), (x + 4.0, 33.0, 5.0))]  # fmt: skip
    board = write_model(tmp_path / "b.glb", solids)
    assert max(each.area_mm2 for each in board.components) < 0.1 * board.outline.area
    assert board.instances or rules(board) & {"nested-boards", "not-on-the-board", "panel-boards"}
