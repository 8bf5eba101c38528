# ruff: noqa: E501  (the rows of tables are as long as their tools write them)
"""Tables of other tools, several at once, beside bare copper: what they say is read, and what contradicts is told."""

import re
from pathlib import Path
from shutil import make_archive

import pytest
from orders import BILLS, HEAD, PLACES, RIGHT, centroid, gerbers, middles, rules, table

from boards.errors import BoardError
from boards.load import load_board
from boards.parts_table.read import read_table


@pytest.mark.parametrize("bill", BILLS)
@pytest.mark.parametrize("named", [False, True])
def test_centroid_and_bill_are_joined_in_any_order(tmp_path: Path, bill: str, named: bool) -> None:
    files = table(tmp_path, "cpl.csv", centroid()), table(tmp_path, "bom.csv", BILLS[bill])
    layers = gerbers(tmp_path, named=named)
    one, other = load_board(layers, files), load_board(layers, files[::-1])
    assert middles(one) == middles(other) == RIGHT
    assert one.sha256 == other.sha256
    if bill == "altium":
        assert {each.name: each.height_mm for each in one.components} == pytest.approx(
            {"R1": 0.5, "R2": 0.5, "R3": 0.5, "R4": 0.5, "U1": 1.7}
        )


@pytest.mark.parametrize("packed", [False, True])
def test_an_order_is_read_with_the_tables_in_it(tmp_path: Path, packed: bool) -> None:
    layers = gerbers(tmp_path)
    table(layers, "card-pick place.csv", centroid())
    table(layers, "parts list.csv", BILLS["altium"])
    table(layers, "readme.txt", "Thank you for the order.\nPlease clean R1 well.\n")
    order = Path(make_archive(str(tmp_path / "order"), "zip", layers)) if packed else layers
    board = load_board(order)
    assert middles(board) == RIGHT
    assert {each.height_mm for each in board.components} == {0.5, 1.7}
    (found,) = (each.message for each in board.findings if each.rule.id == "parts-found")
    assert "card-pick place.csv (5 rows), parts list.csv (5 rows)" in found


@pytest.mark.parametrize("bill", BILLS)
def test_a_bill_alone_removes_nothing(tmp_path: Path, bill: str) -> None:
    board = load_board(gerbers(tmp_path, named=True), table(tmp_path, "bom.csv", BILLS[bill]))
    assert middles(board) == RIGHT


def test_what_is_in_one_only_is_counted(tmp_path: Path) -> None:
    files = (
        table(tmp_path, "cpl.csv", centroid()),
        table(tmp_path, "bom {0}.csv", "Ref,Value\nR1,1k\nR2,1k\nQ7,fet\nQ8,fet\n"),
    )
    board = load_board(gerbers(tmp_path, named=True), files)
    said = {finding.rule.id: finding.message for finding in board.findings}
    assert said["parts-not-on-board"] == "2 rows of bom {0}.csv are not on the board: Q7, Q8."
    assert "3 placed components have no row in bom {0}.csv: R3, R4, U1." in said["parts-not-in-table"]


@pytest.mark.parametrize(("unit", "scale"), [("inch", 1 / 25.4), ("mil", 1 / 0.0254)])
@pytest.mark.parametrize("named", [False, True])
def test_a_unit_that_is_not_stated_is_that_of_the_copper(tmp_path: Path, unit: str, scale: float, named: bool) -> None:
    board = load_board(gerbers(tmp_path, named=named), table(tmp_path, "cpl.csv", centroid(scale=scale)))
    assert middles(board) == RIGHT
    assert any(finding.rule.id == "unit-guessed" and unit in finding.message for finding in board.findings)


