"""Bare copper and netlists: whose pads they are, and the turns that tables state compared with how the pads lie."""

import math
import re
from pathlib import Path
from shutil import make_archive

import numpy as np
import pytest
from orders import HEAD, centroid, gerbers, middles, rules, table
from orders import RIGHT as FIVE

from boards.board import Board
from boards.errors import BoardError
from boards.load import load_board

PATTERNS = {
    "SOT-23": [(-1.0, -0.95), (-1.0, 0.95), (1.0, 0.0)],
    "D_SOD-123": [(-1.65, 0.0), (1.65, 0.0)],
    "R_2512": [(-2.9, 0.0), (2.9, 0.0)],
    "LQFP-4": [(-2.0, 1.0), (-2.0, -1.0), (2.0, -1.0), (2.0, 0.4)],
}
Part = tuple[str, float, float, float, str]
"""Package, place, turn as seen from the top, side."""


def spots(part: Part) -> list[tuple[float, float]]:
    package, x, y, turn, side = part
    cos, sin, flip = math.cos(math.radians(turn)), math.sin(math.radians(turn)), -1 if side == "bottom" else 1
    return [(x + cos * flip * dx - sin * dy, y + sin * flip * dx + cos * dy) for dx, dy in PATTERNS[package]]


def write_board(folder: Path, parts: dict[str, Part], *, pins: bool = False) -> Path:
    """Layers with square pads, so that they state no turn themselves; attributes with ``pins``."""
    ring = "X0Y0D02*X90000000Y0D01*X90000000Y60000000D01*X0Y60000000D01*X0Y0D01*\n"
    (folder / "card").mkdir()
    head = HEAD.replace("R,0.9X0.95", "R,0.6X0.6")
    (folder / "card" / "b.gko").write_text(f"{head}D10*\nG01*\n{ring}M02*\n")
    for name, side in (("b.gtl", "top"), ("b.gbl", "bottom")):
        lines = [head, "D11*"]
        for ref, part in parts.items():
            for pin, (x, y) in enumerate(spots(part) if part[4] == side else [], start=1):
                lines += [f"%TO.P,{ref},{pin}*%"] * pins + [f"X{round(x * 1e6)}Y{round(y * 1e6)}D03*"]
        (folder / "card" / name).write_text("\n".join([*lines, "M02*\n"]))
    return folder / "card"


def write_table(folder: Path, parts: dict[str, Part], stated: dict[str, float]) -> None:
    rows = (f"{ref},{part[0]},{part[1]},{part[2]},{stated.get(ref, part[3])},{part[4]}" for ref, part in parts.items())
    table(folder, "cpl.csv", "\n".join(["RefDes,Package,X(mm),Y(mm),Rotation,Layer", *rows]) + "\n")


def turns(board: Board) -> dict[str, tuple[str, str]]:
    return {each.component: (each.taken, each.other) for each in board.contradictions if each.about == "turn"}


def counted(board: Board) -> str:
    return " ".join(each.message for each in board.findings if each.rule.id == "parts-turn")


def row_of(package: str, turns: list[float], side: str = "top", first: int = 1) -> dict[str, Part]:
    """Parts of one package side by side."""
    letter, y = {"SOT-23": ("Q", 10), "R_2512": ("R", 25), "D_SOD-123": ("D", 40), "LQFP-4": ("X", 50)}[package]
    return {f"{letter}{n}": (package, 10.0 * n, y, turn, side) for n, turn in enumerate(turns, start=first)}


@pytest.mark.parametrize("pins", [False, True])
@pytest.mark.parametrize("package", ["SOT-23", "LQFP-4"])
@pytest.mark.parametrize("side", ["top", "bottom"])
def test_a_part_that_lies_otherwise_than_those_of_its_package_is_turned(
    tmp_path: Path, package: str, side: str, pins: bool
) -> None:
    parts = row_of(package, [0, 90, 180, 30, 90, 90], side)
    folder = write_board(tmp_path, parts, pins=pins)
    wrong = next(name for name in parts if name.endswith("2"))
    write_table(folder, parts, {wrong: 270.0})
    board = load_board(folder)
    assert turns(board) == {wrong: ("90 degrees", "270 degrees")}
    write_table(folder, parts, {})
    right = load_board(folder)
    assert turns(right) == {}
    assert counted(right) == ""


