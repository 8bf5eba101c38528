"""``washboard cell``, as a person at a terminal uses it."""

import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from command import washboard
from library_cells import CELLS
from PIL import Image
from small_cells import CELL
from typer.testing import CliRunner, Result

from boards.load import load_board
from commandline.arguments import complete_cell
from commandline.nouns.cell import app
from programs.load import load_program
from robotcell.cell.cell import TableBounds
from robotcell.cell.load import cell_keys, cell_library, cell_schema, hold_board, read_cell
from robotcell.cell.robot_library import robot_library
from robotcell.motion.sampled_path import sample_path
from robotcell.placement.placement_map import MapGrid
from robotcell.placement.reachability import configurations_at, measure
from robotcell.search_placement import targets_of
from robotcell.track import terms_of


def call(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "160"})


@pytest.mark.slow
def test_list_names_each_cell_and_each_robot_with_what_it_is() -> None:
    result = call("list")
    assert result.exit_code == 0
    for name in cell_library():
        assert f"{read_cell(name).spec.description}\n" in result.stdout
    for name in (*cell_library(), *robot_library()):
        assert f"  {name} " in result.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", CELLS)
def test_show_says_what_a_person_compares_with_the_real_cell(name: str) -> None:
    result = call("show", name, "--board", "tiny")
    assert (result.exit_code, result.stderr) == (0, "")
    for word in ("robot base", "tool 1 cone at home", "jet down", "top up", "board's back right corner", "holder"):
        assert word in result.stdout
    for word in ("FUNCTION clean", "SPRAY with ring60", "UNTIL resistivity_mohm_cm"):
        assert word in result.stdout
    found = re.findall(r"^ *(?:error|warning|note|info) +([a-z-]+)", result.stdout, re.MULTILINE)
    assert found == ["board-not-held"]  # it is small, and held by its corner


def test_show_has_the_home_as_the_controller_counts_it_where_that_differs() -> None:
    shown = call("show", "lrmate-bench").stdout
    assert "lrmate-200id, FANUC" in shown
    (row,) = (line.split() for line in shown.splitlines() if line.split()[:2] == ["J3", "deg"])
    home = read_cell("lrmate-bench").spec.home_deg_mm
    assert [float(row[4]), float(row[7])] == pytest.approx([home[2], home[2] - home[1]])
    assert "on its controller" not in call("show", "kr6-bench").stdout


def test_show_tells_mistakes_by_name(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("[400, -50, 150]}", "[400, 50, 150], rpy_deg: [180, 0, 0]}"), "utf-8")
    result = call("show", file)
    assert result.exit_code == 0
    assert "board-upside-down" in result.stdout
    assert "top down" in result.stdout


def test_a_cell_that_cannot_be_used_is_one_line_on_stderr(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(CELL.replace("robot: ur5e", "robot: ur5ee"), "utf-8")
    done = washboard("cell", "show", file)
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"error: {file}:2: robot: no robot 'ur5ee'")


def test_schema_and_keys_are_printed_as_they_are() -> None:
    assert call("schema").stdout == cell_schema()
    assert call("keys").stdout == cell_keys()


def test_the_shell_completes_names_of_cells() -> None:
    assert complete_cell("ur5e") == ["ur5e-bench"]
    assert complete_cell("") == list(cell_library())


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("planned") / "tiny.wash"
    assert washboard("plan", "tiny", "rinse-only", "-o", path).code == 0
    return path


