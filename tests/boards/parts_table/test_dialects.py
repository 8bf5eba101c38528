# ruff: noqa: E501, RUF001  (the rows of tables are as long as their tools write them, in their letters)
"""Tables in other languages, encodings and forms, and with the usual mistakes: read as they are meant, or refused."""

import re
from pathlib import Path

import pytest
from orders import PACKAGES, PLACES, RIGHT, centroid, gerbers, middles, rules, table

from boards.errors import BoardError
from boards.load import load_board
from boards.parts_table.read import read_table


def rows(text: str, *titles: str) -> str:
    """A row for each part, with its name, package, place and side in the words of several languages."""
    lines = list(titles)
    for name, (x, y) in PLACES.items():
        below = name == "R2"
        lines.append(text.format(
            name=name, p=PACKAGES.get(name, "R_0603"), x=x, y=y, xc=f"{x:.3f}".replace(".", ","), yc=f"{y:.3f}".replace(".", ","),
            xm=x / 0.0254, ym=y / 0.0254, en="bottom" if below else "top", de="Unterseite" if below else "Oberseite",
            fr="Dessous" if below else "Dessus", es="Inferior" if below else "Superior", zh="底层" if below else "顶层",
            ja="裏面" if below else "表面", ru="Низ" if below else "Верх", layer=16 if below else 1, flag=int(below)))  # fmt: skip
    return "\n".join(lines) + "\n"


USUAL = ("Ref,Package,X,Y,Rotation,Side", "{name},{p},{x},{y},0,{en}")
TABLES: dict[str, tuple[str, str]] = {
    "German, semicolons": ("cp1252", rows("{name};{p};{xc};{yc};0;{de}", "Bauteil;Gehäuse;X-Position;Y-Position;Drehung;Seite")),
    "German, umlauts in two letters": ("utf-8", rows("{name};10k;{p};{xc};{yc};0,00;{de}", "Bezeichner;Wert;Gehaeuse;Mitte X (mm);Mitte Y (mm);Winkel;Lage")),
    "French": ("cp1252", rows("{name};{p};{xc};{yc};0;{fr}", "Repère;Boîtier;Position X;Position Y;Rotation;Face")),
    "Spanish": ("utf-8", rows("{name};{p};{xc};{yc};0;{es}", "Designador;Encapsulado;Posición X;Posición Y;Ángulo;Cara")),
    "Chinese, GBK": ("gbk", rows("{name},{p},{x}mm,{y}mm,0,{zh}", "位号,封装,中心X,中心Y,旋转,层")),
    "Chinese, wide brackets": ("utf-8", rows("{name},{p},{xm},{ym},0,{zh}", "位号,封装,X坐标\uff08mil\uff09,Y坐标\uff08mil\uff09,角度,面")),
    "Japanese": ("shift_jis", rows("{name},{p},{x},{y},0,{ja}", "リファレンス,フットプリント,X座標,Y座標,回転,面")),
    "Russian": ("utf-8", rows("{name};{p};{xc};{yc};0;{ru}", "Обозначение;Корпус;Координата X;Координата Y;Угол;Сторона")),
    "UTF-16 without a mark": ("utf-16-le", rows("{name}\t{p}\t{x}\t{y}\t0\t{en}", "Ref\tPackage\tPosX\tPosY\tRot\tSide")),
    "UTF-16, other order": ("utf-16-be", rows(USUAL[1], USUAL[0])),
    "Excel states its mark": ("utf-8", rows("{name};{p};{xc};{yc};0;{en}", "sep=;", "Ref;Package;PosX;PosY;Rot;Side")),
    "Excel keeps texts as formulas": ("utf-8", rows('="{name}",{p},"{x}","{y}",0,{en}', '="Ref",Package,PosX,PosY,Rot,Side')),
    "decimal commas between commas": ("utf-8", rows("{name},{p},{xc},{yc},0,{en}", USUAL[0])),
    "a long preamble": ("utf-8", rows(USUAL[1], "ACME Ltd.", "Job;4711;Rev;B", *["a note"] * 60, USUAL[0])),
    "units below the titles": ("utf-8", rows("{name},{p},{xm},{ym},0,{en}", USUAL[0], ",,mil,mil,deg,")),
    "groups above the titles": ("utf-8", rows(USUAL[1], ",,Centre,,Rotation,", USUAL[0])),
    "micrometres": ("utf-8", rows("{name},{p},{x}000,{y}000,0,{en}", "Ref,Package,X (µm),Y (µm),Rotation,Side")),
    "micrometres, not stated": ("utf-8", rows("{name},{p},{x}000,{y}000,0,{en}", USUAL[0])),
    "a unit in words": ("utf-8", rows("{name},{p},{xm},{ym},0,{en}", "Ref,Package,X in mil,Y in mil,Rotation,Side")),
    "centimetres": ("utf-8", rows("{name},{p},{x}e-1,{y}e-1,0,{en}", "Ref,Package,X (cm),Y (cm),Rotation,Side")),
    "Markdown": ("utf-8", rows("| {name} | {p} | {x} | {y} | 0 | {en} |", "| Ref | Package | X | Y | Rot | Side |", "|---|:-:|--:|---|---|---|")),
    "layers by number": ("utf-8", rows("{name},{p},{x},{y},0,{layer}", "Ref,Package,X,Y,Rotation,Layer")),
    "layers from zero": ("utf-8", rows("{name},{p},{x},{y},0,{flag}", "Ref,Package,X,Y,Rotation,Layer")),
    "layers as L1": ("utf-8", rows("{name},{p},{x},{y},0,L{layer}", "Ref,Package,X,Y,Rotation,Layer")),
    "mirrored by number": ("utf-8", rows("{name},{p},{x},{y},0,{flag}", "Ref,Package,X,Y,Rotation,Mirrored")),
    "sides in words": ("utf-8", rows("{name},{p},{x},{y},0,SMD {en} overlay", "Ref,Package,X,Y,Rotation,Layer")),
}  # fmt: skip