@pytest.mark.parametrize("quarter", [0, 90])
def test_the_quarter_that_a_library_counts_from_is_settled_by_the_pads(tmp_path: Path, quarter: float) -> None:
    parts = row_of("R_2512", [0, 90, 180])
    folder = write_board(tmp_path, parts)
    write_table(folder, parts, {name: part[3] + quarter for name, part in parts.items()})
    board = load_board(folder)
    boxes = {each.name: each.footprint.bounds for each in board.components}
    sizes = {name: (round(x1 - x0, 1), round(y1 - y0, 1)) for name, (x0, y0, x1, y1) in boxes.items()}
    assert sizes["R1"] == sizes["R3"] == sizes["R2"][::-1]
    assert sizes["R1"][0] > sizes["R1"][1]
    assert turns(board) == {}
    assert ("those of R_2512 from 90 degrees" in counted(board)) == bool(quarter)


def test_turns_of_the_bottom_from_below_are_understood(tmp_path: Path) -> None:
    parts = row_of("SOT-23", [0, 90, 30, 90], "bottom")
    folder = write_board(tmp_path, parts)
    write_table(folder, parts, {name: (-part[3]) % 360 for name, part in parts.items()})
    board = load_board(folder)
    assert turns(board) == {}
    assert "those of the bottom as seen from below" in counted(board)


def test_half_turns_of_symmetric_pads_are_undecided_without_pin_names(tmp_path: Path) -> None:
    parts = {**row_of("D_SOD-123", [0, 180, 90]), **row_of("SOT-23", [0, 90])}
    folder = write_board(tmp_path, parts)
    write_table(folder, parts, {"D2": 0.0})
    board = load_board(folder)
    assert turns(board) == {}
    assert "for 2 of 5 components, and undecided for D1, D2, D3" in counted(board)
    table(folder, "b.ipc", netlist(parts))
    named = load_board(folder)
    assert turns(named) == {"D2": ("180 degrees", "0 degrees")}
    assert "undecided" not in counted(named)


def netlist(parts: dict[str, Part], *, dialect: str = "kicad", shift: tuple[float, float] = (0.0, 0.0)) -> str:
    """As KiCad writes it, in ten thousandths of an inch, or in micrometres with other heads and records between."""
    metric = dialect == "metric"
    lines = ["C  IPC-D-356 of a CAM system\r", "P  JOB card\r", "P  UNITS SI\r", "P  TITLE a\r"] if metric else [
        "P  CODE 00", "P  UNITS CUST 0", "P  arrayDim   N"]  # fmt: skip
    for ref, part in parts.items():
        for pin, (x, y) in enumerate(spots(part), start=1):
            scale = 1000.0 if metric else 10_000 / 25.4
            access = "A01" if part[4] == "top" else "A02"
            at = f"{access}X{round((x + shift[0]) * scale):+07d}Y{round((y + shift[1]) * scale):+07d}"
            lines.append(f"327{'NET' + str(pin):<14}   {ref[:6]:<6}-{pin:<4}       {at}X0236Y0236R000S{2}")
        lines.append(f"317{'GND':<14}   {'VIA':<6}-{'':4} D0118PA00X+001000Y+001000X0276Y0000R000S3")
    return "\n".join([*lines, "999", ""])


@pytest.mark.parametrize("dialect", ["kicad", "metric"])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (25.4, -12.7)])
def test_a_netlist_names_pads_and_pins_of_bare_copper(tmp_path: Path, dialect: str, shift: tuple[float, float]) -> None:
    parts = {**row_of("SOT-23", [0, 90]), **row_of("LQFP-4", [0]), **row_of("D_SOD-123", [0], "bottom", first=3)}
    folder = write_board(tmp_path, parts)
    table(folder, "b.d356", netlist(parts, dialect=dialect, shift=shift))
    board = load_board(folder)
    found = middles(board)
    assert {name: found[name][2] for name in found} == {name: part[4] for name, part in parts.items()}
    assert {each.name: each.pins for each in board.components} == {"Q1": 3, "Q2": 3, "X1": 4, "D3": 2}
    assert {each.name: each.kind for each in board.sources}["b.d356"] == "netlist"
    assert ("parts-frame" in rules(board)) == (shift != (0.0, 0.0))


