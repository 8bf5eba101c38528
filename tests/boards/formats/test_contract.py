"""What every board format has to keep to: the same board through each of them is the same board.

A format is enrolled by its suffix in ``SUFFIXES``; what writes it, and what it cannot hold, is in ``WRITERS``.
"""

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import trimesh
from ecad_writers import (
    EcadBoard,
    EcadPart,
    allegro,
    gencad,
    gerber_profile,
    ipc2581,
    odb,
    placement_table,
    write_tgz,
    write_zip,
)
from shapely import Polygon, affinity, box
from step_writer import StepWriter

from boards.board import Board, Body, Component, Side
from boards.formats.prism import prism
from boards.formats.tri.tri import write_tri
from boards.load import PANEL_SUFFIX, SUFFIXES, load_board

TOP_MM = 1.6
EXACT_MM = 0.02
OUTLINE = box(0, 0, 60, 40)


@dataclass(frozen=True)
class Part:
    """A box on one side; its place and its turn are as seen from the top."""

    name: str
    middle: tuple[float, float]
    size: tuple[float, float, float]
    turn_deg: float
    side: Side

    @property
    def outline(self) -> Polygon:
        """In plan."""
        (x, y), (width, depth, _) = self.middle, self.size
        flat = box(x - width / 2, y - depth / 2, x + width / 2, y + depth / 2)
        return affinity.rotate(flat, self.turn_deg, origin=self.middle)

    @property
    def low(self) -> float:
        """Height of its lower face."""
        return TOP_MM if self.side == "top" else -self.size[2]


PARTS = (
    Part("U1", (20.0, 15.0), (8.0, 6.0, 1.5), 30.0, "top"),
    Part("C1", (45.0, 30.0), (2.0, 1.0, 0.8), 90.0, "top"),
    Part("J1", (35.0, 12.0), (10.0, 4.0, 5.0), 20.0, "bottom"),
)


def bodies() -> list[Body]:
    solids = [Body("board", "board", *prism(OUTLINE, 0.0, TOP_MM))]
    return solids + [
        Body(each.name, "component", *prism(each.outline, each.low, each.low + each.size[2])) for each in PARTS
    ]


def meshes() -> Iterable[tuple[str, trimesh.Trimesh]]:
    for body in bodies():
        mesh = trimesh.Trimesh(**trimesh.triangles.to_kwargs(body.patches))
        yield "PCB" if body.role == "board" else body.name, mesh


def tri(file: Path) -> None:
    file.write_text(write_tri(bodies()), "utf-8")


def tri_gz(file: Path) -> None:
    import gzip

    file.write_bytes(gzip.compress(write_tri(bodies()).encode()))


def step(file: Path) -> None:
    placed = [("PCB", "PCB", (60.0, 40.0, TOP_MM), (30.0, 20.0, 0.0))]
    placed += [(each.name, each.name, each.size, (*each.middle, each.low)) for each in PARTS]
    file.write_text(StepWriter().write(placed, {each.name: each.turn_deg for each in PARTS}), "utf-8")


def gltf(file: Path) -> None:
    """In metres, y up."""
    scene = trimesh.Scene()
    matrix = trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)) @ np.diag([1e-3, 1e-3, 1e-3, 1.0])
    scene.graph.update(frame_from="world", frame_to="assembly", matrix=matrix)
    for name, mesh in meshes():
        scene.add_geometry(mesh, node_name=name, geom_name=f"mesh of {name}", parent_node_name="assembly")
    scene.export(file)


def heap(file: Path) -> None:
    """All triangles in one heap, without names."""
    trimesh.util.concatenate([mesh for _, mesh in meshes()]).export(file)


def idf(file: Path) -> None:
    """Turns on the bottom are as seen from there."""
    board = [".HEADER", 'BOARD_FILE 3.0 "test" 2024/05/01.10:00:00 1', "card MM", ".END_HEADER", ".BOARD_OUTLINE ECAD"]
    board += [str(TOP_MM), *loop(OUTLINE), ".END_BOARD_OUTLINE", ".PLACEMENT"]
    library = [".HEADER", 'LIBRARY_FILE 3.0 "test" 2024/05/01.10:00:00 1', ".END_HEADER"]
    for each in PARTS:
        width, depth, height = each.size
        flat = box(-width / 2, -depth / 2, width / 2, depth / 2)
        library += [".ELECTRICAL", f"box-{each.name} none MM {height}", *loop(flat), ".END_ELECTRICAL"]
        turn = each.turn_deg if each.side == "top" else -each.turn_deg % 360.0
        x, y = each.middle
        board += [f"box-{each.name} none {each.name}", f"{x} {y} 0.0 {turn} {each.side.upper()} PLACED"]
    names = file.with_suffix(".emn"), file.with_suffix(".emp")
    for name, lines in zip(names, (board, library), strict=True):
        name.write_text("\n".join([*lines, ".END_PLACEMENT"] if lines is board else lines) + "\n", "utf-8")
    if file.suffix == ".idf":
        names[0].rename(file)