def test_two_readings_that_fit_are_one_error_with_both(tmp_path: Path) -> None:
    heap = {f"R{number}": (1 + 2 * (number % 2), 1 + 2 * (number // 2)) for number in range(1, 5)}
    (tmp_path / "edge.gbr").write_text(
        HEAD + "D10*G01*X0Y0D02*X150000000Y0D01*X150000000Y120000000D01*X0Y120000000D01*X0Y0D01*M02*"
    )
    board = load_board(
        tmp_path / "edge.gbr", table(tmp_path, "cpl.csv", centroid(places=heap).replace("R_0603", "SOIC-8_3.9x4.9mm"))
    )
    (found,) = (finding for finding in board.findings if finding.rule.id == "parts-unit")
    assert found.severity == "error"
    assert re.search(r"mm \(spread over 2.0 x 4.0 mm\) and inch \(spread over 50.8 x 101.6 mm\)", found.message)


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("mistake", ["mirrored", "origin"])
def test_places_that_the_copper_contradicts_are_laid_on_it_and_told(tmp_path: Path, mistake: str, named: bool) -> None:
    moved = {name: (40 - x, y) if mistake == "mirrored" else (x + 70.0, y - 45.5) for name, (x, y) in PLACES.items()}
    moved["R2"] = PLACES["R2"]
    board = load_board(gerbers(tmp_path, named=named), table(tmp_path, "cpl.csv", centroid(places=moved)))
    assert middles(board) == RIGHT
    assert "parts-frame" in rules(board)


def test_copper_without_a_row_and_a_row_without_copper_are_told(tmp_path: Path) -> None:
    places = {**PLACES, "R9": (5.0, 5.0)}
    del places["R4"]
    said = {
        each.rule.id: each.message
        for each in load_board(gerbers(tmp_path), table(tmp_path, "c.csv", centroid(places=places))).findings
    }
    assert "2 of 14 pads on the top" in said["parts-not-in-table"]
    assert "R9" in said["parts-position"]


DIALECTS = {
    "protel.txt": (
        "Designator Footprint               Mid X         Mid Y         Ref X         Ref Y         Pad X         Pad Y "
        "TB      Rotation Comment        \n\n"
        "R1         RES 0603          393.70mil     787.40mil     393.70mil     787.40mil     425.20mil     787.40mil  T"
        "         0.00 10k 1 %\n"
        "R2         RES 0603          472.44mil     314.96mil     472.44mil     314.96mil     503.94mil     314.96mil  B"
        "       180.00 10k\n"
    ),
    "pads.txt": "RefDes     Part Type      Location X   Location Y  Orientation  Layer\n"
    "R1         RES 10k        10.00        20.00       0            Top\n"
    "R2         RES 10k        12.00        8.00        180          Bottom\n",
    "allegro.txt": "UUNITS = MILS\n$END\nR1 ! 393.70 ! 787.40 ! 0 !   ! R_0603 !\nR2 ! 472.44 ! 314.96 ! 180 ! m ! R_0603 !\n",
    "extract.txt": "A!REFDES!SYM_X!SYM_Y!SYM_ROTATE!SYM_MIRROR!\nJ!C:/b.brd!Mon!0.0!1.0!mils!b!\n"
    "S!R1!393.70!787.40!0.000!NO!\nS!R2!472.44!314.96!180.000!YES!\n",
    "proteus.csv": "LABCENTER PICK AND PLACE FILE\nUnits: Rotation - degrees, X, Y - thou\n\n"
    '"Part ID","Value","Package","Layer","Rotation","X","Y"\n"R1","10k","R_0603",TOP,0,393.70,787.40\n'
    '"R2","10k","R_0603",BOTTOM,180,472.44,314.96\n',
    "geda.xy": "# $Id$\n# X,Y in mils.  rotation in degrees.\n# --------\n"
    '# RefDes, Description, Value, X, Y, rotation, top/bottom\nR1,"R_0603","10k",393.70,787.40,0,top\n'
    'R2,"R_0603","10k",472.44,314.96,180,bottom\n',
    "excel.csv": "Ref;Wert;PosX;PosY;Rot;Side\nR1;10k;10,00;20,00;0;top\nR2;10k;12,00;8,00;180;bottom\n",
    "easyeda.csv": "Designator\tFootprint\tMid X\tMid Y\tLayer\tRotation\n"
    "R1\tR0603\t10.00mm\t20.00mm\tT\t0\nR2\tR0603\t12.00mm\t8.00mm\tB\t180\n",
    "kicad.pos": "### Footprint positions ###\n## Unit = mm, Angle = deg.\n"
    "# Ref     Val       Package                PosX       PosY       Rot  Side\n"
    "R1        10k 1 %   R_0603              10.0000    20.0000    0.0000  top\n"
    "R2        10 k      R_0603              12.0000     8.0000  180.0000  bottom\n## End\n",
}


@pytest.mark.parametrize("name", DIALECTS)
def test_the_tables_of_other_tools_say_the_same(tmp_path: Path, name: str) -> None:
    rows = read_table(table(tmp_path, name, DIALECTS[name])).rows
    places = [row.xy_mm for row in rows if row.xy_mm is not None]
    assert [row.ref for row in rows] == ["R1", "R2"]
    assert places == [pytest.approx((10, 20), abs=1e-3), pytest.approx((12, 8), abs=1e-3)]
    assert [(row.side, row.turn_deg) for row in rows] == [("top", 0.0), ("bottom", 180.0)]


def test_one_file_a_side_is_of_the_side_in_its_name(tmp_path: Path) -> None:
    files = [
        *(table(tmp_path, f"b.{end}", text) for end, text in (("mnt", "R1 10.0 20.0 0 10k R0603\n"), ("mnb", "R2 12 8 0 10k R0603\n"))),
        *(table(tmp_path, f"card-{side}.csv", f"Ref,PosX,PosY,Rot\n{ref},10,20,0\n") for side, ref in (("top", "R1"), ("bottom", "R2"))),
    ]  # fmt: skip
    assert [row.side for file in files for row in read_table(file).rows] == ["top", "bottom"] * 2
    both = load_board(gerbers(tmp_path), files[:2])
    assert {name: middles(both)[name] for name in ("R1", "R2")} == {name: RIGHT[name] for name in ("R1", "R2")}


FITTED = {
    "kicad": "Reference,Value,DNP\nR1,10k,\nR3,10k,DNP\nR4,1k,\n",
    "altium": "Designator;Comment;Fitted\nR1;10k;Fitted\nR3;10k;Not Fitted\nR4;1k;Fitted\n",
    "eda": "RefDes,Part Number,Populate\nR1,A,Yes\nR3,A,No\nR4,B,1\n",
    "value": "Ref,Value\nR1,10k\nR3,DNF\nR4,1k\n",
    "diptrace": "RefDes\tValue\tDo Not Place\nR1\t10k\t0\nR3\t10k\tX\nR4\t1k\t0\n",
}


@pytest.mark.parametrize("dialect", FITTED)
@pytest.mark.parametrize("named", [False, True])
def test_what_is_not_fitted_is_left_out_and_told(tmp_path: Path, dialect: str, named: bool) -> None:
    files = table(tmp_path, "cpl.csv", centroid()), table(tmp_path, "bom.csv", FITTED[dialect])
    board = load_board(gerbers(tmp_path, named=named), files)
    assert set(middles(board)) == {"R1", "R4", "R2", "U1"}
    assert any(each.rule.id == "parts-not-fitted" and "R3" in each.message for each in board.findings)


def test_a_cell_that_says_neither_is_refused_with_its_line(tmp_path: Path) -> None:
    with pytest.raises(BoardError, match=r"t\.csv:3: column Fitted: 'perhaps' states neither") as refused:
        read_table(table(tmp_path, "t.csv", "Ref,Value,Fitted\nR1,1k,yes\nR2,1k,perhaps\n"))
    assert refused.value.line == 3


@pytest.mark.parametrize("line", ["\n", "\r\n", "\r"])
def test_a_table_is_known_by_its_beginning_and_read_to_its_end(tmp_path: Path, line: str) -> None:
    rows = [f"R{number},R_0603,{number % 97}.5,{number % 89}.25,90,top" for number in range(9000)]
    (tmp_path / "t.csv").write_bytes(line.join(["Ref,Package,X(mm),Y(mm),Rotation,Layer", *rows]).encode())
    found = read_table(tmp_path / "t.csv").rows
    assert len(found) == 9000
    assert (found[-1].ref, found[-1].xy_mm) == ("R8999", (8999 % 97 + 0.5, 8999 % 89 + 0.25))


def rows(text: str, *, first: str = "", end: str = "") -> str:
    """A table with a row for each part: text with name, place in mm, mil and inch, side and package."""
    lines = [
        text.format(name=name, x=x, y=y, xm=x / 0.0254, ym=y / 0.0254, xi=x / 25.4, yi=y / 25.4, is_bottom=name == "R2",
                    side="Bottom" if name == "R2" else "Top", flag="M" if name == "R2" else "N",
                    letter="B" if name == "R2" else "T", package="SOIC-8" if name == "U1" else "R_0603",
                    pins=8 if name == "U1" else 2, xb=x / 0.0254 * 38100, yb=y / 0.0254 * 38100)
        for name, (x, y) in PLACES.items()
    ]  # fmt: skip
    return "\n".join([*([first] if first else []), *lines, *([end] if end else [])]) + "\n"


REMARKS = "*PART*       ITEMS\n\n*REMARK* REFNM PTYPENM X Y ORI GLUE MIRROR ALT CLSTID CLSTATTR BROTHERID LABELS\n"
LABEL = "\nVALUE           0           0   0.000  1          45           1 N   LEFT   DOWN\nRegular <Romansim Stroke Font>\nRef.Des."
OWN_TABLES = {
    "diptrace.csv": rows("{name},{package},{x},{y},{side},0,10k", first="RefDes,Name,X (mm),Y (mm),Side,Rotate,Value"),
    "diptrace inch.csv": rows("{name};{package};{xi:.5f};{yi:.5f};{side};0;10k;", first="RefDes;Pattern;X (in);Y (in);Side;Rotate;Value;"),
    "easyeda.csv": rows(
        '"{name}"\t"{package}"\t"{x}mm"\t"{y}mm"\t"{x}mm"\t"{y}mm"\t"0mm"\t"0mm"\t"{letter}"\t"0"\t"10k"',
        first="Designator\tFootprint\tMid X\tMid Y\tRef X\tRef Y\tPad X\tPad Y\tLayer\tRotation\tComment"),
    "easyeda pro.csv": rows(
        "{name},0603WAF1002,{package},{xm:.2f}mil,{ym:.2f}mil,0mil,0mil,0mil,0mil,{pins},{letter},0,Yes,10k,10k",
        first="Designator,Device,Footprint,Mid X,Mid Y,Ref X,Ref Y,Pad X,Pad Y,Pins,Layer,Rotation,SMD,Comment,Name"
    ),
    "pads.asc": rows("{name}   RES@{package} {xm:.3f} {ym:.3f} 0.000 U {flag} 0 -1 0 -1 1" + LABEL,
                     first="!PADS-POWERPCB-V9.5-MILS! DESIGN DATABASE ASCII FILE 1.0\n" + REMARKS, end="*END*     OF ASCII OUTPUT FILE"),
    "pads basic.asc": rows("{name}   T{package}\n  {xb:.0f} {yb:.0f}\n 0 N {flag} 0 -1 0 -1 0",
                           first="!PADS-POWERPCB-V2005.0-BASIC! DESIGN DATABASE ASCII FILE 1.0\n*PARTTYPE*   ITEMS\n\n"
                           "TR_0603        R_0603:R_0603_ALT UND 0 0 0\nTSOIC-8  SOIC-8 UND 0 0 0\n" + REMARKS, end="*NET*"),
    "PnP_card.csv": rows('"{name}","{x:.3f}","{y:.3f}","0","10k","{package}","{side}"', first='"Name","X","Y","Angle","Value","Package","Side"'),
}  # fmt: skip


@pytest.mark.parametrize("wide", [False, True])
@pytest.mark.parametrize("name", OWN_TABLES)
def test_centroids_of_further_tools_as_they_write_them(tmp_path: Path, name: str, wide: bool) -> None:
    """Some write UTF-16; units are in titles, cells or the first line."""
    (tmp_path / name).write_bytes(OWN_TABLES[name].encode("utf-16" if wide else "utf-8"))
    board = load_board(gerbers(tmp_path), tmp_path / name)
    assert middles(board) == RIGHT
    assert {each.name: each.package for each in board.components} == {
        name: "SOIC-8" if name == "U1" else "R_0603" for name in RIGHT
    }
    assert not {"unit-guessed", "parts-unit", "parts-frame", "parts-position"} & rules(board)


@pytest.mark.parametrize("mark", [",", "\t", " "])
def test_fusion_writes_a_file_a_side_without_titles(tmp_path: Path, mark: str) -> None:
    layers = gerbers(tmp_path)
    for side in ("front", "back"):
        own = [f"{name}{mark}{x:.2f}{mark}{y:.2f}{mark}0{mark}10k{mark}{'SOIC-8' if name == 'U1' else 'R_0603'}"
               for name, (x, y) in PLACES.items() if (name == "R2") == (side == "back")]  # fmt: skip
        (layers / f"PnP_card_{side}.txt").write_text("\n".join(own) + "\n")
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert {each.value for each in board.components} == {"10k"}


def moved(by: float, names: str = "") -> str:
    return centroid(
        places={name: (x + by * (name in names.split() or not names), y) for name, (x, y) in PLACES.items()}
    )


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("names", ["", "R1 R3"])
@pytest.mark.parametrize(("right", "wrong"), [("cpl.csv", "old.csv"), ("z.csv", "a.csv")])
def test_of_two_tables_that_contradict_the_one_on_the_copper_is_taken(
    tmp_path: Path, right: str, wrong: str, names: str, named: bool
) -> None:
    layers = gerbers(tmp_path, named=named)
    table(layers, right, centroid())
    table(layers, wrong, moved(3.0, names))
    board = load_board(layers)
    assert middles(board) == RIGHT
    (found,) = (each for each in board.findings if each.rule.id == "parts-tables")
    assert found.severity == "warning"
    assert f"place {2 if names else 5} of 5 components otherwise" in found.message
    assert f"{right} is taken, whose places lie on their pads" in found.message


def test_two_tables_that_nothing_decides_between_are_one_error_that_the_columns_file_answers(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    for name in ("b.gtl", "b.gbl"):
        (layers / name).unlink()
    table(layers, "a.csv", centroid().replace("R_0603", "R_0603_1.6x0.8mm"))
    table(layers, "b.csv", moved(3.0, "R1"))
    table(layers, "bom.csv", BILLS["altium"])
    (found,) = (each for each in load_board(layers).findings if each.rule.id == "parts-tables")
    assert found.severity == "error"
    assert "R1 (10.00, 20.00) in a.csv, (13.00, 20.00) in b.csv" in found.message
    assert "state `tables: [a.csv, bom.csv]` or `tables: [b.csv, bom.csv]` in columns.yaml" in found.message
    table(layers, "columns.yaml", "tables: [b.csv, bom.csv]\n")
    assert "parts-tables" not in rules(load_board(layers))


def test_what_two_bills_contradict_is_noted_of_every_kind(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    table(
        layers,
        "bom_A.csv",
        "Ref,Value,Footprint,MPN,DNP\nR1,10k,R_0603_1.6x0.8mm,A-1,\nR3,1k,R_0603,,DNP\nR4,1k5,R_0603,B,\n",
    )
    table(
        layers,
        "bom_B.csv",
        "Ref,Value,Footprint,MPN,DNP\nR1,22k,R_0805_2.0x1.25mm,A-2,\nR3,1k,R_0603,,\nR4,1k5 1%,R_0603,B,\n",
    )
    board = load_board(layers)
    found = {(each.component, each.about): (each.taken, each.source, each.other) for each in board.contradictions}
    assert found == {
        ("R1", "value"): ("10k", "bom_A.csv", "22k"),
        ("R1", "part"): ("A-1", "bom_A.csv", "A-2"),
        ("R1", "package"): ("R_0603_1.6x0.8mm", "bom_A.csv", "R_0805_2.0x1.25mm"),
        ("R3", "fitted"): ("not fitted", "bom_A.csv", "fitted"),
    }
    assert "R3" not in middles(board)


def test_tables_of_another_board_are_an_error(tmp_path: Path) -> None:
    for named in (False, True):
        place = tmp_path / str(named)
        place.mkdir()
        layers = gerbers(place, named=named)
        table(layers, "bom.csv", "Ref,Value\nQ1,fet\nQ2,fet\n")
        (found,) = (each for each in load_board(layers).findings if each.rule.id == "parts-not-on-board")
        assert (found.severity, "No row has a component" in found.message) == ("error", True)


@pytest.mark.parametrize("placed", [False, True])
def test_a_table_whose_titles_are_not_known_is_named_with_them(tmp_path: Path, placed: bool) -> None:
    layers = gerbers(tmp_path, named=True)
    table(layers, "list.csv", "Klumpen;Ort 1;Ort 2\nR1;10,0;20,0\nU1;25,0;15,0\n")
    table(layers, "drills.txt", "Tool\tSize\tCount\nT1\t0.3\t20\nT2\t0.8\t4\n")
    if placed:
        table(layers, "cpl.csv", centroid())
    (found,) = (each for each in load_board(layers).findings if each.rule.id == "parts-titles")
    assert found.severity == ("warning" if placed else "error")
    assert "list.csv seems to be a parts table, but its titles are not known: Klumpen; Ort 1; Ort 2." in found.message
    table(layers, "columns.yaml", "columns: {ref: Klumpen, x: Ort 1, y: Ort 2}\n")
    assert "parts-titles" not in rules(load_board(layers))


def test_findings_name_the_table_that_states_what_they_are_about(tmp_path: Path) -> None:
    """A table for each side in a folder of its own, of one name; braces in the name of a bill."""
    layers = gerbers(tmp_path)
    titles, *rows = centroid().splitlines()
    for side in ("top", "bottom"):
        (layers / side).mkdir()
        own = [row for row in rows if row.endswith(side)]
        own = [row.replace("12.0000,8.0000", "28.0000,8.0000") for row in own]  # mirrored
        table(layers / side, "cpl.csv", "\n".join([titles, *own]) + "\n")
    table(layers, "bom{1}.csv", "Designator,MPN,DNP\nR1,A,yes\nR4,B,no\nX9,C,no\n")
    notes = {each.rule.id: each.message for each in load_board(layers).findings}
    assert "The positions of the bottom in cpl.csv [bottom] were mirrored" in notes["parts-frame"]
    assert "not fitted by bom{1}.csv" in notes["parts-not-fitted"]
    assert "rows of bom{1}.csv are not on the board: X9" in notes["parts-not-on-board"]
    assert "cpl.csv [top] (4 rows)" in notes["parts-found"]
    (layers / "columns.yaml").write_text("tables: [top/cpl.csv]\n")
    assert set(middles(load_board(layers))) == {"R1", "R3", "R4", "U1"}