@pytest.mark.parametrize("kind", TABLES)
def test_a_table_is_read_in_the_words_and_the_form_of_its_tool(tmp_path: Path, kind: str) -> None:
    layers = gerbers(tmp_path)
    encoding, text = TABLES[kind]
    (layers / "cpl.csv").write_bytes(text.encode(encoding))
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert {each.package for each in board.components} == {"R_0603", "SOIC-8"}
    assert not {"parts-unit", "parts-frame", "parts-position", "parts-contradict"} & rules(board)


@pytest.mark.parametrize("below", [False, True])
def test_a_single_side_of_numbered_layers(tmp_path: Path, below: bool) -> None:
    number, side = (2, "bottom") if below else (1, "top")
    found = read_table(table(tmp_path, "t.csv", f"Ref,X,Y,Layer\nR1,1,2,{number}\nR2,3,4,{number}\n")).rows
    assert {row.side for row in found} == {side}


def test_commas_that_may_be_decimal_or_not_are_refused_with_the_line(tmp_path: Path) -> None:
    text = "Ref,X,Y,Rotation,Pins\nR1,10,250,20,125,0,2\n"
    with pytest.raises(BoardError, match=r"t\.csv:2: 7 cells stand below 5 titles: which commas are decimal ones"):
        read_table(table(tmp_path, "t.csv", text))


def test_a_place_that_is_absurd_in_every_unit_is_refused_with_the_line(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid(places={**PLACES, "R3": (4.2e6, 1.0)}))
    with pytest.raises(BoardError, match=r"cpl\.csv:3: R3 is farther than 10 m away\. Correct it, or state the `unit`"):
        load_board(layers)


@pytest.mark.parametrize(
    ("cell", "refs"),
    [
        ("R1\u2013R3", ["R1", "R2", "R3"]),
        ("R1~R3", ["R1", "R2", "R3"]),
        ("R1..R3", ["R1", "R2", "R3"]),
        ("R1\uff0cR2\u3001R3", ["R1", "R2", "R3"]),
        ("R1;R2 R3", ["R1", "R2", "R3"]),
        ("R1 - R3", ["R1", "R2", "R3"]),
        *((cell, ["R1", "R2", "R3"]) for cell in ("R1:R3", "R1 to R3", "R1 bis R3", "R1, 2, 3", "R1/R2/R3", "R1\nR2\nR3")),
        ("U1-2", ["U1-2"]), ("TP5V/1", ["TP5V/1"]), ("R 1", ["R1"]),
    ],
)  # fmt: skip
def test_lists_of_designators_as_people_write_them(tmp_path: Path, cell: str, refs: list[str]) -> None:
    assert [row.ref for row in read_table(table(tmp_path, "t.csv", f'Ref,Value\n"{cell}",1k\n')).rows] == refs