def loop(outline: Polygon) -> list[str]:
    return [f"0 {x} {y} 0.0" for x, y in outline.exterior.coords]


def kicad(file: Path) -> None:
    """With y downwards, and heights by package name alone."""
    text = [f"(kicad_pcb (version 20241229) (general (thickness {TOP_MM}))"]
    corners = list(OUTLINE.exterior.coords)
    for (x, y), (end_x, end_y) in pairwise(corners):
        text.append(f'(gr_line (start {x} {-y}) (end {end_x} {-end_y}) (layer "Edge.Cuts"))')
    for each in PARTS:
        layer, (x, y), (width, depth, _) = "F" if each.side == "top" else "B", each.middle, each.size
        text += [
            f'(footprint "Package_SO:SOIC-8" (layer "{layer}.Cu") (at {x} {-y} {each.turn_deg})',
            f'(property "Reference" "{each.name}" (at 0 0) (layer "{layer}.SilkS"))',
            f'(fp_rect (start {-width / 2} {-depth / 2}) (end {width / 2} {depth / 2}) (layer "{layer}.Fab"))',
            f'(pad "1" smd rect (at 0 0) (size 1 1) (layers "{layer}.Cu")))',
        ]
    file.write_text("\n".join([*text, ")"]), "utf-8")


def eagle(file: Path) -> None:
    """XML in mm; turns on the bottom are as seen from there, and packages are drawn as seen from their own side."""
    edges = [f'<wire x1="{x}" y1="{y}" x2="{u}" y2="{v}" width="0" layer="20"/>' for (x, y), (u, v) in sides(OUTLINE)]
    packages: list[str] = []
    elements: list[str] = []
    for each in PARTS:
        (x, y), (width, depth, _) = each.middle, each.size
        flat = box(-width / 2, -depth / 2, width / 2, depth / 2)
        drawn = [
            f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="0.1" layer="51"/>' for (a, b), (c, d) in sides(flat)
        ]
        pad = '<smd name="1" x="0" y="0" dx="1" dy="1" layer="1"/>'
        packages.append(f'<package name="SO08-{each.name}">{"".join(drawn)}{pad}</package>')
        rot = f"R{each.turn_deg}" if each.side == "top" else f"MR{-each.turn_deg % 360.0}"
        named = f'name="{each.name}" library="own" package="SO08-{each.name}"'
        elements.append(f'<element {named} value="" x="{x}" y="{y}" rot="{rot}"/>')
    text = [
        '<?xml version="1.0" encoding="utf-8"?>',
        '<!DOCTYPE eagle SYSTEM "eagle.dtd">',
        f'<eagle version="7.7.0"><drawing><board><plain>{"".join(edges)}</plain>',
        f'<libraries><library name="own"><packages>{"".join(packages)}</packages></library></libraries>',
        f"<elements>{''.join(elements)}</elements></board></drawing></eagle>",
    ]
    file.write_text("\n".join(text), "utf-8")


def ecad() -> EcadBoard:
    parts = (EcadPart(each.name, *each.middle, *each.size, each.turn_deg, each.side) for each in PARTS)
    return EcadBoard(OUTLINE, TOP_MM, tuple(parts))


def ipc_c(file: Path) -> None:
    file.write_text(ipc2581(ecad()), "utf-8")


def ipc_b(file: Path) -> None:
    file.write_text(ipc2581(ecad(), "B", "INCH"), "utf-8")


def odb_tgz(file: Path) -> None:
    write_tgz(odb(ecad()), file)


def odb_zip(file: Path) -> None:
    write_zip(odb(ecad(), "INCH"), file)


def gencad_inch(file: Path) -> None:
    file.write_text(gencad(ecad()), "utf-8")


def allegro_mils(file: Path) -> None:
    file.write_text(allegro(ecad()), "utf-8")


def gerber(file: Path) -> None:
    """The profile alone; a table beside it places the parts, whose sizes are in their names."""
    file.write_text(gerber_profile(ecad()), "utf-8")
    file.with_suffix(".csv").write_text(placement_table(ecad()), "utf-8")