def test_designators_that_a_netlist_cuts_off_are_those_of_the_table(tmp_path: Path) -> None:
    parts = {f"CONN{n}00A": part for n, part in enumerate(row_of("LQFP-4", [0, 90, 0]).values(), start=1)}
    folder = write_board(tmp_path, parts)
    write_table(folder, parts, {})
    table(folder, "b.ipc", netlist(parts))
    board = load_board(folder)
    assert set(middles(board)) == set(parts)
    assert "parts-not-in-table" not in rules(board)


def test_what_a_netlist_names_and_the_board_lacks_is_listed(tmp_path: Path) -> None:
    parts = row_of("SOT-23", [0, 90, 0])
    folder = write_board(tmp_path, parts)
    table(folder, "b.ipc", netlist({**parts, "Q9": ("SOT-23", 70.0, 50.0, 0.0, "top")}))
    (found,) = (each.message for each in load_board(folder).findings if each.rule.id == "parts-position")
    assert "3 pads that b.ipc names have no copper: Q9-1, Q9-2, Q9-3" in found
    kicad = Path(__file__).parents[2] / "fuzz" / "corpus" / "KiCad" / "v9.kicad_pcb"
    board = load_board(kicad, folder / "b.ipc")
    assert any("netlist names are not on the board: Q1, Q2, Q3, Q9" in each.message for each in board.findings)


ATTRIBUTES = {
    "KiCad X1": ("G04 #@! TO.P,{0},{1}*", "U1"),
    "Eagle 9": ("G04 #@! %TO.P,{0},{1}*%", "U1"),
    "Fusion": ("G04 #@!%TO.C,{0}*%", "U1"),
    "component alone": ("%TO.C,{0}*%", "U1"),
    "escaped star": ("%TO.P,U1\\u002A,{1}*%", "U1*"),
    "escaped letters": ("%TO.P,\\u0055\\u00311,{1},GND\\u002C*%", "U11"),
}


@pytest.mark.parametrize("tool", ATTRIBUTES)
def test_attributes_name_pads_in_the_dialects_of_tools(tmp_path: Path, tool: str) -> None:
    text, name = ATTRIBUTES[tool]
    folder = write_board(tmp_path, {"U1": ("LQFP-4", 20.0, 20.0, 0.0, "top")}, pins=True)
    layer = (folder / "b.gtl").read_text()
    (folder / "b.gtl").write_text(re.sub(r"%TO\.P,(\w+),(\d)\*%", lambda hit: text.format(*hit.groups()), layer))
    assert set(middles(load_board(folder))) == {name}


def test_a_netlist_that_leads_away_is_refused_with_its_line(tmp_path: Path) -> None:
    folder = write_board(tmp_path, row_of("SOT-23", [0]))
    table(folder, "b.ipc", netlist({"Q1": ("SOT-23", 1e5, 0.0, 0.0, "top")}, dialect="metric"))
    with pytest.raises(BoardError, match=r"b\.ipc:5: Q1 is farther than 10 m"):
        load_board(folder)


def test_a_side_that_named_copper_contradicts_is_that_of_the_copper(tmp_path: Path) -> None:
    layers = gerbers(tmp_path, named=True)
    table(layers, "cpl.csv", centroid().replace("0,bottom", "0,top"))
    board = load_board(layers)
    assert middles(board) == FIVE
    assert [(each.component, each.about, each.taken) for each in board.contradictions] == [("R2", "side", "bottom")]


def test_a_place_without_copper_is_a_contradiction_and_free_copper_has_a_place(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid().replace("R4,R_0603,33.0000,24.0000", "R4,R_0603,36.0000,4.0000"))
    board = load_board(layers)
    assert [(each.component, each.about, each.other) for each in board.contradictions] == [
        ("R4", "place", "no such pads there")
    ]
    assert any("2 of 14 pads on the top belong to no row of cpl.csv, such as that at (32.20, 24.00)" in
               each.message for each in board.findings)  # fmt: skip


