"""Several boards in one file of any format: each is an instance; gaps and rails are none."""

import math
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from command import washboard
from ecad_writers import EcadBoard, EcadPart, ipc2581, odb, write_folder
from orders import rules
from shapely import LinearRing, Polygon, affinity, box
from shapely.geometry.base import BaseGeometry
from step_writer import StepWriter

from boards.board import Board
from boards.load import load_board
from reports.cards.workpiece import board_facts

Place = tuple[float, float, float]
"""Where a copy lies: x, y of its front left corner before it is turned about it, and the turn in degrees."""
CARD = box(0, 0, 30, 20)
CHIPS = {"R1": (6.0, 5.0, 0.0), "R2": (6.0, 14.0, 90.0), "C1": (22.0, 9.0, 0.0)}
GRID: list[Place] = [(0, 0, 0), (32, 0, 0), (0, 22, 0), (32, 22, 0)]
TURNED: list[Place] = [(0, 0, 0), (62, 20, 180), (94, 0, 90)]


def moved(point: tuple[float, float], place: Place) -> tuple[float, float]:
    x, y, turn = place
    cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    return x + cos * point[0] - sin * point[1], y + sin * point[0] + cos * point[1]


def cards(places: Sequence[Place]) -> list[Polygon]:
    return [affinity.translate(affinity.rotate(CARD, turn, origin=(0, 0)), x, y) for x, y, turn in places]


def rings_of(outline: BaseGeometry) -> list[LinearRing]:
    assert isinstance(outline, Polygon)
    return [outline.exterior, *outline.interiors]


def chips(places: Sequence[Place], names: str) -> Iterator[tuple[str, float, float, float]]:
    """Name, place and turn of each chip of each copy; ``{n}`` counts copies, ``{m}`` all chips."""
    m = 0
    for n, place in enumerate(places, start=1):
        for name, (x, y, turn) in CHIPS.items():
            m += 1
            yield names.format(name=name, letter=name[0], n=n, m=m), *moved((x, y), place), turn + place[2]


def kicad(file: Path, outlines: Sequence[BaseGeometry], parts: Sequence[tuple[str, float, float, float]],
          scores: Sequence[tuple[float, float, float, float]] = (), layer: str = "Cmts.User") -> Path:  # fmt: skip
    text = ["(kicad_pcb (version 20221018) (generator pcbnew) (general (thickness 1.6))"]
    rings = [ring for each in outlines for ring in rings_of(each)]
    for ring in rings:
        for (x, y), (u, v) in pairwise(ring.coords):
            text.append(f'(gr_line (start {x} {-y}) (end {u} {-v}) (layer "Edge.Cuts"))')
    text += [f'(gr_line (start {x} {-y}) (end {u} {-v}) (layer "{layer}"))' for x, y, u, v in scores]
    for name, x, y, turn in parts:
        text += [
            f'(footprint "Resistor_SMD:R_0603_1608Metric" (layer "F.Cu") (at {x} {-y} {turn})',
            f'(property "Reference" "{name}")',
            f'(pad "1" smd rect (at -0.8 0 {turn}) (size 0.9 0.95) (layers "F.Cu"))',
            f'(pad "2" smd rect (at 0.8 0 {turn}) (size 0.9 0.95) (layers "F.Cu")))',
        ]
    file.write_text("\n".join([*text, ")"]), "utf-8")
    return file


def eagle(file: Path, outlines: Sequence[BaseGeometry], parts: Sequence[tuple[str, float, float, float]],
          scores: Sequence[tuple[float, float, float, float]] = (), layer: str = "46") -> Path:  # fmt: skip
    lines = [(*a, *b, "20") for each in outlines for ring in rings_of(each)
             for a, b in pairwise(ring.coords)]  # fmt: skip
    lines += [(*each, layer) for each in scores]
    wires = "".join(f'<wire x1="{x}" y1="{y}" x2="{u}" y2="{v}" width="0" layer="{n}"/>' for x, y, u, v, n in lines)
    pads = "".join(f'<smd name="{n}" x="{x}" y="0" dx="0.9" dy="0.95" layer="1"/>' for n, x in ((1, -0.8), (2, 0.8)))
    elements = "".join(
        f'<element name="{name}" library="l" package="R0603" value="1k" x="{x}" y="{y}" rot="R{turn % 360}"/>'
        for name, x, y, turn in parts
    )
    file.write_text(
        f'<?xml version="1.0"?><eagle version="9.6.2"><drawing><board><plain>{wires}</plain><libraries>'
        f'<library name="l"><packages><package name="R0603">{pads}</package></packages></library></libraries>'
        f"<elements>{elements}</elements></board></drawing></eagle>"
    )
    return file