@pytest.mark.slow
def test_the_cell_is_written_with_the_board_elsewhere_and_all_else_as_it_was(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bounds = TableBounds((-0.7, 0.7), (-0.7, 0.7))
    monkeypatch.setattr("robotcell.placement.placement_map.MapGrid", lambda _: MapGrid(bounds, (5, 5, 2)))
    monkeypatch.setattr("robotcell.placement.optimise.MOST_EVALUATIONS", 130)
    output, reports = tmp_path / "moved.yaml", [tmp_path / f"place.{kind}" for kind in ("json", "html", "png", "glb")]
    words = [word for file in reports for word in ("--report", file)]
    done = washboard("cell", "place", program, "ur5e-bench", "-o", output, "--map", *words)
    assert (done.code, done.err) == (0, "")
    assert_reports_have_the_value_of_all_points(program, output, reports, done.out)
    for word in ("as it is", "best", "manipulability w", "holder", f"Written  {output}\n"):
        assert word in done.out
    old, new = cell_library()["ur5e-bench"].read_text("utf-8").splitlines(), output.read_text("utf-8").splitlines()
    changed = [(one, other) for one, other in zip(old, new, strict=True) if one != other]
    assert [one for one, _ in changed] == ["  pose: {xyz_mm: [400, -50, 150]}"]
    assert f"board:\n{changed[0][1]}\n" in done.out  # to paste
    hold = read_cell(output).spec.board
    assert hold.pose is not None
    assert hold.pose.xyz_mm[2] == 150
    assert washboard("check", program, output).code == 0


def assert_reports_have_the_value_of_all_points(program: Path, cell: Path, reports: list[Path], printed: str) -> None:
    """Terminal, data, page, sheet and scene; the value is measured anew at every point of the program."""
    data = json.loads(reports[0].read_text())
    assert (data["feasible"], data["failing"], np.shape(data["map"]["values"])) == (True, [], (5, 5, 2))
    loaded = hold_board(read_cell(cell), load_board(Path("tiny")))
    np.testing.assert_allclose(loaded.cell.T_cell_board, data["T_cell_board"], atol=1e-9)
    terms = terms_of(loaded)
    targets = targets_of(sample_path(load_program(program), loaded.cell, terms.round_nozzles, terms.placements))
    found = configurations_at(loaded.cell, loaded.cell.T_cell_board, targets, 1)
    w = measure(loaded.cell, found.q, targets.tool[found.target], "manipulability")
    mine = w[found.branch == data["score"]["branches"][0]]
    assert len(mine) == data["targets"] == len(targets.tool)
    assert mine.min() == pytest.approx(data["score"]["value"], abs=1e-6)
    node, beside = data["map"]["best_score"]["value"], data["map"]["refined"]["score"]["value"]
    assert 0.0 < node <= beside
    for text in (printed, reports[1].read_text()):
        for value in (mine.min(), node, beside):
            assert f"{value:.4f}" in text
    with Image.open(reports[2]) as sheet:
        assert sheet.width > 1000
    assert {"map", "robot", "tool", "workpiece", "worst point"} <= set(trimesh.load_scene(reports[3]).geometry)


@pytest.mark.slow
def test_a_board_out_of_reach_is_placed_over_its_own_file_where_that_is_named(program: Path, tmp_path: Path) -> None:
    cell = tmp_path / "far.yaml"
    text = CELL.replace("[400, -50, 150]}", "[1900, -50, 150]}  # far")
    cell.write_text(text, "utf-8")
    looked = washboard("cell", "place", program, cell, "--metric", "limits", "--of", "mean")
    assert looked.code == 0
    assert cell.read_text("utf-8") == text
    assert "0% reached" in looked.out
    assert "refused: board-out-of-reach" in looked.out
    assert washboard("cell", "place", program, cell, "--metric", "limits", "--of", "mean", "-o", cell).code == 0
    hold = read_cell(cell).spec.board
    assert hold.pose is not None
    assert math.hypot(*hold.pose.xyz_mm[:2]) < 1200
    assert " # far\n" in cell.read_text("utf-8")


@pytest.mark.slow
def test_a_cell_where_no_place_helps_ends_with_one_and_writes_nothing(program: Path, tmp_path: Path) -> None:
    cell = tmp_path / "stiff.yaml"
    limits = "".join(
        f"  {joint}: {{position_deg: [{home - 1}, {home + 1}]}}\n" for joint, home in (("elbow", 97), ("wrist_1", -93))
    )
    cell.write_text(CELL.replace("home_deg_mm", f"joints:\n{limits}home_deg_mm"), "utf-8")
    done = washboard("cell", "place", program, cell, "-o", tmp_path / "moved.yaml")
    assert done.code == 1
    assert "No place was found" in done.out
    assert not (tmp_path / "moved.yaml").exists()


@pytest.mark.slow
def test_a_board_that_lies_best_already_stays(program: Path, tmp_path: Path) -> None:
    done = washboard("cell", "place", program, "gantry", "-o", tmp_path / "same.yaml")
    assert done.code == 0
    assert "the board stays where it is" in done.out
    assert (tmp_path / "same.yaml").read_bytes() == cell_library()["gantry"].read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(("words", "mm"), [((), 50), (("--standoff", "0"), 0)])
def test_a_part_is_placed_for_the_standoff_that_is_shown(
    words: tuple[str, ...], mm: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("robotcell.placement.optimise.MOST_EVALUATIONS", 20)
    found = washboard("cell", "place", "f-bracket", "gantry", "--points", "4", *words)
    assert found.code in (0, 1), found.err
    assert f"4 points, orifice {mm} mm from the surface" in found.out


def test_what_cannot_be_is_one_line_before_the_search(program: Path, tmp_path: Path) -> None:
    cell = tmp_path / "meshes.yaml"
    cell.write_text(CELL.replace("kind: box, size_mm: [900, 900, 40]", "kind: mesh, file: table.stl"), "utf-8")
    corner = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 900 0 0\nvertex 0 900 0\nendloop\nendfacet\n"
    (tmp_path / "table.stl").write_text(f"solid table\n{corner}endsolid table\n", "utf-8")
    (tmp_path / "else").mkdir()
    refusals = {
        (cell, "-o", tmp_path / "else" / "moved.yaml"): f"write the new one into {tmp_path}",
        ("ur5e-bench", "-o", program): "it is read by this command",
        ("ur5x-bench",): "Did you mean",
        ("ur5e-bench", "--metric", "luck"): "luck",
    }
    for words, told in refusals.items():
        refused = washboard("cell", "place", program, *words)
        assert (refused.code, refused.out) == (2, "")
        assert refused.err.startswith("error: ")
        assert refused.err.count("\n") == 1
        assert told in refused.err


def test_edit_copies_a_library_cell_with_other_values_and_its_comments(tmp_path: Path) -> None:
    output = tmp_path / "mine.yaml"
    edits = ("board.pose.xyz_mm: [420, -50, 150]", "margin_mm: 12")
    done = washboard("cell", "edit", "ur5e-bench", *edits, "-o", output)
    assert (done.code, done.err) == (0, "")
    assert "board.pose.xyz_mm: [400, -50, 150] -> [420, -50, 150]" in done.out
    assert read_cell(output).spec.board.pose.xyz_mm == (420, -50, 150)
    before, after = cell_library()["ur5e-bench"].read_text().splitlines(), output.read_text().splitlines()
    assert [line for line in before if "#" in line] == [line for line in after if "#" in line]
    assert len(set(after) - set(before)) == 2


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        ("margin_mm: -3", "margin_mm"),
        ("bord.pose: 3", "bord"),
        ("tools[4]: 3", "nothing of this name"),
        ("no edit", "write KEY: VALUE"),
    ],
)
def test_edit_writes_nothing_that_is_no_cell(tmp_path: Path, edit: str, reason: str) -> None:
    refused = washboard("cell", "edit", "ur5e-bench", "margin_mm: 12", edit, "-o", tmp_path / "mine.yaml")
    assert refused.code == 2
    assert reason in refused.err
    assert "Traceback" not in refused.err
    assert "mine.yaml" not in refused.err
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_an_interview_lists_what_is_left_out_and_writes_answers(tmp_path: Path) -> None:
    asked = washboard("cell", "interview", "kr6-bench")
    assert asked.code == 0
    assert "tools.1.centre_mm: [0, 10, 75]" in asked.out
    assert "tools.1.mass_kg" not in asked.out  # which the cell states
    assert "Left out: the line cannot know." in asked.out
    output = tmp_path / "mine.yaml"
    answers = ("--answer", "tools.1.centre_mm: [0, 10, 75]", "--answer", "controller: {acceleration_mm_s2: 900}")
    answered = washboard("cell", "interview", "kr6-bench", *answers, "-o", output)
    assert answered.code == 0
    assert "centre_mm: [0, 10, 75]" in output.read_text()
    assert "tools.1.centre_mm: [0, 10, 75]\n  Where" not in answered.out
    left = [int(each.out.splitlines()[at].split()[0]) for each, at in ((asked, -1), (answered, -2))]
    assert left[1] == left[0] - 2