LAYER_NAMES = {
    "as texts": ("top copper.txt", "bottom copper.txt", "edge.txt"),
    "by number": ("L1.pho", "L2.pho", "b.gko"),
    "in German": ("Oberseite.gbr", "Unterseite.gbr", "Kontur.gbr"),
    "of OrCAD": ("b.TOP", "b.BOT", "b.FAB"),
    "without suffixes": ("layer_a", "layer_b", "layer_c"),
}


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", LAYER_NAMES)
def test_layers_are_found_by_their_content_whatever_they_are_called(tmp_path: Path, kind: str, packed: bool) -> None:
    layers = gerbers(tmp_path)
    table(layers, "PickPlace", centroid())
    for old, new in zip(("b.gtl", "b.gbl", "b.gko"), LAYER_NAMES[kind], strict=True):
        (layers / old).rename(layers / new)
    board = load_board(Path(make_archive(str(tmp_path / "order"), "zip", layers)) if packed else layers)
    assert middles(board) == FIVE
    assert {each.name: each.height_mm for each in board.components}["U1"] == pytest.approx(1.75)
    assert not {"parts-position", "parts-titles", "order-boards", "part-without-geometry"} & rules(board)


def test_pads_that_lie_elsewhere_make_no_layer_the_copper(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid(places={"R1": (4.0, 4.0), "R3": (5.0, 22.0), "R4": (36.0, 4.0)}))
    (layers / "b.gtl").rename(layers / "marks.pho")
    board = load_board(layers)
    assert not any("is read as the copper" in each.message for each in board.findings)


PATTERNS |= {
    "PinHeader_1x06_P2.54mm": [(0.0, 2.54 * n) for n in range(6)],
    "PinHeader_2x03_P2.54mm": [(2.54 * (n % 2), 2.54 * (n // 2)) for n in range(6)],
    "FPC": [(0.5 * n, 0.0) for n in range(8)],
    "SOIC-8": [(0.3 + 5.4 * (n // 4), 0.3 + 1.27 * (n % 4)) for n in range(8)],
}
"""About their first pin, or the corner of all pads; pins that the name does not state are found by the gaps."""


@pytest.mark.parametrize("pins", [False, True])
@pytest.mark.parametrize("side", ["top", "bottom"])
@pytest.mark.parametrize("turn", [0.0, 90.0, 180.0, 45.0])
def test_connectors_that_are_placed_by_a_pin_or_a_corner_lie_on_their_pads(
    tmp_path: Path, turn: float, side: str, pins: bool
) -> None:
    kinds = ("PinHeader_1x06_P2.54mm", "PinHeader_2x03_P2.54mm", "FPC", "SOIC-8")
    parts: dict[str, Part] = {f"J{n}": (kind, 18.0 * n, 30.0, turn, side) for n, kind in enumerate(kinds, start=1)}
    parts |= row_of("R_2512", [0.0] * 6, side) | row_of("SOT-23", [0.0] * 6, side)
    parts |= {ref: (part[0], part[1], part[2] + 25.0, *part[3:]) for ref, part in parts.items() if ref[0] == "R"}
    folder = write_board(tmp_path, parts, pins=pins)
    write_table(folder, parts, {})
    board = load_board(folder)
    for ref in ("J1", "J2", "J3", "J4"):
        found, pads = next(each for each in board.components if each.name == ref), np.array(spots(parts[ref]))
        middle = (pads.min(axis=0) + pads.max(axis=0)) / 2.0
        assert (found.outline.centroid.x, found.outline.centroid.y) == pytest.approx(middle, abs=0.1), ref
        assert found.side == side
    frames = [each.message for each in board.findings if each.rule.id == "parts-frame"]
    assert any(each.startswith("4 places in cpl.csv are not the middle of their pads") for each in frames)
    assert "J1, J2, J3, J4" in " ".join(frames)
    assert not {"parts-position", "parts-not-in-table"} & rules(board)
    assert not [each for each in board.contradictions if each.about == "place"]


def test_a_place_beside_free_pads_is_no_place_of_theirs(tmp_path: Path) -> None:
    parts: dict[str, Part] = {"J1": ("PinHeader_1x06_P2.54mm", 18.0, 20.0, 0.0, "top"), **row_of("SOT-23", [0.0] * 6)}
    folder = write_board(tmp_path, parts)
    write_table(folder, {**parts, "J1": (parts["J1"][0], 21.0, 24.0, 0.0, "top")}, {})
    board = load_board(folder)
    assert [each.component for each in board.contradictions if each.about == "place"] == ["J1"]
    assert "parts-position" in rules(board)