def idf(file: Path, outlines: Sequence[BaseGeometry], parts: Sequence[tuple[str, float, float, float]]) -> Path:
    rings = [line for n, each in enumerate(outlines) for line in
             (f"{n} {x} {y} 0" for x, y in rings_of(each)[0].coords)]  # fmt: skip
    head = '.HEADER\n{} 3.0 "own" 2026/01/01 1\n'
    places = "".join(f'"R0603" "PN" {name}\n{x} {y} 0 {turn} TOP PLACED\n' for name, x, y, turn in parts)
    file.write_text(
        head.format("BOARD_FILE") + "card MM\n.END_HEADER\n.BOARD_OUTLINE ECAD\n1.6\n" + "\n".join(rings)
        + f"\n.END_BOARD_OUTLINE\n.PLACEMENT\n{places}.END_PLACEMENT\n"
    )  # fmt: skip
    file.with_suffix(".emp").write_text(
        head.format("LIBRARY_FILE") + '.END_HEADER\n.ELECTRICAL\n"R0603" "PN" MM 0.5\n'
        "0 -0.8 -0.4 0\n0 0.8 -0.4 0\n0 0.8 0.4 0\n0 -0.8 0.4 0\n0 -0.8 -0.4 0\n.END_ELECTRICAL\n"
    )
    return file


WRITERS = {".kicad_pcb": kicad, ".brd": eagle, ".emn": idf}


def check_copies(board: Board, places: Sequence[Place]) -> None:
    """Each copy carries the chips of the single board, where they lie on it."""
    found = {each.name: each.outline.centroid for each in board.components}
    assert len(board.instances) == len(places)
    assert len({id(each.board) for each in board.instances}) == 1
    assert sorted(each.name for each in board.instances[0].board.components) == sorted(CHIPS)
    spots = {(each.name, name): (found[f"{name}@{each.name}"].x, found[f"{name}@{each.name}"].y)
             for each in board.instances for name in CHIPS}  # fmt: skip
    assert len(found) == len(spots)
    for place in places:
        right = {name: moved((x, y), place) for name, (x, y, _) in CHIPS.items()}
        near = [
            n for n in {n for n, _ in spots} if all(math.dist(spots[n, name], right[name]) < 0.05 for name in right)
        ]
        assert len(set(near)) == 1


@pytest.mark.parametrize("names", ["{name}", "{name}_{n}", "Board_{n}-{name}", "{letter}{m}"])
@pytest.mark.parametrize("places", [GRID, TURNED], ids=["grid", "turned"])
@pytest.mark.parametrize("suffix", WRITERS)
def test_outlines_apart_are_copies_of_one_board(suffix: str, places: list[Place], names: str, tmp_path: Path) -> None:
    """Whether a tool repeats designators, numbers the copies, or counts on, as Eagle's paste does."""
    board = load_board(WRITERS[suffix](tmp_path / f"p{suffix}", cards(places), list(chips(places, names))))
    if names == "{letter}{m}":
        assert len(board.instances) == len(places)
        (text,) = (each.message for each in board.findings if each.rule.id == "panel-found")
        assert "Copies are called as the first: C6 is C3@2" in text
    else:
        check_copies(board, places)
    assert "panel-found" in rules(board)
    assert not {"repeated-name", "board-in-pieces"} & rules(board)
    assert board.outline.area == pytest.approx(600.0 * len(places), abs=3.0)


SCORED: list[Place] = [(5, 0, 0), (35, 0, 0), (5, 20, 0), (35, 20, 0)]
SCORES = [(5, -2, 5, 42), (35, -2, 35, 42), (65, -2, 65, 42), (-2, 20, 72, 20)]


