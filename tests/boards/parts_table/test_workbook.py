"""Workbooks of spreadsheets: each sheet is a table like any other; damaged ones and bombs are refused."""

import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from shutil import make_archive
from xml.sax.saxutils import escape

import pytest
from command import washboard
from orders import PACKAGES, PLACES, RIGHT, centroid, gerbers, middles, rules, table

from boards.errors import BoardError
from boards.load import load_board
from boards.parts_table.workbook import is_workbook, read_sheets

Cell = str | float | bool | None
MAIN = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
LINK = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
CENTROID: list[Sequence[Cell]] = [
    ("Designator", "Package", "Mid X", "Mid Y", "Rotation", "Layer"),
    *((name, PACKAGES.get(name, "R_0603"), x + 0.1 + 0.2 - 0.3, float(y), 0.0, "bottom" if name == "R2" else "top")
      for name, (x, y) in PLACES.items()),
]  # fmt: skip
BILL: list[Sequence[Cell]] = [
    ("Bill of materials", None, "rev. B"),
    (),
    ("Item", "Designator", "Part Number", "Height", "DNP"),
    (1.0, "R1, R2,\nR3-R4", "RC0603", 0.5, False),
    (2.0, "U1", "LM358", 1.7, None),
]


def workbook(sheets: Mapping[str, Sequence[Sequence[Cell]]], kind: str = "shared", hidden: str = "") -> bytes:
    """A workbook as a program writes it: texts shared, inline or with runs; places stated or not; prefixes."""
    texts: list[str] = []

    def cell(column: int, row: int, value: Cell) -> str:
        place = "" if kind == "bare" else f' r="{chr(65 + column)}{row}"'
        if value is None:
            return "<c/>" if kind == "bare" else ""
        if isinstance(value, bool):
            return f'<c{place} t="b"><v>{int(value)}</v></c>'
        if isinstance(value, float):
            return f"<c{place}><v>{value!r}</v></c>"
        if kind == "shared":
            texts.append(value)
            return f'<c{place} t="s" s="3"><v>{len(texts) - 1}</v></c>'
        if kind == "formula":
            return f'<c{place} t="str"><f>A1&amp;"x"</f><v>{escape(value)}</v></c>'
        return f'<c{place} t="inlineStr"><is><t xml:space="preserve">{escape(value)}</t></is></c>'

    files: dict[str, str] = {}
    links, names = "", ""
    for number, (name, rows) in enumerate(sheets.items(), start=1):
        body = "".join(
            f"<row{'' if kind == 'bare' else f' r={chr(34)}{n}{chr(34)}'}>"
            f"{''.join(cell(column, n, value) for column, value in enumerate(row))}</row>"
            for n, row in enumerate(rows, start=1)
        )
        files[f"xl/worksheets/sheet{number}.xml"] = f"<worksheet {MAIN}><sheetData>{body}</sheetData></worksheet>"
        target = "/xl/worksheets" if kind == "bare" else "worksheets"
        links += f'<Relationship Id="rId{number}" Type="{LINK}/worksheet" Target="{target}/sheet{number}.xml"/>'
        state = ' state="hidden"' if name == hidden else ""
        names += f'<sheet name="{escape(name)}" sheetId="{number}"{state} r:id="rId{number}"/>'
    files["xl/workbook.xml"] = f'<workbook {MAIN} xmlns:r="{LINK}"><sheets>{names}</sheets></workbook>'
    files["xl/_rels/workbook.xml.rels"] = f"<Relationships>{links}</Relationships>"
    if texts:
        runs = "".join(f"<si><r><t>{escape(each[:1])}</t></r><r><t>{escape(each[1:])}</t></r></si>" for each in texts)
        files["xl/sharedStrings.xml"] = f"<sst {MAIN}>{runs}</sst>"
    return packed(files)


def packed(files: Mapping[str, str | bytes]) -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<Types/>")
        for name, text in files.items():
            archive.writestr(name, text)
    return stream.getvalue()


def order(folder: Path, content: bytes, name: str = "order.xlsx") -> Path:
    layers = gerbers(folder)
    (layers / name).write_bytes(content)
    return layers


@pytest.mark.parametrize("name", ["order.xlsx", "Order.XLSM", "parts.csv", "Stueckliste"])
@pytest.mark.parametrize("kind", ["shared", "inline", "formula", "bare"])
def test_bill_and_centroid_are_sheets_of_one_workbook(tmp_path: Path, kind: str, name: str) -> None:
    """Whatever the file is called; titles and empty rows stand above the bill."""
    layers = order(tmp_path, workbook({"Notes": [("Read me",)], "PnP": CENTROID, "BOM": BILL}, kind), name)
    for path in (layers, Path(make_archive(str(tmp_path / "order"), "zip", layers))):
        board = load_board(path)
        assert middles(board) == RIGHT
        assert {each.name: (each.part, each.height_mm) for each in board.components} == {
            each: ("LM358", 1.7) if each == "U1" else ("RC0603", 0.5) for each in PLACES
        }
        states = {each.name: each.states for each in board.sources}
        assert states[f"{name} [BOM]"].startswith("5 rows; ref: Designator")
        assert states[f"{name} [PnP]"].startswith("5 rows; ref: Designator")


