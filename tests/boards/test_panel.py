"""Panel files: places, turns and sides of their boards, rails and tabs; mistakes are named with their line."""

import math
from pathlib import Path

import numpy as np
import pytest
from ecad_writers import EcadBoard, EcadPart, ipc2581, odb, write_folder
from shapely import box

from boards.errors import BoardError
from boards.load import load_board
from boards.panel import turned_over
from boards.workpiece import load_workpiece


def refused(folder: Path, text: str) -> str:
    file = folder / "p.yaml"
    file.write_text(text, "utf-8")
    with pytest.raises(BoardError) as caught:
        load_board(file)
    assert str(caught.value).startswith(str(file))
    return str(caught.value)


@pytest.mark.parametrize("suffix", ["yaml", "yml"])
@pytest.mark.parametrize("key", ["panel", '"panel"', "'panel' ", "\ufeffpanel", '\ufeff"panel"'])
def test_a_panel_is_one_however_its_key_is_written(key: str, suffix: str, tmp_path: Path) -> None:
    (tmp_path / f"p.{suffix}").write_text(f"{key}: {{board: tiny, nx: 2, ny: 1, pitch_mm: [33, 24]}}\n", "utf-8")
    assert len(load_workpiece(tmp_path / f"p.{suffix}").require_board("a test").instances) == 2