@pytest.mark.parametrize(("suffix", "layer"), [(".kicad_pcb", "Cmts.User"), (".kicad_pcb", "Edge.Cuts"), (".brd", "46"),
                                               (".brd", "20")])  # fmt: skip
def test_scores_separate_copies_from_each_other_and_from_rails(suffix: str, layer: str, tmp_path: Path) -> None:
    """A connector on the rail is an obstacle, not a board."""
    parts = [*chips(SCORED, "{name}_{n}"), ("J9", 2.5, 10.0, 90.0)]
    scores = [(max(x, 0), max(y, 0), min(u, 70), min(v, 40)) for x, y, u, v in SCORES] if layer == "20" else SCORES
    board = load_board(WRITERS[suffix](tmp_path / f"p{suffix}", [box(0, 0, 70, 40)], parts, scores, layer))
    check_copies(board, SCORED)
    assert [body.name for body in board.bodies if body.role == "fixture"] == ["J9"]
    assert any(each.name == "J9" for each in board.top_obstacles)
    assert all(each.board.outline.area == pytest.approx(600.0, abs=1.0) for each in board.instances)


@pytest.mark.parametrize("names", ["{name}", "{name}_{n}"])
@pytest.mark.parametrize("layer", ["V_CUT", "SCORE", "DOCUMENT", "BOARD_OUTLINE", "ROUT rout", "DOCUMENT v-cut",
                                   "DOCUMENT scoring"])  # fmt: skip
def test_scores_of_a_job_of_one_step(layer: str, names: str, tmp_path: Path) -> None:
    """The functions of IPC-2581's layers; types and names of those of ODB++."""
    parts = tuple(EcadPart(name, x, y, 1.6, 0.8, 0.5, turn, "top", "R_0603") for name, x, y, turn in
                  [*chips(SCORED, names), ("J9", 2.5, 10.0, 90.0)])  # fmt: skip
    card = EcadBoard(box(0, 0, 70, 40), 1.6, parts, scores=tuple(SCORES), scoring=layer)
    file = tmp_path / "p.xml"
    if " " in layer:
        write_folder(odb(card, "INCH"), file := tmp_path / "p")
    else:
        file.write_text(ipc2581(card, units="INCH", copper=True))
    board = load_board(file)
    check_copies(board, SCORED)
    assert [body.name for body in board.bodies if body.role == "fixture"] == ["J9"]


def test_lines_of_copper_and_print_score_nothing(tmp_path: Path) -> None:
    parts = tuple(EcadPart(name, x, y, 1.6, 0.8, 0.5, turn, "top", "R_0603") for name, x, y, turn in
                  chips(SCORED, "{name}_{n}"))  # fmt: skip
    card = EcadBoard(box(0, 0, 70, 40), 1.6, parts, scores=tuple(SCORES), scoring="SILKSCREEN")
    (tmp_path / "p.xml").write_text(ipc2581(card, copper=True))
    assert not load_board(tmp_path / "p.xml").instances


def framed(places: Sequence[Place], *, tab_mm: float = 4.0, held: Sequence[Polygon] = ()) -> BaseGeometry:
    """A frame with cards on two tabs each, behind slots of two millimetres."""
    whole: BaseGeometry = box(-10, -10, 72, 52)
    for card in held or cards(places):
        x0, y0, x1, y1 = card.bounds
        slot = box(x0 - 2, y0 - 2, x1 + 2, y1 + 2).difference(card)
        middle = (x0 + x1) / 2
        whole = whole.difference(slot.difference(box(middle - tab_mm / 2, y0 - 3, middle + tab_mm / 2, y1 + 3)))
    return whole


@pytest.mark.parametrize("names", ["{name}", "Board_{n}-{name}", "{letter}{m}"])
@pytest.mark.parametrize("suffix", [".kicad_pcb", ".brd"])
def test_tabs_hold_copies_in_a_frame(suffix: str, names: str, tmp_path: Path) -> None:
    places = [(0.0, 0.0, 0.0), (34.0, 0.0, 0.0), (0.0, 24.0, 0.0), (34.0, 24.0, 0.0)]
    board = load_board(WRITERS[suffix](tmp_path / f"p{suffix}", [framed(places)], list(chips(places, names))))
    assert len(board.instances) == 4
    assert all(each.board.outline.area == pytest.approx(600.0, abs=2.0) for each in board.instances)
    assert board.outline.area > 3000.0  # frame and tabs are material


