"""A body stands only where something with a body is soldered, whatever tool names it."""

from itertools import pairwise
from pathlib import Path

import pytest

from boards.board import Board
from boards.formats.tree import Node, split_parts
from boards.load import load_board
from boards.packages.families import is_bare
from boards.packages.heights import HeightEvidence, body_height

EDGE = [(0, 0, 40, 0), (40, 0, 40, 30), (40, 30, 0, 30), (0, 30, 0, 0)]


def smd(name: str, x: float, y: float, dx: float, dy: float) -> str:
    return f'<smd name="{name}" x="{x}" y="{y}" dx="{dx}" dy="{dy}" layer="1"/>'


def eagle(folder: Path, packages: dict[str, str], elements: list[tuple[str, str, float, float]]) -> Board:
    """A board of Eagle 9 from its packages by name and its elements: name, package, place."""
    wires = "".join(f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="0.1" layer="20"/>' for a, b, c, d in EDGE)
    library = "".join(f'<package name="{name}">{inner}</package>' for name, inner in packages.items())
    placed = "".join(
        f'<element name="{n}" library="l" package="{p}" value="" x="{x}" y="{y}"/>' for n, p, x, y in elements
    )
    (folder / "b.brd").write_text(
        f'<?xml version="1.0"?><eagle version="9.6.2"><drawing><board><plain>{wires}</plain><libraries>'
        f'<library name="l"><packages>{library}</packages></library></libraries>'
        f"<elements>{placed}</elements></board></drawing></eagle>",
        "utf-8",
    )
    return load_board(folder / "b.brd")


ROWS = "".join(
    smd(str(n), x, y, 1.5, 0.6) for n, (x, y) in enumerate([(x, y) for x in (-2.7, 2.7) for y in (-1.9, 0, 1.9)])
)


def heights(board: Board) -> dict[str, float]:
    return {each.name: each.height_mm for each in board.components}


def test_vias_in_a_flat_part_are_no_leads_in_eagle(tmp_path: Path) -> None:
    vias = "".join(f'<pad name="V{n}" x="{n - 1}" y="0" drill="0.3" diameter="0.6"/>' for n in range(3))
    in_pad = smd("EP", 0, 0, 3, 3) + '<pad name="E1" x="0.5" y="0.5" drill="0.5" diameter="0.9"/>'
    leads = '<pad name="S1" x="-4" y="0" drill="0.8" diameter="1.4"/>'
    kinds = {"XQ1": ROWS, "XQ2": ROWS + vias, "XQ3": ROWS + in_pad, "XQ4": ROWS + leads}
    found = heights(eagle(tmp_path, kinds, [(f"U{n}", f"XQ{n}", 8 * n, 15) for n in range(1, 5)]))
    assert found["U1"] == found["U2"] == found["U3"] < found["U4"]


def odb(folder: Path, parts: list[tuple[str, str, float, int]]) -> Board:
    """A job in mm, as Allegro writes it: name, package, stated height, pins."""
    step = folder / "job/steps/pcb"
    for each in ("matrix", "misc", "steps/first", "steps/pcb/layers/comp_+_top", "steps/pcb/eda"):
        (folder / "job" / each).mkdir(parents=True)
    (folder / "job/matrix/matrix").write_text(
        "STEP {\n COL=1\n NAME=FIRST\n}\nSTEP {\n COL=2\n NAME=PCB\n}\n"
        "LAYER {\n ROW=1\n CONTEXT=BOARD\n TYPE=COMPONENT\n NAME=COMP_+_TOP\n POLARITY=POSITIVE\n}\n"
    )
    (folder / "job/misc/info").write_text("UNITS=MM\n")
    (folder / "job/steps/first/profile").write_text("UNITS=MM\n#\n")
    (step / "profile").write_text("UNITS=MM\nS P 0\nOB 0 0 I\nOS 60 0\nOS 60 30\nOS 0 30\nOS 0 0\nOE\nSE\n")
    packages, placed = ["HDR own", "UNITS=MM"], ["UNITS=MM", "@0 .comp_height"]
    for row, (name, package, height, pins) in enumerate(parts):
        packages.append(
            f"PKG {package} 1 -1.1 -1.1 1.1 1.1;;ID=1\nCT\nOB -1 -1 I\nOS 1 -1\nOS 1 1\nOS -1 1\nOS -1 -1\nOE\nCE"
        )
        packages += [
            f"PIN {pin} S {x} 0 0 E S\nRC {x - 0.3} -0.3 0.6 0.6" for pin, x in enumerate([0.0, -1.0][:pins], 1)
        ]
        placed.append(f"CMP {row} {5 + 6 * row} 15 0 N {name} PN ;0={height};ID={row}")
    (step / "eda/data").write_text("\n".join(packages) + "\n")
    (step / "layers/comp_+_top/components").write_text("\n".join(placed) + "\n")
    return load_board(folder / "job")


def test_holes_marks_and_test_points_of_odb_are_left_out(tmp_path: Path) -> None:
    parts = [
        ("MTG1", "MTG_125_250", 0.0254, 1),
        ("FD1", "FIDUCIAL40", 0.0254, 1),
        ("TP9", "TP_SMD_30", 0.0254, 1),
        ("H3", "NPTH3R2", 0.0254, 1),
        ("TP10", "KEYSTONE_5015", 3.2, 1),
        ("R1", "R0603", 0.5, 2),
    ]
    board = odb(tmp_path, parts)  # the first step has an empty profile
    assert set(heights(board)) == {"TP10", "R1"}
    assert any(finding.rule.id == "no-body" for finding in board.findings)


@pytest.mark.parametrize(
    ("package", "reference", "pins", "height_mm", "expected"),
    [
        ("MTHOLE_6", "MH1", 9, 0.0254, True),  # a ring of vias around the screw
        ("HDR_1X02", "H1", 2, None, False),  # a header
        ("CONN_MOUNT", "J1", 4, 0.2, False),
        ("TESTPAD", "TP3", 1, None, True),
        ("SOT23", "TP3", 3, None, False),
        ("U_XYZ", "U1", 1, 0.05, False),
    ],
)
def test_what_is_bare(package: str, reference: str, pins: int, height_mm: float | None, expected: bool) -> None:
    assert is_bare([package], reference, pins, height_mm) is expected


@pytest.mark.parametrize("model", ["HEATSINK_40x40x20mm.step", "M3_Screw_H12mm.wrl", "Cooler-Fan_H35mm.step"])
def test_the_model_of_an_accessory_is_not_that_of_the_chip(model: str) -> None:
    chip = HeightEvidence("own_ASIC", "U1", (model,), through_hole=False, length_mm=7.0)
    assert body_height(chip) == body_height(HeightEvidence("own_ASIC", "U1", through_hole=False, length_mm=7.0))
    both = HeightEvidence("own_ASIC", "U1", (model, "QFN-32_H0.9mm.step"), through_hole=False, length_mm=7.0)
    assert body_height(both).height_mm == 0.9
    sink = HeightEvidence("Heatsink_Fischer", "HS1", ("Heatsink_H20mm.step",), length_mm=40.0)
    assert body_height(sink).height_mm >= 20.0


def drawing(x: float, y: float, layer: int = 21) -> str:
    corners = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
    return "".join(
        f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="0.1" layer="{layer}"/>'
        for (a, b), (c, d) in pairwise(corners)
    )


def test_print_between_the_pads_is_not_the_body(tmp_path: Path) -> None:
    kinds = {"XA": ROWS + drawing(1.1, 2.4), "XB": ROWS + drawing(1.9, 2.5)}
    board = eagle(tmp_path, kinds, [("U1", "XA", 10, 15), ("U2", "XB", 25, 15)])
    across = {each.name: each.outline.bounds[2] - each.outline.bounds[0] for each in board.components}
    assert across["U1"] > 3.7
    assert across["U2"] == pytest.approx(3.8, abs=0.01)


def test_a_solid_inside_a_part_does_not_split_it() -> None:
    import trimesh

    box = (trimesh.creation.box((1, 1, 1)).triangles,)
    board = Node("Board", "Board", box)
    plug = Node("7", "output", (), (Node("P2", "P2", box), Node("shell", "shell", box)))
    group = Node("8", "components", (), (Node("R1", "R1", box), Node("R2", "R2", box), Node("lid", "lid", box)))
    names = [part.name for part in split_parts(Node("", "", (), (board, plug, group)), board)]
    assert names == ["output", "R1", "R2", "lid"]