@pytest.mark.parametrize(
    ("title", "cell", "fitted"),
    [
        *(("Value", cell, False) for cell in ("DNP", "10k DNP", "10k (DNI)", "10k*DNP", "n.c.", "NM", "nicht bestückt")),
        *(("Value", cell, True) for cell in ("10n", "NCP1117", "10k NC7", "2N3904")),
        *(("Qty", cell, cell != "0") for cell in ("0", "1", "10")), ("Menge", "0", False),
        ("Remarks", "DNP", False), ("Notes", "do not mount before the wave", False), ("Notes", "see sheet 2", True),
        ("Assembly", "DNF", False), ("Variant", "Not Fitted", False), ("Status", "Do not place", False),
        ("Placed", "Unplaced", False), ("Placed", "Placed", True), ("Installed", "NI", False), ("POP", "NOPOP", False),
        ("Bestückung", "n.b.", False), ("Einbau", "nein", False), ("是否焊接", "否", False), ("实装", "0", False),
        ("実装", "実装", True), ("実装", "未実装", False), ("BOM_OPT", "NOSTUFF", False),
    ],
)  # fmt: skip
def test_what_is_not_fitted_is_known_however_it_is_said(title: str, cell: str, fitted: bool, tmp_path: Path) -> None:
    (row,) = read_table(table(tmp_path, "t.csv", f"Ref,Package,{title}\nR2,R_0603,{cell}\n")).rows
    assert row.is_fitted == fitted


@pytest.mark.parametrize("name", ["bottom.csv", "dnp.csv"])
def test_a_table_without_a_row_is_no_obstacle_in_an_order(name: str, tmp_path: Path) -> None:
    """As tools write one for each side, whether or not there is anything on it."""
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    table(layers, name, "Ref,Val,Package,PosX,PosY,Rot,Side\n" if name == "bottom.csv" else "Ref,Value\n")
    assert middles(load_board(layers)) == RIGHT
    alone = table(tmp_path, "alone.csv", "Ref,Value\n,\n")
    with pytest.raises(BoardError, match=r"alone\.csv: the table has no row with a reference designator"):
        load_board(layers, alone)


def test_layers_of_a_panel_that_repeat_a_board_have_all_of_them(tmp_path: Path) -> None:
    """Step and repeat of the Gerber language, around all that a layer draws."""
    layers = gerbers(tmp_path)
    for file in layers.iterdir():
        head, mark, rest = file.read_text().partition("D10*\nG01*\n" if file.suffix == ".gko" else "D11*\n")
        file.write_text(f"{head}%SRX2Y1I50.0J0*%\n{mark}{rest.replace('M02*', '%SR*%' + chr(10) + 'M02*')}")
    both = {**PLACES, **{f"{name}B": (x + 50, y) for name, (x, y) in PLACES.items()}}
    text = centroid(places=both).replace("R2B,R_0603,62.0000,8.0000,0,top", "R2B,R_0603,62.0000,8.0000,0,bottom")
    table(layers, "cpl.csv", text.replace("U1B,R_0603", "U1B,SOIC-8"))
    board = load_board(layers)
    assert (len(board.instances), len(board.components)) == (2, 10)
    block = layers / "b.gtl"
    block.write_text(block.read_text().replace("%SRX2Y1I50.0J0*%", "%ABD90*%"))
    with pytest.raises(BoardError, match=r"b\.gtl:7: aperture blocks \(%AB…\*%\) are not read"):
        load_board(layers)


def test_heights_at_most_and_rows_that_stand_twice(tmp_path: Path) -> None:
    rows = "U1,10,20,90,1.3 mm max\nU1,10,20,90,1.3 mm max\nU1,40,20,90,1.3 (max.)\nC1,1,1,0,\n"
    found = read_table(table(tmp_path, "t.csv", f"Ref,X (mm),Y (mm),Rot,Height (mm)\n{rows}")).rows
    assert [(row.ref, row.xy_mm, row.height_mm) for row in found] == [
        ("U1", (10.0, 20.0), 1.3), ("U1", (40.0, 20.0), 1.3), ("C1", (1.0, 1.0), None),
    ]  # fmt: skip


VIAS = [(25 + 0.9 * x, 15 + 0.9 * y) for x in (-1, 0, 1) for y in (-1, 0, 1)] + [(9, 19.8), (19, 25.2), (12, 8)]