FAMILY = [box(0, 0, 30, 20), box(34, 0, 58, 20)]
KIN = [*chips(GRID[:1], "{name}"), ("R1", 38.0, 5.0, 0.0), ("R2", 50.0, 14.0, 90.0), ("L1", 44.0, 9.0, 0.0),
       ("L2", 53.0, 4.0, 0.0)]  # fmt: skip
"""Parts of two different boards that repeat two designators."""


def bitten(whole: BaseGeometry) -> BaseGeometry:
    """Mouse bites along the tabs, as tools draw them into the edge."""
    bites = [shapely.Point((card.bounds[0] + card.bounds[2]) / 2 + away, y).buffer(0.3, 8) for card in FAMILY
             for y in (card.bounds[1] - 0.4, card.bounds[3] + 0.4) for away in np.arange(-1.5, 1.6, 1.0)]  # fmt: skip
    return whole.difference(shapely.union_all(bites))


def check_family(board: Board) -> None:
    assert [sorted(own.own_names) for own in (each.board for each in board.instances)] == [
        ["C1", "R1", "R2"], ["L1", "L2", "R1", "R2"],
    ]  # fmt: skip
    assert [each.name for each in board.instances] == ["1", "2"]
    assert [each.board.outline.area for each in board.instances] == pytest.approx([600.0, 480.0], abs=2.0)
    assert {"R1@1", "R1@2", "L1@2", "C1@1"} <= {each.name for each in board.components}


@pytest.mark.parametrize("kind", ["tabs", "mouse bites", "scores"])
@pytest.mark.parametrize("suffix", [".kicad_pcb", ".brd"])
def test_different_boards_that_repeat_designators_are_a_family(suffix: str, kind: str, tmp_path: Path) -> None:
    file = tmp_path / f"p{suffix}"
    if kind == "scores":
        whole = box(0, 0, 58, 20)
        WRITERS[suffix](file, [whole], KIN, [(30, -1, 30, 21), (34, -1, 34, 21)])  # pyright: ignore[reportCallIssue]
    else:
        whole = framed([], held=FAMILY)
        WRITERS[suffix](file, [bitten(whole) if kind == "mouse bites" else whole], KIN)
    board = load_board(file)
    check_family(board)
    assert "panel-boards" not in rules(board)
    shown = washboard("board", "show", file).out
    assert "2 of 2 kinds: 1 (30.00 x 20.00 mm, 3 components); 2 (24.00 x 20.00 mm, 4 components)" in " ".join(
        shown.split()
    )
    assert washboard("plan", file, "-o", tmp_path / "p.wash").code == 0


def test_two_of_each_kind_in_one_frame(tmp_path: Path) -> None:
    held = [*FAMILY, *(affinity.translate(each, 0, 24) for each in FAMILY)]
    parts = [*KIN, *((name, x, y + 24.0, turn) for name, x, y, turn in KIN)]
    board = load_board(kicad(tmp_path / "p.kicad_pcb", [framed([], held=held)], parts))
    assert [len(each.board.components) for each in board.instances] == [3, 4, 3, 4]
    assert len({id(each.board) for each in board.instances}) == 2
    facts = dict(board_facts(board))
    assert (
        facts["boards"] == "4 of 2 kinds: 1, 3 (30.00 x 20.00 mm, 3 components); 2, 4 (24.00 x 20.00 mm, 4 components)"
    )


def test_the_number_of_boards_is_shown(tmp_path: Path) -> None:
    board = load_board(kicad(tmp_path / "p.kicad_pcb", cards(GRID), list(chips(GRID, "{name}"))))
    assert dict(board_facts(board))["boards"] == "4 of one kind"
    assert "boards" not in dict(board_facts(board.instances[0].board))


