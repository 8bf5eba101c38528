"""Orders: folders and archives with a board of any format and its tables, and what a columns file states of them."""

import io
import re
import zipfile
from pathlib import Path
from shutil import copy, copytree, make_archive

import pytest
from command import washboard
from orders import BILLS, HEAD, RIGHT, centroid, gerbers, middles, rules, table
from rich.console import Console

from boards.board import Board
from boards.errors import BoardError
from boards.load import load_board
from reports.cards.workpiece import board_card
from reports.html.page import blocks_html
from reports.terminal.console import print_card
from webui.theme.html import card_html

CORPUS = Path(__file__).parents[2] / "fuzz" / "corpus"
BOARDS = {
    "KiCad": ("KiCad/v9.kicad_pcb", "X1"),
    "Eagle": ("Eagle/small.brd", "C1"),
    "IDF": ("IDF/notched", "U1"),
    "IPC-2581": ("IPC-2581/inch.xml", "U1"),
    "ODB++": ("ODB++/job", "U1"),
    "STEP": ("STEP/b.step", "R1"),
    "glTF": ("glTF/b.glb", "R1"),
    "tri": ("board-tri/small.tri.gz", "R1"),
    "Gerber": ("Gerber/copper", "U1"),
}


def order(folder: Path, kind: str, packed: str, *, nested: bool = True) -> tuple[Board, Board, str]:
    """A board alone, the order of it with a table and what systems add, and the component in the table."""
    source, name = BOARDS[kind]
    place = folder / "order" / "card" if nested else folder / "order"
    if (CORPUS / source).is_dir():
        copytree(CORPUS / source, place)
    else:
        place.mkdir(parents=True)
        (place / Path(source).name).write_bytes((CORPUS / source).read_bytes())
    (place.parent / "bom.csv").write_text(f"Designator,MPN,Height\n{name},ACME-1,3.3\n")
    (place.parent / "__MACOSX").mkdir()
    (place.parent / "__MACOSX" / "._b.kicad_pcb").write_bytes(b"\0\0")
    (place.parent / ".DS_Store").write_bytes(b"\0")
    (place.parent / "notes.txt").write_text("Please clean it well.\n")
    path = folder / "order"
    if packed:
        path = Path(make_archive(str(folder / "packed"), packed, folder / "order"))
    return load_board(CORPUS / source), load_board(path), name


@pytest.mark.parametrize("packed", ["", "zip", "gztar"])
@pytest.mark.parametrize("kind", BOARDS)
def test_a_board_of_any_format_is_found_with_its_tables(tmp_path: Path, kind: str, packed: str) -> None:
    alone, found, name = order(tmp_path, kind, packed)
    assert middles(found) == middles(alone)
    assert [each.part for each in found.components if each.name == name] == ["ACME-1"]
    kinds = {each.name: each.kind for each in found.sources}
    assert kinds["bom.csv"] == "parts table"
    assert kinds["other texts"] == "not read"
    assert not any("MACOSX" in each or "DS_Store" in each for each in kinds)
    assert "parts-found" in rules(found)