def panel(file: Path) -> None:
    """A panel of one board, whose corner is at the origin anyway; components bear its number."""
    tri(file.with_suffix(".tri"))
    file.write_text(f"panel: {{board: {file.stem}.tri}}\n", "utf-8")


def sides(outline: Polygon) -> Iterable[tuple[tuple[float, float], tuple[float, float]]]:
    return pairwise(outline.exterior.coords)


WRITERS: dict[str, tuple[Callable[[Path], None], bool, bool]] = {
    ".tri": (tri, True, True),
    ".tri.gz": (tri_gz, True, True),
    ".step": (step, True, True),
    ".stp": (step, True, True),
    ".glb": (gltf, True, True),
    ".gltf": (gltf, True, True),
    ".stl": (heap, False, True),
    ".obj": (heap, False, True),
    ".ply": (heap, False, True),
    ".emn": (idf, True, True),
    ".emp": (idf, True, True),
    ".idf": (idf, True, True),
    ".kicad_pcb": (kicad, True, False),
    ".brd": (eagle, True, False),
    ".yaml": (panel, False, True),
    ".xml": (ipc_c, True, True),
    ".cvg": (ipc_b, True, True),
    ".tgz": (odb_tgz, True, True),
    ".tar.gz": (odb_tgz, True, True),
    ".zip": (odb_zip, True, True),
    ".cad": (gencad_inch, True, True),
    ".fab": (allegro_mils, True, True),
    ".val": (allegro_mils, True, True),
    ".gbr": (gerber, True, True),
    ".gm1": (gerber, True, True),
    ".gko": (gerber, True, True),
}
"""By suffix: what writes the board, whether the format keeps names, and whether it keeps heights."""


def read(tmp_path: Path, suffix: str) -> Board:
    assert suffix in WRITERS, f"{suffix} is read, but {__file__} has no writer for it"
    file = tmp_path / f"card{suffix}"
    WRITERS[suffix][0](file)
    table = file.with_suffix(".csv")
    return load_board(file, table if table.exists() else None)


def found(board: Board, part: Part) -> Component:
    """The component that lies where a part does."""
    return min(board.components, key=lambda each: each.outline.centroid.distance(part.outline.centroid))


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [*SUFFIXES, PANEL_SUFFIX])
def test_the_same_board_is_read_from_every_format(suffix: str, tmp_path: Path) -> None:
    board = read(tmp_path, suffix)
    _, names, heights = WRITERS[suffix]
    assert board.outline.symmetric_difference(OUTLINE).area < EXACT_MM
    assert (board.bottom_z_mm, board.top_z_mm) == pytest.approx((0.0, TOP_MM), abs=EXACT_MM)
    assert len(board.components) == len(PARTS)
    for part in PARTS:
        component = found(board, part)
        assert component.side == part.side
        assert component.outline.hausdorff_distance(part.outline) < EXACT_MM
        assert component.area_mm2 == pytest.approx(part.outline.area, rel=5e-3)
        assert component.name == part.name or not names
        assert component.height_mm == pytest.approx(part.size[2], abs=EXACT_MM) or not heights


@pytest.mark.slow
@pytest.mark.parametrize("suffix", [*SUFFIXES, PANEL_SUFFIX])
def test_the_order_of_objects_in_a_file_has_no_effect(
    suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two chips are alike, and two parts share a name where the format allows it."""
    twins = tuple(Part(name, (x, 34.0), (3.0, 2.0, 1.0), 0.0, "top") for name, x in (("R10", 8.0), ("R9", 28.0)))
    same_name = (replace(twins[0], name="U1", middle=(52.0, 8.0)),) if suffix in (".kicad_pcb", ".xml") else ()
    in_order, dice = bodies, random.Random(7)
    boards: list[Board] = []
    for number in range(3):
        parts = [*PARTS, *twins, *same_name]
        dice.shuffle(parts)
        with monkeypatch.context() as patched:
            patched.setitem(globals(), "PARTS", tuple(parts))
            patched.setitem(globals(), "bodies", lambda: dice.sample(found := in_order(), len(found)))
            (tmp_path / str(number)).mkdir()
            boards.append(read(tmp_path / str(number), suffix))
    one, *others = boards
    for other in others:
        assert other.sha256 == one.sha256
        assert [each.name for each in other.bodies] == [each.name for each in one.bodies]
        assert [str(each) for each in other.findings] == [str(each) for each in one.findings]