def test_of_sixty_copies_the_board_is_understood_once(tmp_path: Path) -> None:
    places: list[Place] = [(32.0 * (n % 10), 22.0 * (n // 10), 0.0) for n in range(60)]
    board = load_board(eagle(tmp_path / "p.brd", cards(places), list(chips(places, "{letter}{m}"))))
    assert len(board.instances) == 60
    assert len({id(each.board) for each in board.instances}) == 1
    assert len(board.components) == 180


def test_two_different_boards_are_two_instances_with_verdicts_of_their_own(tmp_path: Path) -> None:
    parts = [*chips(GRID[:1], "{name}"), ("R9", 50.0, 10.0, 0.0)]
    file = kicad(tmp_path / "p.kicad_pcb", [CARD, box(40, 0, 60, 20)], parts)
    board = load_board(file)
    assert [sorted(each.name for each in own.board.components) for own in board.instances] == [
        ["C1", "R1", "R2"],
        ["R9"],
    ]
    planned = washboard("plan", file, "-o", tmp_path / "p.wash")
    assert planned.code == 0, planned.err
    (tmp_path / "columns.yaml").write_text("panel: whole\n")
    assert not load_board(file).instances


def test_a_copy_that_is_turned_over_shows_its_other_side(tmp_path: Path) -> None:
    """Every second board of a panel lies on its face, so that one programme serves both sides."""
    parts = list(chips([GRID[0]], "{name}"))
    over = [(f"{name}_2", 62.0 - x, y, 180.0 - turn) for name, x, y, turn in parts]
    file = kicad(tmp_path / "p.kicad_pcb", cards(GRID[:2]), [*parts, *over])
    text = file.read_text()
    at = text.index('(footprint "Resistor_SMD:R_0603_1608Metric" (layer "F.Cu") (at 56.0')
    file.write_text(text[:at] + text[at:].replace("F.Cu", "B.Cu"))
    board = load_board(file)
    assert {each.name: each.side for each in board.components} == {
        **{f"{name}@1": "top" for name in CHIPS}, **{f"{name}@2": "bottom" for name in CHIPS},
    }  # fmt: skip
    assert {len(each.board.components) for each in board.instances} == {3}


def test_where_only_designators_repeat_one_error_has_both_readings(tmp_path: Path) -> None:
    """No tool's drawing separates the copies: stated, they are taken apart half way between them, or kept."""
    file = kicad(tmp_path / "p.kicad_pcb", [box(0, 0, 70, 40)], list(chips(SCORED, "{name}")))
    board = load_board(file)
    (found,) = (each for each in board.findings if each.rule.id == "panel-boards")
    assert found.severity == "error"
    assert re.search(r"one board or a panel of 4 .*`panel: apart`.*or `panel: whole`", found.message)
    assert washboard("plan", file, "-o", tmp_path / "p.wash").code == 2
    (tmp_path / "columns.yaml").write_text("panel: apart\n")
    check_copies(load_board(file), SCORED)
    (tmp_path / "columns.yaml").write_text("panel: whole\n")
    whole = load_board(file)
    assert not whole.instances
    assert "panel-boards" not in rules(whole)


def test_scores_between_different_boards_are_one_error_with_both_readings(tmp_path: Path) -> None:
    parts = [("R1", 5.0, 5.0, 0.0), ("C7", 10.0, 15.0, 90.0), ("R5", 40.0, 10.0, 0.0), ("L2", 50.0, 4.0, 0.0)]
    file = kicad(tmp_path / "p.kicad_pcb", [box(0, 0, 60, 20)], parts, [(25, -1, 25, 21)])
    (found,) = (each for each in load_board(file).findings if each.rule.id == "panel-boards")
    assert found.severity == "error"
    (tmp_path / "columns.yaml").write_text("panel: apart\n")
    assert [len(each.board.components) for each in load_board(file).instances] == [2, 2]


@pytest.mark.parametrize("shape", ["channels", "neck", "slot", "lines within"])
def test_a_board_is_no_panel_because_of_its_shape_or_channels(shape: str, tmp_path: Path) -> None:
    """Equal channels, a narrow neck, an isolation slot, boxes in a comment layer."""
    outline: BaseGeometry = box(0, 0, 70, 40)
    scores = list[tuple[float, float, float, float]]()
    parts = [("R1", 10.0, 10.0, 0.0), ("C7", 12.0, 30.0, 90.0), ("R5", 60.0, 12.0, 0.0), ("L2", 55.0, 33.0, 0.0)]
    if shape == "channels":
        parts = list(chips(SCORED, "{name}_{n}"))
    elif shape == "neck":
        outline = outline.difference(box(33, -1, 37, 38))
    elif shape == "slot":
        outline = outline.difference(box(34, 5, 36, 35))
    else:
        scores = [(2, 2, 30, 2), (30, 2, 30, 38), (30, 38, 2, 38), (2, 38, 2, 2)]
    board = load_board(kicad(tmp_path / "p.kicad_pcb", [outline], parts, scores))
    assert not board.instances
    assert not {each.rule.id for each in board.findings if each.severity == "error"}
    assert "panel-found" not in rules(board)


def test_boards_on_a_carrier_are_instances_and_its_accessories_obstacles(tmp_path: Path) -> None:
    """As assemblies for fixtures come: a plate, boards on posts, a connector on the plate."""
    placed = [
        ("PCB", "PCB", (120.0, 60.0, 2.0), (60.0, 30.0, -2.0)),
        ("J1", "HEADER", (5.0, 5.0, 9.0), (8.0, 8.0, 0.0)),
    ]
    for n, x in enumerate((30.0, 60.0, 90.0)):
        placed += [
            (f"board {n}", f"board {n}", (25.0, 30.0, 1.0), (x, 30.0, 4.0)),
            (f"spacer {n}", f"spacer {n}", (2.0, 2.0, 4.0), (x, 30.0, 0.0)),
            (f"R{n}1", "R0603", (1.6, 0.8, 0.5), (x - 6.0, 25.0, 5.0)),
            (f"U{n}2", "SOIC8", (5.0, 4.0, 1.7), (x + 4.0, 33.0, 5.0)),
        ]
    (tmp_path / "plate.step").write_text(StepWriter().write(placed, {}), "utf-8")
    board = load_board(tmp_path / "plate.step")
    assert len(board.instances) == 3
    assert {each.name for each in board.components} == {f"{name}@{n}" for name in ("R01", "U02") for n in (1, 2, 3)}
    assert len([body for body in board.bodies if body.role == "fixture"]) == 5
    assert (board.bottom_z_mm, board.top_z_mm) == pytest.approx((4.0, 5.0))


def gerbers(folder: Path, *, named: bool, scored: bool) -> Path:
    """Layers of a panel: copies in one outline each, or scored; with attributes, or bare."""
    outlines = [box(0, 0, 70, 40)] if scored else cards(SCORED_APART)
    pen = "%FSLAX46Y46*%\n%MOMM*%\n%ADD10C,0.1*%\n%ADD11R,0.9X0.95*%\n%ADD12R,0.95X0.9*%\nG01*\n"

    def at(x: float, y: float, code: str) -> str:
        return f"X{round(x * 1e6)}Y{round(y * 1e6)}{code}*\n"

    def drawn(lines: Sequence[Sequence[tuple[float, float]]]) -> str:
        pieces = ("".join(at(x, y, "D01" if n else "D02") for n, (x, y) in enumerate(line)) for line in lines)
        return f"{pen}D10*\n{''.join(pieces)}M02*\n"

    copper = [pen]
    for name, x, y, turn in chips(SCORED if scored else SCORED_APART, "{name}"):
        copper.append("D11*\n" if turn % 180 == 0 else "D12*\n")
        for pin, along in ((1, -0.8), (2, 0.8)):
            copper += [f"%TO.P,{name},{pin}*%\n"] * named
            dx, dy = moved((along, 0.0), (0.0, 0.0, turn))
            copper.append(at(x + dx, y + dy, "D03"))
    files = {
        "p.gko": drawn([rings_of(each)[0].coords for each in outlines]),
        "p.gtl": "".join(copper) + "M02*\n",
        "p-vcut.gbr": "%TF.FileFunction,Vcut*%\n" + drawn([[(x, y), (u, v)] for x, y, u, v in SCORES]),
    }
    folder.mkdir()
    for name, text in files.items():
        if scored or "vcut" not in name:
            (folder / name).write_text(text)
    return folder


SCORED_APART: list[Place] = [(0, 0, 0), (40, 0, 0), (0, 30, 0), (40, 30, 0)]
BILL = 'Designator,Comment,MPN,Height (mm)\n"R1,R2",10k,RC0603,0.6\nC1,100n,CC0603,0.9\n'


@pytest.mark.parametrize("scored", [False, True])
@pytest.mark.parametrize("named", [False, True])
def test_layers_of_a_panel_with_a_table_of_every_copy_and_a_bill_of_one(
    named: bool, scored: bool, tmp_path: Path
) -> None:
    folder = gerbers(tmp_path / "g", named=named, scored=scored)
    rows = [f"{name},R_0603,{x},{y},{turn},top" for name, x, y, turn in
            chips(SCORED if scored else SCORED_APART, "{name}")]  # fmt: skip
    (folder / "cpl.csv").write_text("\n".join(["RefDes,Package,X(mm),Y(mm),Rotation,Layer", *rows]) + "\n")
    (folder / "bom.csv").write_text(BILL)
    board = load_board(folder)
    check_copies(board, SCORED if scored else SCORED_APART)
    assert {each.name: (each.part, each.height_mm) for each in board.instances[0].board.components} == {
        "R1": ("RC0603", 0.6), "R2": ("RC0603", 0.6), "C1": ("CC0603", 0.9),
    }  # fmt: skip
    assert not {"parts-not-on-board", "parts-not-in-table", "parts-contradict", "repeated-name"} & rules(board)


@pytest.mark.parametrize("names", ["{name}", "{name}_{n}", "Board_{n}-{name}"])
@pytest.mark.parametrize("suffix", WRITERS)
def test_a_bill_of_one_board_holds_for_every_copy(suffix: str, names: str, tmp_path: Path) -> None:
    file = WRITERS[suffix](tmp_path / f"p{suffix}", cards(GRID), list(chips(GRID, names)))
    (tmp_path / "bom.csv").write_text(BILL.replace(",Height (mm)", "").replace(",0.6", "").replace(",0.9", ""))
    board = load_board(file, tmp_path / "bom.csv")
    check_copies(board, GRID)
    assert {each.part for each in board.components} == {"RC0603", "CC0603"}
    assert not {"parts-not-on-board", "parts-not-in-table"} & rules(board)


@pytest.mark.parametrize(
    "function", ["", "Vcut,Top/Bot", "Other,Comment", "OtherDrawing,Comment", "Other,Score,Top/Bot"]
)
def test_scores_on_layers_of_gerber(function: str, tmp_path: Path) -> None:
    folder = gerbers(tmp_path / "g", named=True, scored=True)
    scores = (folder / "p-vcut.gbr").read_text().replace("%TF.FileFunction,Vcut*%\n", "")
    (folder / "p-vcut.gbr").unlink()
    name = "p-User_Comments.gbr" if function else "p.v-score"
    (folder / name).write_text(f"%TF.FileFunction,{function}*%\n{scores}" if function else scores)
    check_copies(load_board(folder), SCORED)
    (folder / name).write_text(f"%TF.FileFunction,Other,Comment*%\n{scores[:200]}%AMbroken*%")
    assert load_board(folder).components  # drawings that cannot be read refuse no board


def test_pads_that_share_a_pin_are_no_copies(tmp_path: Path) -> None:
    """The two legs of each contact of a push button have one number."""
    folder = gerbers(tmp_path / "g", named=True, scored=True)
    text = (folder / "p.gtl").read_text()
    one = text[: text.index("%TO.P,R1,1", text.index("%TO.P,C1,2"))]
    legs = "".join(f"%TO.P,S1,{pin}*%\nX{x}000000Y{y}000000D03*\n" for pin, y in ((1, 10), (2, 16)) for x in (12, 18))
    (folder / "p.gtl").write_text(f"{one}{legs}M02*\n")
    assert sorted(each.name for each in load_board(folder).components) == ["C1", "R1", "R2", "S1"]