@pytest.mark.parametrize("kind", ["through", "one layer empty"])
def test_vias_are_no_pads_and_a_side_without_pads_is_told(kind: str, tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    if kind == "through":
        flashed = "".join(f"X{round(x * 1e6)}Y{round(y * 1e6)}D03*\n" for x, y in VIAS)
        for name in ("b.gtl", "b.gbl"):
            text = (layers / name).read_text()
            (layers / name).write_text(text.replace("M02*", f"%ADD13C,0.6*%\nD13*\n{flashed}M02*"))
    else:
        (layers / "b.gbl").write_text("%FSLAX46Y46*%\n%MOMM*%\nM02*\n")
    board = load_board(layers)
    assert middles(board) == RIGHT
    told = [each.message for each in board.findings if each.rule.id == "parts-position"]
    assert [each.count("R2. Is its layer missing") for each in told] == ([] if kind == "through" else [1])
    assert "parts-not-in-table" not in rules(board)


@pytest.mark.parametrize("mark", "\t;")
def test_only_commas_between_cells_may_be_decimal_ones(tmp_path: Path, mark: str) -> None:
    """A cell beyond the titles is a remark: the turn and the quantity after it stay apart."""
    lines = ["Ref,PosX,PosY,Rot,Side", "R1,1.5,2.5,90,top,12,5", "R2,3.5,4.5,0,top"]
    rows = read_table(table(tmp_path, "t.csv", "\n".join(lines).replace(",", mark) + "\n")).rows
    assert [(row.ref, row.xy_mm, row.turn_deg) for row in rows] == [("R1", (1.5, 2.5), 90.0), ("R2", (3.5, 4.5), 0.0)]


SWAPPED = {"top": "bottom", "bottom": "top"}
MISTAKES: dict[str, tuple[dict[str, tuple[float, float]], str, str]] = {
    "sides swapped": (PLACES, "swapped", "5 statements on side contradict"),
    "one part on the wrong side": (PLACES, "R4", "R4 side top (copper), not bottom (cpl.csv)"),
    "no sides": (PLACES, "none", ""),
    "the bottom mirrored at the origin": ({**PLACES, "R2": (-12, 8)}, "", "positions of the bottom in cpl.csv were mirrored in x"),
    "the bottom mirrored at the edge": ({**PLACES, "R2": (28, 8)}, "", "positions of the bottom in cpl.csv were mirrored in x"),
    "turned and moved": ({name: (-y + 100, x + 50) for name, (x, y) in PLACES.items()}, "", "positions of the bottom in cpl.csv were turned by 270°"),
    "moved, and the bottom mirrored": ({name: ((90 - x if name == "R2" else x + 50), y + 7) for name, (x, y) in PLACES.items()}, "", "positions of the bottom in cpl.csv were mirrored in x"),
}  # fmt: skip


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize("kind", MISTAKES)
def test_the_usual_mistakes_are_settled_by_the_copper(tmp_path: Path, kind: str, named: bool) -> None:
    places, sides, words = MISTAKES[kind]
    text = centroid(places=places)
    if sides == "none":
        text = re.sub(r",(top|bottom)$|,Layer$", "", text, flags=re.MULTILINE)
    elif sides:
        lines = (re.sub(r"(top|bottom)$", lambda hit: SWAPPED[hit[0]], line) if sides == "swapped" or line.startswith(sides) else line
                 for line in text.splitlines())  # fmt: skip
        text = "\n".join(lines) + "\n"
    layers = gerbers(tmp_path, named=named)
    table(layers, "cpl.csv", text)
    board = load_board(layers)
    assert middles(board) == RIGHT
    if words and not (named and "bottom" in words):  # of named copper three places of a side lay it, R2 is alone
        assert any(words in each.message for each in board.findings)


@pytest.mark.parametrize("named", [False, True])
@pytest.mark.parametrize(("title", "scale", "words"), [
    ("mil", 1.0, "are read as mm, not as mil (title): so 5 of them"),
    ("mm", 1 / 0.0254, "are read as mil, not as mm (title): so 5 of them"),
    ("inch", 1 / 0.0254, "are read as mil, not as inch (title): so 5 of them"),
])  # fmt: skip
def test_a_unit_that_the_copper_contradicts_is_that_of_the_copper(
    tmp_path: Path, title: str, scale: float, words: str, named: bool
) -> None:
    layers = gerbers(tmp_path, named=named)
    table(layers, "cpl.csv", centroid(scale=scale, head=f"RefDes,Package,X({title}),Y({title}),Rotation,Layer"))
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert any(each.rule.id == "unit-guessed" and words in each.message for each in board.findings)


def test_a_file_for_each_side_has_the_unit_of_both(tmp_path: Path) -> None:
    """One part alone would fit the board in any unit."""
    layers = gerbers(tmp_path)
    for side in ("top", "bottom"):
        own = "".join(f"{name},{PACKAGES.get(name, 'R_0603')},{x / 25.4:.5f},{y / 25.4:.5f},0\n" for name, (x, y) in PLACES.items()
                      if (name == "R2") == (side == "bottom"))  # fmt: skip
        table(layers, f"{side}.csv", f"Ref,Package,X,Y,Rotation\n{own}")
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert "parts-unit" not in rules(board)
