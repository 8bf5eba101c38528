"""3-D models beside the board's file: bodies of the model on the pads, pins and sides of the board, by designator."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from shutil import make_archive

import numpy as np
import pytest
import trimesh
from command import washboard
from ecad_writers import (
    EcadBoard,
    EcadPart,
    allegro,
    gencad,
    gerber_copper,
    gerber_profile,
    ipc2581,
    odb,
    placement_table,
    write_folder,
)
from orders import gerbers, middles, rules, table
from shapely import box
from shapely.affinity import rotate, translate
from shapely.ops import unary_union
from step_writer import StepWriter
from trimesh.transformations import euler_matrix, translation_matrix

from boards.board import Board
from boards.load import load_board

PARTS = (
    EcadPart("U1", 12.0, 10.0, 5.0, 4.0, 1.7, 0.0, "top", "SOIC-8", 8),
    EcadPart("R1", 24.0, 16.0, 1.6, 0.8, 0.5, 90.0, "top", "R0603"),
    EcadPart("J1", 30.0, 8.0, 6.0, 4.0, 5.0, 0.0, "top", "Box", 4),
    EcadPart("C1", 7.0, 18.0, 2.0, 1.2, 1.2, 180.0, "bottom", "C0805"),
    EcadPart("R2", 20.0, 5.0, 1.6, 0.8, 0.5, 0.0, "bottom", "R0603"),
)
CARD = EcadBoard(box(0, 0, 40, 24), 1.6, PARTS)
DRAWN = {"U1": 2.0, "R1": 0.6, "J1": 7.5, "C1": 1.3, "R2": 0.6}
"""Heights of the model, other than those stated and those of the packages."""
Box = tuple[str, tuple[float, float, float], tuple[float, float, float]]
"""Name, size, middle of the underside."""


def boxes(parts: Sequence[EcadPart] = PARTS, heights: Mapping[str, float] = DRAWN, slab: float = 1.6,
          size: tuple[float, float] = (40.0, 24.0)) -> list[Box]:  # fmt: skip
    """A model of the card whose top is z = 0."""
    found: list[Box] = [("card", (*size, slab), (size[0] / 2, size[1] / 2, -slab))]
    for each in parts:
        across = (each.depth, each.width) if each.turn_deg % 180.0 else (each.width, each.depth)
        height = heights[each.name]
        found.append((each.name, (*across, height), (each.x, each.y, 0.0 if each.side == "top" else -slab - height)))
    return found


def step(file: Path, parts: Sequence[Box], shift: tuple[float, float] = (0.0, 0.0)) -> Path:
    placed = [(name, f"{name}-model", size, (x + shift[0], y + shift[1], z)) for name, size, (x, y, z) in parts]
    placed[0] = (placed[0][0], "PCB", *placed[0][2:])
    file.write_text(StepWriter().write(placed))
    return file


def glb(file: Path, parts: Sequence[Box], turn_rad: float = 0.0) -> Path:
    """A model in mm, turned about z."""
    scene = trimesh.Scene()
    for name, size, (x, y, z) in parts:
        lies = euler_matrix(0.0, 0.0, turn_rad) @ translation_matrix((x, y, z + size[2] / 2))
        scene.add_geometry(trimesh.creation.box(size), node_name=name, geom_name=name, transform=lies)
    file.write_bytes(bytes(scene.export(file_type="glb")))
    return file


def write_card(folder: Path, kind: str, card: EcadBoard = CARD) -> Path:
    folder.mkdir(exist_ok=True)
    match kind:
        case "Gerber":
            layers = {"edge.gbr": gerber_profile(card), "places.csv": placement_table(card)}
            layers |= {f"{side}.gbr": gerber_copper(card, side) for side in ("top", "bottom")}
            write_folder(layers, folder)
        case "ODB++":
            write_folder(odb(card), folder / "job")
        case "IPC-2581":
            (folder / "card.xml").write_text(ipc2581(card, copper=True))
        case "GenCAD":
            (folder / "card.cad").write_text(gencad(card))
        case _:
            (folder / "card.fab").write_text(allegro(card))
    return folder


def heights(board: Board) -> dict[str, float]:
    return {each.name: each.height_mm for each in board.components}


def pads(board: Board) -> dict[str, int]:
    return {body.name: len(body.pads) for body in board.bodies if body.pads}


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("model", ["STEP", "glTF"])
@pytest.mark.parametrize("kind", ["Gerber", "ODB++", "IPC-2581", "GenCAD", "Allegro"])
def test_bodies_are_those_of_the_model_on_the_pads_of_the_board(
    tmp_path: Path, kind: str, model: str, packed: bool
) -> None:
    path = write_card(tmp_path / "order", kind)
    alone = load_board(path)
    (step(path / "card.step", boxes(), (-20.0, 35.0)) if model == "STEP" else glb(path / "card.glb", boxes()))
    if packed:
        path = Path(make_archive(str(tmp_path / "packed"), "zip", path))
    board = load_board(path)
    assert heights(board) == pytest.approx(DRAWN)
    for name, (x, y, side) in middles(alone).items():
        assert middles(board)[name] == (pytest.approx(x, abs=0.31), pytest.approx(y, abs=0.31), side)
    assert middles(board)["U1"] == (12.0, 10.0, "top")
    assert pads(board) == pads(alone) != {}
    for name in ("package", "part", "value", "pins", "side"):
        assert [getattr(each, name) for each in board.components] == [getattr(each, name) for each in alone.components]
    assert board.outline.equals(alone.outline)
    kinds = {each.name: each.kind for each in board.sources}
    assert [each for each in kinds.values() if "3-D model" in each] == [f"3-D model, {model}"]
    assert {each.rule.id: each.message for each in board.findings}["model-found"].startswith("5 of 5 components have")
    assert ("parts-frame" in rules(board)) == (model == "STEP")
    assert "order-boards" not in rules(board)


@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_a_turned_model_is_turned_back(tmp_path: Path, quarter: int) -> None:
    path = write_card(tmp_path / "order", "ODB++")
    alone = load_board(path)
    glb(path / "card.glb", boxes(), quarter * np.pi / 2)
    board = load_board(path)
    assert heights(board) == pytest.approx(DRAWN)
    assert middles(board) == middles(alone)


def test_a_model_that_lies_upside_down_is_turned_over(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "ODB++")
    alone = load_board(path)
    over = [(name, size, (-x, y, -z - size[2])) for name, size, (x, y, z) in boxes()]
    step(path / "card.step", over)
    board = load_board(path)
    assert heights(board) == pytest.approx(DRAWN)
    assert middles(board) == middles(alone)
    assert {each.about for each in board.contradictions} == {"height"}


def test_bodies_without_designators_are_joined_by_position(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    named = [(name if name == "card" else f"solid {number}", *rest) for number, (name, *rest) in enumerate(boxes())]
    step(path / "card.step", named, (3.0, 4.0))  # pyright: ignore[reportArgumentType]
    board = load_board(path)
    assert heights(board) == pytest.approx(DRAWN)
    assert "5 bodies of card.step joined by position" in {e.rule.id: e.message for e in board.findings}[
        "parts-by-position"]  # fmt: skip


def test_what_contradicts_is_noted_and_the_rest_joined(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    other = [replace(each, side="top") if each.name == "R2" else replace(each, x=20.0) if each.name == "J1" else each
             for each in PARTS]  # fmt: skip
    step(path / "card.step", boxes(other, slab=1.0))
    board = load_board(path)
    found = {(each.component, each.about): (each.taken, each.source, each.other) for each in board.contradictions}
    assert found["R2", "side"] == ("bottom", "card.xml", "top")
    assert found["J1", "place"] == ("(30.00, 8.00)", "card.xml", "(20.00, 8.00)")
    assert found["board", "thickness"] == ("1.60 mm", "card.xml", "1.00 mm")
    assert found["U1", "height"] == ("2.00 mm", "card.step", "1.70 mm")
    assert heights(board) == pytest.approx({**DRAWN, "R2": 0.5, "J1": 5.0})
    assert {each.name: each.side for each in board.components}["R2"] == "bottom"
    assert sum(each.rule.id == "parts-contradict" for each in board.findings) == 4
    assert not {"order-boards", "component-outside"} & rules(board)


def test_parts_that_one_of_the_two_has_alone(tmp_path: Path) -> None:
    """A body without a component is an obstacle, a component without a body keeps its own; on both sides."""
    path = write_card(tmp_path / "order", "IPC-2581")
    sink = EcadPart("HS1", 33.0, 19.0, 6.0, 6.0, 20.0, 0.0, "top")
    under = EcadPart("HS2", 33.0, 19.0, 6.0, 6.0, 9.0, 0.0, "bottom")
    step(path / "card.step", boxes([*PARTS[1:4], sink, under], {**DRAWN, "HS1": 20.0, "HS2": 9.0}))
    board = load_board(path)
    assert heights(board) == pytest.approx({**DRAWN, "U1": 1.7, "R2": 0.5})
    assert [each.height_mm for each in board.top_obstacles if each.name == "HS1"] == pytest.approx([20.0])
    assert [each.height_mm for each in board.bottom_obstacles if each.name == "HS2"] == pytest.approx([9.0])
    notes = {each.rule.id: each.message for each in board.findings}
    assert "2 components have no body in card.step and keep their own: R2, U1" in notes["model-without-body"]
    assert "2 bodies of card.step are of no component" in notes["model-obstacles"]


def check_left_out(board: Board, *names: str) -> None:
    """Neither a component nor an obstacle, and told once."""
    assert not {body.name for body in board.bodies} & {*names}
    texts = [each.message for each in board.findings if each.rule.id == "parts-not-fitted"]
    assert len(texts) == 1
    assert all(name in texts[0] for name in names)
    assert not {"model-obstacles", "parts-not-on-board"} & rules(board)


KICAD = """(kicad_pcb (version 20221018) (generator pcbnew) (general (thickness 1.6))
(gr_rect (start 0 -24) (end 40 0) (layer "Edge.Cuts"))
{})
"""
EAGLE = (
    '<?xml version="1.0"?><eagle version="9.6.2"><drawing><board><plain>{}</plain><libraries><library name="l">'
    '<packages><package name="R0603"><smd name="1" x="-0.8" y="0" dx="0.9" dy="0.95" layer="1"/>'
    '<smd name="2" x="0.8" y="0" dx="0.9" dy="0.95" layer="1"/></package></packages></library></libraries>'
    "<elements>{}</elements></board></drawing></eagle>"
)
POPULATE = ' populate="no"'


def write_unfitted(folder: Path, kind: str, name: str) -> Path:
    """The card, one of whose parts its file states not to be fitted."""
    if kind in ("ODB++", "IPC-2581"):
        write_card(folder, kind)
        file = folder / "card.xml" if kind == "IPC-2581" else folder / "job/steps/card/layers/comp_+_top/components"
        text = file.read_text()
        old, new = (f'<RefDes name="{name}" packageRef="SOIC-8" populate="true"',
                    f'<RefDes name="{name}" packageRef="SOIC-8" populate="false"')  # fmt: skip
        if kind == "ODB++":
            line = next(each for each in text.splitlines() if f" {name} " in each)
            text, old, new = text.replace("@1 .comp_height", "@1 .comp_height\n@2 .no_pop"), line, f"{line},2"
        assert old in text
        file.write_text(text.replace(old, new))
        return folder
    folder.mkdir()
    if kind == "KiCad":
        pads = "".join(
            f'(pad "{n}" smd rect (at {x} 0) (size 0.9 0.95) (layers "F.Cu"))' for n, x in ((1, -0.8), (2, 0.8))
        )
        parts = "".join(
            f'(footprint "R_0603" (layer "{side}.Cu") (at {each.x} {-each.y} {each.turn_deg})'
            f'(attr smd{" dnp" * (each.name == name)}) (property "Reference" "{each.name}")'
            f"{pads.replace('F.', side + '.')})\n"
            for each in PARTS for side in ["F" if each.side == "top" else "B"])  # fmt: skip
        (folder / "card.kicad_pcb").write_text(KICAD.format(parts))
        return folder
    corners = [(0, 0), (40, 0), (40, 24), (0, 24), (0, 0)]
    wires = "".join(
        f'<wire x1="{x}" y1="{y}" x2="{u}" y2="{v}" width="0" layer="20"/>' for (x, y), (u, v) in pairwise(corners)
    )
    elements = "".join(
        f'<element name="{each.name}" library="l" package="R0603" value="1k" x="{each.x}" y="{each.y}" '
        f'rot="{"M" * (each.side == "bottom")}R{each.turn_deg:g}"{POPULATE * (each.name == name)}/>'
        for each in PARTS
    )
    (folder / "card.brd").write_text(EAGLE.format(wires, elements))
    return folder


@pytest.mark.parametrize("stated", ["", "DNP", "fitted", "listed"])
@pytest.mark.parametrize("kind", ["KiCad", "Eagle", "IPC-2581", "ODB++"])
def test_a_modelled_part_that_the_board_leaves_out_has_no_body(tmp_path: Path, kind: str, stated: str) -> None:
    path = write_unfitted(tmp_path / "order", kind, "U1")
    step(path / "card.step", boxes())
    cells = {"DNP": "yes", "fitted": "no", "listed": ""}
    if stated:
        title = "" if stated == "listed" else ",DNP"
        rows = (f"{each.name},X{n}{(',' + (cells[stated] if each.name == 'U1' else 'no')) * bool(title)}\n"
                for n, each in enumerate(PARTS))  # fmt: skip
        table(path, "bom.csv", f"Designator,MPN{title}\n{''.join(rows)}")
    board = load_board(path)
    assert len(board.components) == 4
    check_left_out(board, "U1")
    found = [each for each in board.contradictions if each.about == "fitted"]
    assert [(each.component, each.taken, each.other) for each in found] == (
        [("U1", "not fitted", "fitted")] if stated == "fitted" else []
    )


def test_a_row_that_is_fitted_and_has_no_body_in_the_model_is_told(tmp_path: Path) -> None:
    """The model is the board; and beside a board, whose own body is kept."""
    (tmp_path / "model").mkdir()
    step(tmp_path / "model" / "card.step", boxes([each for each in PARTS if each.name != "U1"]))
    path = write_card(tmp_path / "order", "IPC-2581")
    step(path / "card.step", boxes([each for each in PARTS if each.name != "U1"]))
    for folder, rule in ((tmp_path / "model", "parts-not-on-board"), (path, "model-without-body")):
        table(folder, "bom.csv", "Designator,MPN,Fitted\n" + "".join(f"{each.name},X,yes\n" for each in PARTS))
        assert "U1" in {each.rule.id: each.message for each in load_board(folder).findings}[rule]


def test_a_row_of_the_table_is_enough_for_a_body(tmp_path: Path) -> None:
    """Gerber files without the copper of a part and without a size of its package; one row is not fitted."""
    bare = replace(CARD, parts=tuple(each for each in PARTS if each.name not in ("J1", "U1")))
    path = write_card(tmp_path / "order", "Gerber", bare)
    rows = "Ref,Package,PosX,PosY,Rot,Side,Fitted\n" + "".join(
        f"{each.name},Gizmo,{each.x},{each.y},{each.turn_deg},{each.side},{'no' if each.name == 'U1' else 'yes'}\n"
        for each in PARTS)  # fmt: skip
    table(path, "places.csv", rows)
    step(path / "card.step", boxes())
    board = load_board(path)
    assert heights(board) == pytest.approx({name: mm for name, mm in DRAWN.items() if name != "U1"})
    assert {each.name: each.package for each in board.components}["J1"] == "Gizmo"
    check_left_out(board, "U1")


@pytest.mark.parametrize("stated", ["", "board: card.xml\n", "board: other.step\n"])
def test_a_model_of_another_board_is_one_error_that_the_columns_file_answers(tmp_path: Path, stated: str) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    other = [replace(each, name=f"X{n}", x=60.0 - each.x, y=each.y + n) for n, each in enumerate(PARTS[:4])]
    step(path / "other.step", boxes(other, {f"X{n}": 3.0 for n in range(4)}, size=(70.0, 40.0)))
    (path / "columns.yaml").write_text(stated or "tables: []\n")
    board = load_board(path)
    found = [each for each in board.findings if each.rule.id == "order-boards"]
    assert len(board.components) == (4 if "step" in stated else 5)
    if stated:
        assert not found
        return
    assert (
        "card.xml (5 components on 40.0 x 24.0 mm) and other.step (4 components on 70.0 x 40.0 mm)" in found[0].message
    )
    assert "0 of 4 designators are in both. card.xml is taken alone" in found[0].message
    assert "`board: card.xml` or `board: other.step`" in found[0].message
    outcome = washboard("plan", path, "-o", tmp_path / "a.wash")
    assert outcome.code == 2
    assert not (tmp_path / "a.wash").exists()


def test_equal_designators_at_other_places_are_of_another_board(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    places = [(20.0, 20.0), (5.0, 5.0), (10.0, 18.0), (33.0, 3.0), (35.0, 20.0)]
    other = [replace(each, x=x, y=y) for each, (x, y) in zip(PARTS, places, strict=True)]
    step(path / "card.step", boxes(other))
    board = load_board(path)
    (found,) = (each.message for each in board.findings if each.rule.id == "order-boards")
    assert "5 of 5 designators are in both, and their places do not fit each other" in found
    assert heights(board)["U1"] == pytest.approx(1.7)


def test_of_two_models_the_one_of_the_board_is_joined(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    step(
        path / "a_case.step", [("card", (80.0, 60.0, 3.0), (0.0, 0.0, 0.0)), ("lid", (9.0, 9.0, 9.0), (0.0, 0.0, 3.0))]
    )
    (path / "b_damaged.step").write_text("ISO-10303-21;\nHEADER;\n")
    step(path / "card.step", boxes())
    glb(path / "card.glb", boxes(heights=dict.fromkeys(DRAWN, 9.0)))
    board = load_board(path)
    assert heights(board) == pytest.approx(DRAWN)
    assert "order-boards" not in rules(board)
    states = {each.name: each.states for each in board.sources}
    assert states["a_case.step"] == "not of one board with card.xml"
    assert "cannot be read: " in states["b_damaged.step"]
    assert states["card.glb"] == "glTF; card.xml is the board"


def test_gerber_files_without_components_leave_the_board_to_the_model(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    step(layers / "card.step", boxes(), (5.0, 5.0))
    board = load_board(layers)
    assert heights(board) == pytest.approx(DRAWN)
    assert {each.name: each.kind for each in board.sources} == {"card.step": "board, STEP", "layers": "not read"}
    (layers / "b.gko").write_text("%FSLAX46Y46*%\nM02*\n")
    assert heights(load_board(layers)) == pytest.approx(DRAWN)


def test_a_table_beside_both_is_joined_to_both(tmp_path: Path) -> None:
    path = write_card(tmp_path / "order", "IPC-2581")
    table(path, "bom.csv", "Designator,MPN,Height\nU1,ACME-1,9.0\nR1,ACME-2,0.6\n")
    step(path / "card.step", boxes())
    board = load_board(path)
    assert {each.name: each.part for each in board.components}["U1"] == "ACME-1"
    assert heights(board) == pytest.approx(DRAWN)
    assert [each.component for each in board.contradictions if each.other_source == "bom.csv" and
            each.about == "height"] == ["U1"]  # fmt: skip


COPIES = [(0.0, 0.0, 0.0), (42.0, 0.0, 0.0), (126.0, 24.0, 180.0)]
"""Where the card lies on a panel, the last one turned."""


def panel_of(cards: Sequence[tuple[EcadBoard, tuple[float, float, float], str]]) -> EcadBoard:
    """Cards apart from each other in one file; ``{}`` in the names of a card is the designator."""
    outlines, parts = [], list[EcadPart]()
    for card, (x, y, turn), names in cards:
        outlines.append(translate(rotate(card.outline, turn, origin=(0, 0)), x, y))
        sign = -1.0 if turn else 1.0
        parts += [replace(each, name=names.format(each.name), x=x + sign * each.x, y=y + sign * each.y,
                          turn_deg=each.turn_deg + turn) for each in card.parts]  # fmt: skip
    return EcadBoard(unary_union(outlines), 1.6, tuple(parts))


def write_idf(folder: Path, panel: EcadBoard) -> Path:
    """IDF, which draws outlines apart."""
    head = '.HEADER\n{} 3.0 "own" 2026/01/01 1\n'
    rings = [line for n, each in enumerate(panel.outline.geoms) for line in
             (f"{n} {x} {y} 0" for x, y in each.exterior.coords)]  # fmt: skip
    places = "".join(
        f'"{each.package}" "PN" {each.name}\n{each.x} {each.y} 0 {each.turn_deg} {each.side.upper()} PLACED\n'
        for each in panel.parts
    )
    kinds = {each.package: each for each in panel.parts}
    drawn = "".join(
        f'.ELECTRICAL\n"{name}" "PN" MM {each.height}\n'
        + "".join(f"0 {x * each.width / 2} {y * each.depth / 2} 0\n" for x, y in
                  ((-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1))) + ".END_ELECTRICAL\n"
        for name, each in kinds.items()
    )  # fmt: skip
    folder.mkdir(exist_ok=True)
    (folder / "p.emn").write_text(
        head.format("BOARD_FILE") + "p MM\n.END_HEADER\n.BOARD_OUTLINE ECAD\n1.6\n" + "\n".join(rings)
        + f"\n.END_BOARD_OUTLINE\n.PLACEMENT\n{places}.END_PLACEMENT\n"
    )  # fmt: skip
    (folder / "p.emp").write_text(head.format("LIBRARY_FILE") + f".END_HEADER\n{drawn}")
    return folder


@pytest.mark.parametrize("names", ["{0}", "{0}_{1}", "B{1}-{0}"])
@pytest.mark.parametrize("model", ["STEP", "glTF"])
def test_a_model_of_one_board_is_placed_on_each_board_of_a_panel(tmp_path: Path, model: str, names: str) -> None:
    """Heat sinks of the model stand on every board."""
    cards = [(CARD, at, names.format("{}", n)) for n, at in enumerate(COPIES, start=1)]
    path = write_idf(tmp_path / "order", panel_of(cards))
    alone = load_board(path)
    assert len(alone.instances) == 3
    drawn = [*boxes(), ("HS1", (6.0, 6.0, 20.0), (33.0, 19.0, 0.0))]
    (step(path / "card.step", drawn, (-20.0, 35.0)) if model == "STEP" else glb(path / "card.glb", drawn, np.pi / 2))
    board = load_board(path)
    assert len(board.instances) == 3
    assert heights(board) == pytest.approx({f"{name}@{n}": mm for name, mm in DRAWN.items() for n in (1, 2, 3)})
    for name, (x, y, side) in middles(alone).items():
        assert middles(board)[name] == (pytest.approx(x, abs=0.05), pytest.approx(y, abs=0.05), side)
    middles_of = (each.outline.centroid for each in board.top_obstacles if each.name.startswith("HS1"))
    sinks = sorted((round(each.x, 1), round(each.y, 1)) for each in middles_of)
    assert sinks == [(33.0, 19.0), (75.0, 19.0), (93.0, 5.0)]
    notes = {each.rule.id: each.message for each in board.findings}
    assert "is a model of one board of the panel p.emn: 3 of 3 boards have its bodies" in notes["model-found"]
    assert "order-boards" not in notes
    assert {each.about for each in board.contradictions} <= {"height"}


def test_models_of_a_family_are_placed_each_on_its_own_board(tmp_path: Path) -> None:
    other = EcadBoard(
        box(0, 0, 30, 24), 1.6, tuple(replace(each, x=each.x / 2.0, y=24.0 - each.y) for each in PARTS[:3])
    )
    cards = [(CARD, (0.0, 0.0, 0.0), "{}"), (other, (42.0, 0.0, 0.0), "{}")]
    path = write_idf(tmp_path / "order", panel_of(cards))
    step(path / "a.step", boxes())
    step(path / "b.step", boxes(other.parts, dict.fromkeys(DRAWN, 3.0), size=(30.0, 24.0)))
    found = heights(load_board(path))
    assert found == pytest.approx(
        {**{f"{name}@1": mm for name, mm in DRAWN.items()}, "U1@2": 3.0, "R1@2": 3.0, "J1@2": 3.0}
    )
    (path / "b.step").unlink()
    board = load_board(path)
    assert heights(board)["J1@2"] == pytest.approx(5.0)
    assert "1 of 2 boards have its bodies" in {e.rule.id: e.message for e in board.findings}["model-found"]


def test_a_model_of_no_board_of_the_panel_is_one_error(tmp_path: Path) -> None:
    path = write_idf(tmp_path / "order", panel_of([(CARD, at, "{}") for at in COPIES]))
    step(path / "x.step", boxes([replace(each, name=f"X{n}", y=24.0 - each.y) for n, each in enumerate(PARTS)],
                                {f"X{n}": 3.0 for n in range(5)}, size=(70.0, 30.0)))  # fmt: skip
    assert "order-boards" in rules(load_board(path))