def test_boards_of_a_grid_lie_at_their_pitch_from_the_front_left(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("panel: {board: tiny, nx: 2, ny: 2, pitch_mm: [33, 24]}\n")
    panel, tiny = load_board(tmp_path / "p.yaml"), load_board(Path("tiny"))
    assert panel.outline.bounds == pytest.approx((0.0, 0.0, 33.0 + 30.0, 24.0 + 20.0), abs=0.01)
    single = next(each for each in tiny.components if each.name == "U1").outline.centroid
    x0, y0, _, _ = tiny.outline.bounds
    for number, (x, y) in enumerate([(0, 0), (33, 0), (0, 24), (33, 24)], start=1):
        placed = next(each for each in panel.components if each.name == f"U1@{number}").outline.centroid
        assert (placed.x, placed.y) == pytest.approx((single.x - x0 + x, single.y - y0 + y), abs=1e-3)


CARD = EcadBoard(
    box(5, 5, 45, 35),
    1.6,
    (EcadPart("U1", 15, 15, 6, 4, 1.2, 30, "top", pins=4), EcadPart("C1", 35, 28, 2, 1, 0.8, 90, "bottom")),
)
REPEATS = [(0.0, 0.0, 2, 1, 60.0, 0.0, 0.0, False), (60.0, 100.0, 1, 1, 0.0, 0.0, 20.0, True)]


@pytest.mark.parametrize("kind", ["xml", "odb"])
def test_step_and_repeat_of_the_file_is_used(kind: str, tmp_path: Path) -> None:
    """Two boards in a row and one that is turned over; the panel's own profile is material."""
    if kind == "xml":
        (tmp_path / "card.xml").write_text(ipc2581(CARD, "B", "INCH", repeats=REPEATS), "utf-8")
    else:
        write_folder(odb(CARD, repeats=REPEATS), tmp_path / "card")
    (tmp_path / "p.yaml").write_text(f"panel: {{board: card{'.xml' if kind == 'xml' else ''}}}\n")
    panel = load_board(tmp_path / "p.yaml")
    assert panel.outline.bounds == pytest.approx((-20.0, -20.0, 200.0, 150.0), abs=0.01)
    found = {each.name: each for each in panel.components}
    assert len(found) == 6
    turn = math.radians(20.0)
    for part in CARD.parts:
        for name, x in (("1", 0.0), ("2", 60.0)):
            centre = found[f"{part.name}@{name}"].outline.centroid
            assert (centre.x, centre.y) == pytest.approx((part.x + x, part.y), abs=0.01)
            assert found[f"{part.name}@{name}"].side == part.side
        over = found[f"{part.name}@3"]
        place = (
            60.0 - math.cos(turn) * part.x - math.sin(turn) * part.y,
            100.0 - math.sin(turn) * part.x + math.cos(turn) * part.y,
        )
        assert (over.outline.centroid.x, over.outline.centroid.y) == pytest.approx(place, abs=0.01)
        assert over.side != part.side


def nested(kind: str, folder: Path) -> Path:
    """Two boards in a cell, the second turned over, and two cells on the panel, the second turned by 180 degrees."""
    cells = [(0.0, 0.0, 1, 1, 0.0, 0.0, 0.0, False), (180.0, 140.0, 1, 1, 0.0, 0.0, 180.0, False)]
    own = [(42.0, 2.0, 1, 1, 0.0, 0.0, 90.0, False), (92.0, 50.0, 1, 1, 0.0, 0.0, -90.0, True)]
    if kind == "xml":
        text, inner = (ipc2581(CARD, repeats=each) for each in (cells, own))
        step = inner[inner.index('<Step name="array">') : inner.index("</CadData>")].replace("array", "cell")
        step = step[: step.index("<Profile>")] + step[step.index("</Profile>") + 10 :]
        at = text.index('<Step name="array">')
        (folder / "card.xml").write_text(text[:at] + step + text[at:].replace('stepRef="card"', 'stepRef="cell"'))
        return folder / "card.xml"
    files, inner_files = (odb(CARD, repeats=each) for each in (cells, own))
    files["steps/array/stephdr"] = files["steps/array/stephdr"].replace("NAME=CARD", "NAME=CELL")
    files["steps/cell/stephdr"] = inner_files["steps/array/stephdr"]
    files["matrix/matrix"] += "STEP {\n    COL=3\n    NAME=CELL\n}\n"
    write_folder(files, folder / "card")
    return folder / "card"


@pytest.mark.parametrize("kind", ["xml", "odb"])
def test_boards_of_cells_on_a_panel_are_read_where_that_is_stated(kind: str, tmp_path: Path) -> None:
    file = nested(kind, tmp_path)
    alone = load_board(file)
    assert not alone.instances
    text = next(each.message for each in alone.findings if each.rule.id == "panel-boards")
    assert "repeats this board on a panel, its step array" in text
    (file if file.is_dir() else tmp_path).joinpath("columns.yaml").write_text("panel: apart\n")
    panel = load_board(file)
    assert len(panel.instances) == 4
    assert "panel-boards" not in {each.rule.id for each in panel.findings}
    chips = [each for each in panel.components if each.name.startswith("U1")]
    spots = {(round(each.outline.centroid.x, 2), round(each.outline.centroid.y, 2), each.side) for each in chips}
    assert spots == {(27.0, 17.0, "top"), (153.0, 123.0, "top"), (107.0, 65.0, "bottom"), (73.0, 75.0, "bottom")}


def test_steps_that_repeat_each_other_end(tmp_path: Path) -> None:
    text = nested("xml", tmp_path).read_text()
    circle = text.replace('<Step name="cell">', '<Step name="cell"><StepRepeat stepRef="array" x="0" y="0" nx="900"/>')
    (tmp_path / "card.xml").write_text(circle)
    (tmp_path / "columns.yaml").write_text("panel: apart\n")
    assert len(load_board(tmp_path / "card.xml").instances) in (2, 4)


def test_another_board_on_the_panel_is_named(tmp_path: Path) -> None:
    text = ipc2581(CARD, repeats=REPEATS)
    (tmp_path / "card.xml").write_text(
        text.replace('<StepRepeat stepRef="card"', '<StepRepeat stepRef="b" x="9" y="9"/><StepRepeat stepRef="card"', 1)
    )
    (tmp_path / "columns.yaml").write_text("panel: apart\n")
    notes = [each for each in load_board(tmp_path / "card.xml").findings if each.rule.id == "panel-boards"]
    assert [(each.severity, each.message[:9]) for each in notes] == [("warning", "The panel")]


def test_rails_and_tabs_are_material_of_the_panel(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(
        "panel:\n  board: tiny\n  nx: 2\n  pitch_mm: [33, 0]\n  rails_mm: {front: 5, back: 7}\n"
        "  tabs: [{at: [30, 8], size_mm: [3, 2]}]\n"
    )
    panel = load_board(tmp_path / "p.yaml")
    assert panel.outline.bounds == pytest.approx((0.0, -5.0, 63.0, 27.0), abs=0.01)
    assert panel.outline.intersection(box(30, 8, 33, 10)).area == pytest.approx(6.0, abs=0.05)
    assert panel.outline.intersection(box(30.1, 0.1, 32.9, 7.9)).area < 0.05


@pytest.mark.slow
def test_a_board_turned_over_twice_is_the_board() -> None:
    tiny = load_board(Path("two-sided"))
    twice = turned_over(turned_over(tiny))
    for one, other in zip(tiny.bodies, twice.bodies, strict=True):
        np.testing.assert_allclose(one.patches, other.patches, atol=1e-12)
        assert one.side == other.side
    once = turned_over(tiny)
    assert {each.name: each.side for each in once.components} == {
        each.name: "bottom" if each.side == "top" else "top" for each in tiny.components
    }


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("panel: {board: tiny, nx: 2}", "pitch_mm"),
        ("panel: {board: tiny, nx: 2, pitch_mm: [10, 10]}", "boards 1 and 2 of the panel overlap"),
        ("panel: {board: tiny, instances: [{skip: true}]}", "every board of the panel has a skip mark"),
        ("panel: {board: tiny, nx: 2000, pitch_mm: [40, 40]}", "nx"),
        ("panel: {board: tiny, instances: [{}, {turn_deg: 3}]}", "need a place"),
        ("panel: {board: tiny, what: 1}", "unknown key"),
        ("panel: {board: p.yaml}", "is a panel itself"),
        ("board: tiny", "panel: is missing"),
        ("panel: {board: none.tri}", "its board none.tri cannot be used: "),
        ("panel: {board: " + "a" * 300 + "}", "cannot be read: File name too long"),
        ("panel: {board: tiny, parts: " + "a" * 300 + "}", "its board tiny cannot be used: "),
        ("panel: {board: tiny, parts: none.csv}", "its board tiny cannot be used: "),
    ],
)
def test_mistakes_are_named(text: str, words: str, tmp_path: Path) -> None:
    assert words in refused(tmp_path, text)


def test_a_board_that_is_missing_is_named(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text("panel: {board: none.tri}")
    with pytest.raises(BoardError, match=r"none\.tri: no such file"):
        load_board(tmp_path / "p.yaml")