def test_the_usual_order_has_its_layers_packed_beside_its_tables(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    (tmp_path / "order").mkdir()
    make_archive(str(tmp_path / "order" / "gerbers"), "zip", layers)
    table(tmp_path / "order", "cpl.csv", centroid())
    table(tmp_path / "order", "bom.csv", BILLS["altium"])
    for path in (tmp_path / "order", Path(make_archive(str(tmp_path / "all"), "zip", tmp_path / "order"))):
        board = load_board(path)
        assert middles(board) == RIGHT
        assert {each.height_mm for each in board.components} == {0.5, 1.7}


def test_of_several_formats_the_one_that_states_most_is_the_board(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    (layers / "card.kicad_pcb").write_bytes((CORPUS / "KiCad/v9.kicad_pcb").read_bytes())
    board = load_board(layers)
    assert {each.name: each.kind for each in board.sources} == {
        "card.kicad_pcb": "board, KiCad", "layers": "not read",
    }  # fmt: skip
    assert "order-boards" not in rules(board)


def test_what_is_packed_again_or_kept_as_a_backup_is_no_second_board(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    make_archive(str(tmp_path / "again"), "zip", layers)
    (layers / "again.zip").write_bytes((tmp_path / "again.zip").read_bytes())
    (layers / "bom.xlsx").write_bytes(b"PK")
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert "order-boards" not in rules(board)
    assert {each.name: each.states for each in board.sources}["bom.xlsx"].startswith("save it as CSV")
    assert [each.name for each in board.sources].count("cpl.csv") == 1
    (layers / "card-backups").mkdir()
    for number in range(25):
        (layers / "card-backups" / f"{number}.zip").write_bytes((tmp_path / "again.zip").read_bytes())
    assert middles(load_board(layers)) == RIGHT
    only = tmp_path / "only"
    copytree(layers / "card-backups", only)
    with pytest.raises(BoardError, match="holds 25 archives: name the one of the board"):
        load_board(only)


def two_boards(folder: Path, kind: str) -> tuple[Path, str, str]:
    """An order of two boards, and what the columns file calls each of them."""
    path = folder / "order"
    path.mkdir()
    if kind == "KiCad":
        for name, source in (("a", "v9"), ("b", "v5")):
            (path / f"{name}.kicad_pcb").write_bytes((CORPUS / f"KiCad/{source}.kicad_pcb").read_bytes())
        return path, "a.kicad_pcb", "b.kicad_pcb"
    layers = gerbers(folder)
    for name in ("one", "two"):
        for file in layers.iterdir():
            place = path / name if kind == "folders" else path
            place.mkdir(exist_ok=True)
            text = file.read_text().replace("X40000000", "X44000000" if name == "two" else "X40000000")
            (place / file.name.replace("b.", f"{name}.")).write_text(text)
    return path, "one", "two"


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", ["KiCad", "folders", "names"])
def test_two_boards_in_one_order_are_one_error_that_the_columns_file_answers(
    tmp_path: Path, kind: str, packed: bool
) -> None:
    path, first, second = two_boards(tmp_path, kind)
    if packed:
        path = Path(make_archive(str(tmp_path / "order"), "zip", path))
    board = load_board(path)
    (found,) = (each for each in board.findings if each.rule.id == "order-boards")
    assert found.severity == "error"
    assert f"holds 2 boards: {first}, {second}. {first} is taken" in found.message
    assert f"board: {second}" in found.message
    beside = tmp_path / "order.columns.yaml" if packed else path / "columns.yaml"
    beside.write_text(f"board: {second}\n")
    other = load_board(path)
    assert "order-boards" not in rules(other)
    assert other.sources[0].name == second
    if kind != "KiCad":
        assert (board.outline.bounds[2], other.outline.bounds[2]) == pytest.approx((40.0, 44.0))


def test_a_plan_of_two_boards_is_refused(tmp_path: Path) -> None:
    path, _, second = two_boards(tmp_path, "KiCad")
    outcome = washboard("plan", path, "-o", tmp_path / "a.wash")
    assert outcome.code == 2
    assert f"board: {second}" in outcome.err + outcome.out
    assert not (tmp_path / "a.wash").exists()


def test_an_empty_order_and_one_without_a_board_are_refused(tmp_path: Path) -> None:
    (tmp_path / "order").mkdir()
    with pytest.raises(BoardError, match="holds no files: name the folder"):
        load_board(tmp_path / "order")
    table(tmp_path / "order", "bom.csv", BILLS["jlc"])
    with pytest.raises(BoardError, match=r"no other file of a board, only \.csv\. Export the board"):
        load_board(tmp_path / "order")


def test_an_error_in_an_archive_names_the_archive_and_the_file_in_it(tmp_path: Path) -> None:
    path = tmp_path / "order.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("card/b.kicad_pcb", "(kicad_pcb (version 20240108)\n  (layers\n")
    with pytest.raises(BoardError) as refused:
        load_board(path)
    assert str(refused.value).startswith(f"{path}/card/b.kicad_pcb")
    assert refused.value.file == path / "card/b.kicad_pcb"


OWN = "Teilchen;Hülle;Ort quer;Ort längs;Wendung;Blatt\n" + "".join(
    f"{name};{'SOIC-8' if name == 'U1' else 'R_0603'};{x / 0.0254:.2f};{y / 0.0254:.2f};0;{side}\n"
    for name, (x, y, side) in RIGHT.items()
)
TITLES = "columns: {ref: [Teilchen, Teil], package: Hülle, x: Ort quer, y: Ort längs, rotation: Wendung, side: Blatt}\n"


@pytest.mark.parametrize("words", [{}, {"Teilchen": "部件", "Ort quer": "横", "Ort längs": "纵"}])
def test_titles_and_the_unit_are_stated_once(tmp_path: Path, words: dict[str, str]) -> None:
    layers, text, titles = gerbers(tmp_path), OWN, f"{TITLES}unit: mil\n"
    for known, other in words.items():
        text, titles = text.replace(known, other), titles.replace(known, other)
    table(layers, "lage.csv", text)
    assert middles(load_board(layers)) == {}
    table(layers, "columns.yaml", titles)
    board = load_board(layers)
    assert middles(board) == RIGHT
    (used,) = (each for each in board.findings if each.rule.id == "parts-columns")
    assert "unit mil" in used.message
    assert used.severity == "info"
    assert "places in mil (columns.yaml)" in {each.name: each.states for each in board.sources}["lage.csv"]


def test_the_columns_file_beside_a_board_and_its_table_is_used(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    given = table(tmp_path, "lage.csv", OWN)
    table(layers, "columns.yaml", f"{TITLES}unit: mil\n")
    assert middles(load_board(layers, given)) == RIGHT
    path = Path(make_archive(str(tmp_path / "card"), "zip", layers))
    (layers / "columns.yaml").rename(tmp_path / "card.columns.yaml")
    table(tmp_path, "columns.yaml", "unit: inch\n")  # of the other boards in the folder
    assert middles(load_board(path, given)) == RIGHT


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("unit: cm\n", r"columns\.yaml:1: unit: "),
        ("columns:\n  reff: Bauteil\n", r"columns\.yaml:2: columns\.reff"),
        ("columns:\n  ref: 3\n", r"columns\.yaml:2: columns\.ref"),
        ("heights_mm:\n  U1: -2\n", r"columns\.yaml:2: heights_mm\.U1: "),
        ("heigths_mm: {}\n", r"columns\.yaml:1: heigths_mm"),
        (
            "board: other.kicad_pcb\n",
            r"columns\.yaml: board: other\.kicad_pcb is not in the order\. Its boards are ",
        ),
        ("tables: [a.csv]\n", r"columns\.yaml: tables: a\.csv is not in the order\. Its texts are cpl\.csv"),
        ("columns: [\n", r"columns\.yaml:\d"),
    ],
)
def test_a_mistake_in_the_columns_file_is_one_sentence_with_its_path(tmp_path: Path, text: str, words: str) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    table(layers, "columns.yaml", text)
    with pytest.raises(BoardError, match=words):
        load_board(layers)


def test_a_title_that_no_table_has_is_a_warning(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    table(layers, "columns.yaml", "columns: {height: Hoehe}\n")
    (found,) = (each for each in load_board(layers).findings if each.severity == "warning" and "Hoehe" in each.message)
    assert "columns.height: no table has a column 'Hoehe'" in found.message


def test_listed_tables_are_joined_and_no_others(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    table(layers, "old.csv", centroid(places={"R1": (1, 1)}))
    table(layers, "columns.yaml", "tables: [cpl.csv]\n")
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert not board.contradictions


def test_the_card_has_every_file_and_what_contradicts(tmp_path: Path) -> None:
    layers = gerbers(tmp_path)
    table(layers, "a-cpl.csv", centroid())
    table(layers, "bom.csv", "Ref,Side,Height\nR1,bottom,0.5\nU1,top,1.7\n")
    table(layers, "heights.csv", "Ref,Height\nU1,2.4\n")
    card = board_card(load_board(layers))
    terminal = Console(file=io.StringIO(), width=220)
    print_card(terminal, card)
    for text in (terminal.file.getvalue(), blocks_html(card.blocks), card_html(card)):
        for word in ("a-cpl.csv", "5 rows; ref: RefDes", "bom.csv", "copper, top", "edge", "top (a-cpl.csv)",
                     "bottom (bom.csv)", "1.7 mm (bom.csv)", "2.4 mm (heights.csv)"):  # fmt: skip
            assert word in text


def test_heights_that_nothing_states_are_listed_by_package_and_answered_once(tmp_path: Path) -> None:
    """The larger and the more often a package is there, the further up it stands."""
    layers = gerbers(tmp_path)
    rows = centroid().replace("R_0603", "Gizmo").replace("SOIC-8", "Gadget").replace("R2,Gizmo", "R2,Widget")
    table(layers, "cpl.csv", rows)
    (found,) = (each.message for each in load_board(layers).findings if each.rule.id == "assumed-height")
    assert re.search(r"5 components .*: Gadget 12 mm \(U1\), Gizmo [\d.]+ mm \(R1, R3, R4\), Widget", found)
    card = blocks_html(board_card(load_board(layers)).blocks)
    assert card.index("heights to state") < card.index("Gadget") < card.index("R1, R3, R4") < card.index("Widget")
    table(layers, "columns.yaml", "heights_mm: {gizmo: 1.5, U1: 4, Widget: 0.75, R1: 2, X9: 3}\n")
    board = load_board(layers)
    assert {each.name: each.height_mm for each in board.components} == pytest.approx(
        {"R1": 2.0, "R2": 0.75, "R3": 1.5, "R4": 1.5, "U1": 4.0}
    )
    assert {each.height_source for each in board.components} == {"stated"}
    assert "assumed-height" not in rules(board)
    assert any("heights in columns.yaml are of no component and no package of the board: X9" in each.message
               for each in board.findings)  # fmt: skip


@pytest.mark.parametrize("kind", ["KiCad", "IDF", "ODB++", "tri"])
def test_a_columns_file_states_heights_of_a_board_of_any_format(tmp_path: Path, kind: str) -> None:
    source, name = BOARDS[kind]
    alone, nominal = load_board(CORPUS / source), {"KiCad"}
    path = tmp_path / Path(source).name
    copytree(CORPUS / source, path) if (CORPUS / source).is_dir() else copy(CORPUS / source, path)
    (path / "columns.yaml" if path.is_dir() else tmp_path / "columns.yaml").write_text(f"heights_mm: {{{name}: 7}}\n")
    board = load_board(path)
    before, after = ({each.name: each.height_mm for each in found.components} for found in (alone, board))
    if kind in nominal or before[name] != after[name]:
        assert after == pytest.approx({**before, name: 7.0})
    else:  # a height that is drawn stays, and the difference is noted
        assert [(each.component, each.about, each.other) for each in board.contradictions] == [(name, "height", "7 mm")]


@pytest.mark.parametrize("kind", ["KiCad", "Eagle", "Gerber"])
def test_a_board_without_a_component_is_noticed_in_any_format(tmp_path: Path, kind: str) -> None:
    text = {
        "KiCad": '(kicad_pcb (version 20240108) (gr_rect (start 0 0) (end 30 20) (layer "Edge.Cuts")))',
        "Eagle": '<eagle version="9.6.2"><drawing><board><plain>'
        + "".join(f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="0" layer="20"/>' for a, b, c, d in
                  ((0, 0, 30, 0), (30, 0, 30, 20), (30, 20, 0, 20), (0, 20, 0, 0)))
        + "</plain></board></drawing></eagle>",
        "Gerber": f"{HEAD}D10*G01*X0Y0D02*X30000000D01*Y20000000D01*X0D01*Y0D01*M02*",
    }[kind]  # fmt: skip
    file = tmp_path / {"KiCad": "b.kicad_pcb", "Eagle": "b.brd", "Gerber": "b.gko"}[kind]
    file.write_text(text)
    assert "no-components" in rules(load_board(file))


@pytest.mark.parametrize("kind", ["KiCad", "Gerber"])
def test_a_table_of_another_board_is_an_error(tmp_path: Path, kind: str) -> None:
    if kind == "KiCad":
        text = (CORPUS / "KiCad/v9.kicad_pcb").read_text()
        file = table(tmp_path, "b.kicad_pcb", re.sub(r"\(at (\d)", r"(at 9\1", text))
        board = load_board(file)
    else:
        layers = gerbers(tmp_path)
        for name in ("b.gtl", "b.gbl"):
            (layers / name).unlink()
        away = centroid(places={name: (x + 500, y) for name, (x, y, _) in RIGHT.items()}, head=PLACED_MM)
        board = load_board(layers, table(tmp_path, "cpl.csv", away.replace("R_0603", "R_0603_1.6x0.8mm")))
    assert [each.severity for each in board.findings if each.rule.id == "component-outside"] == ["error"]


PLACED_MM = "RefDes,Package,X(mm),Y(mm),Rotation,Layer"