def test_a_workbook_is_given_as_any_table(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    (tmp_path / "p.xlsx").write_bytes(workbook({"PnP": CENTROID, "BOM": BILL}))
    assert middles(load_board(layers, tmp_path / "p.xlsx")) == RIGHT
    (tmp_path / "one.xlsx").write_bytes(workbook({"BOM": BILL}))
    table(tmp_path, "cpl.csv", centroid())
    board = load_board(layers, [tmp_path / "cpl.csv", tmp_path / "one.xlsx"])
    assert {each.part for each in board.components} == {"LM358", "RC0603"}
    assert "one.xlsx" in {each.name for each in board.sources}
    (tmp_path / "none.xlsx").write_bytes(workbook({"a": [("x", "y")], "b": [("z",)]}))
    with pytest.raises(BoardError, match=r"none\.xlsx \[a\]: no line names the columns"):
        load_board(layers, tmp_path / "none.xlsx")


def test_what_a_cell_does_not_say_is_refused_with_sheet_and_row(tmp_path: Path) -> None:
    rows = [*BILL, (3.0, "C9", "X", "high", None)]
    outcome = washboard("board", "show", order(tmp_path, workbook({"PnP": CENTROID, "BOM": rows})))
    assert outcome.code == 2
    assert "order.xlsx [BOM]:6: column Height: 'high' is not a length" in outcome.err


def test_hidden_sheets_are_not_read_and_sheets_are_named_in_findings(tmp_path: Path) -> None:
    """A hidden sheet keeps what was once meant; two that contradict each other are told apart by name."""
    old = [CENTROID[0], *((row[0], row[1], 3.0 + 2.0 * n, 3.0, 0.0, "top") for n, row in enumerate(CENTROID[1:]))]
    layers = order(tmp_path, workbook({"old": old, "PnP": CENTROID}, hidden="old"))
    assert "parts-tables" not in rules(load_board(layers))
    (layers / "order.xlsx").write_bytes(workbook({"old": old, "PnP": CENTROID}))
    notes = {each.rule.id: each.message for each in load_board(layers).findings}
    assert "order.xlsx [PnP] is taken" in notes["parts-tables"]
    (layers / "columns.yaml").write_text("tables: ['order.xlsx [PnP]']\n")
    assert "parts-tables" not in rules(load_board(layers))


def sheet_of(rows: str) -> bytes:
    book = workbook({"BOM": BILL})
    with zipfile.ZipFile(io.BytesIO(book)) as archive:
        files = {name: archive.read(name) for name in archive.namelist() if "Types" not in name}
    return packed({**files, "xl/worksheets/sheet1.xml": f"<worksheet><sheetData>{rows}</sheetData></worksheet>"})


ENTITY = '<!DOCTYPE s [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;">]><worksheet>&b;</worksheet>'


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (workbook({"BOM": BILL})[:-40], "not a text table|damaged"),
        (packed({"xl/workbook.xml": "<workbook/>"}), "it lists no sheets"),
        (packed({"xl/workbook.xml": "<workbook>", "xl/_rels/workbook.xml.rels": "<R/>"}), "not valid XML"),
        (packed({"xl/workbook.xml": ENTITY, "xl/_rels/workbook.xml.rels": "<R/>"}), "declares entities"),
        (packed({"xl/workbook.xml": b" " * 30_000_000}), "100 times its size"),
        (packed({"xl/workbook.xml": "<a/>", "../xl/a.xml": "<a/>"}), "leads out of it"),
        (b"\xd0\xcf\x11\xe0" + b"\0" * 900, "not a text table"),
    ],
)
def test_damaged_workbooks_and_bombs_are_refused_in_one_sentence(tmp_path: Path, content: bytes, words: str) -> None:
    layers = gerbers(tmp_path)
    (tmp_path / "p.xlsx").write_bytes(content)
    with pytest.raises(BoardError, match=words) as caught:
        load_board(layers, tmp_path / "p.xlsx")
    assert str(caught.value).startswith(str(tmp_path / "p.xlsx"))


def test_rows_and_columns_far_away_cost_nothing(tmp_path: Path) -> None:
    rows = (
        '<row r="1"><c r="A1" t="inlineStr"><is><t>Ref</t></is></c><c r="B1" t="str"><v>MPN</v></c></row>'
        '<row r="1000000"><c r="A1" t="str"><v>R1</v></c><c r="XFD9" t="str"><v>x</v></c>'
        '<c r="B1" t="s"><v>99</v></c></row>'
        '<row r="99999999"><c t="str"><v>R2</v></c></row>'
    )
    ((file, text),) = read_sheets(sheet_of(rows), tmp_path / "p.xlsx").items()
    assert file.name == "p.xlsx"
    assert text.count(b"\n") == 1_000_001
    assert text.splitlines()[999_999] == b"R1\t"
    assert not is_workbook(b"PK\x03\x04 a zip of something else")