def test_each_example_of_an_interview_is_an_edit(tmp_path: Path) -> None:
    outputs = [
        f"io.outputs.{name}: {{kind: digital, number: {40 + at}}}"
        for at, name in enumerate(("doBusy", "doDone", "doFault", "doLamp"))
    ]
    inputs = ["io.inputs.diStart: {number: 42}"]
    asked = washboard("cell", "interview", "irb1200-bench")
    examples = [line for line in asked.out.splitlines()[:-1] if not line.startswith(" ")]
    assert len(examples) >= 8
    output = tmp_path / "mine.yaml"
    answers = [word for each in (*outputs, *inputs, *examples) for word in ("--answer", each)]
    answered = washboard("cell", "interview", "irb1200-bench", *answers, "-o", output)
    assert answered.code == 0, answered.err
    assert "Nothing is left out of what a program in ABB RAPID takes from a cell." in answered.out


def test_answers_without_a_file_are_refused() -> None:
    refused = washboard("cell", "interview", "kr6-bench", "--answer", "margin_mm: 12")
    assert refused.code == 2
    assert "--answer and -o OUT.yaml go together" in refused.err


def test_what_is_wrong_with_a_cell_is_located_in_the_file_that_is_there(tmp_path: Path) -> None:
    faulty = tmp_path / "faulty.yaml"
    faulty.write_text(cell_library()["gantry"].read_text("utf-8") + "\nmargin_mm: -360\n", "utf-8")
    (tmp_path / "deep").mkdir()
    for output in ("mine.yaml", "deep/mine.yaml"):
        refused = washboard("cell", "edit", faulty, "base.xyz_mm: [0, 0, 10]", "-o", tmp_path / output)
        assert refused.code == 2
        assert "faulty.yaml:" in refused.err
        assert "mine.yaml" not in refused.err
