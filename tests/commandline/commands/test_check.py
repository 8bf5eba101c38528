import dataclasses
import gzip
import json
import re
import shlex
from pathlib import Path

import pytest
import trimesh
from command import contents, washboard
from hostile_cells import hostile_text
from tracked import line_program

import recipes
from boards.errors import BoardError
from programs import native
from programs.load import load_program
from robotcell.cell.load import cell_library
from washboard.inputs import find_workpiece


@pytest.fixture
def program(tmp_path: Path) -> Path:
    assert washboard("plan", "tiny", "rinse-only", "-o", tmp_path / "tiny.wash").code == 0
    return tmp_path / "tiny.wash"


@pytest.mark.slow
def test_a_program_that_can_be_done(program: Path, tmp_path: Path) -> None:
    done = washboard("check", program, "ur5e-bench", "--report", tmp_path / "r.json", "-o", tmp_path / "robot.wash")
    assert done.code == 0, done.err
    assert "can be done" in done.out
    assert "board-not-checked" not in done.out  # the sample was found by its name and fingerprint
    told = json.loads((tmp_path / "r.json").read_text())
    assert told["possible"]
    assert len(told["joints"]) == 6
    assert told["done"]["duration_s"] >= told["requested"]["duration_s"]
    for joint in told["joints"]:
        assert joint["lowest_deg"] <= joint["from_deg"] <= joint["to_deg"] <= joint["highest_deg"]
        assert joint["greatest_speed_deg_s"] <= 1.01 * joint["speed_limit_deg_s"]
    robot = load_program(tmp_path / "robot.wash")
    assert robot.totals.duration_s == pytest.approx(told["done"]["duration_s"], abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["far", "long-tool"])
def test_the_printed_command_applies_the_remedy_and_the_check_passes(
    program: Path, tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("my cell.yaml").write_text(hostile_text("ur5e-bench", kind))
    refused = washboard("check", program, "my cell.yaml", columns=80)  # a command is not broken into lines
    assert refused.code == 1
    lines = refused.out.splitlines()
    *described, command = (line.strip() for line in lines[lines.index("Remedy:") + 1 :])
    assert described
    assert all(line.startswith("my cell.yaml:") and " -> " in line for line in described)
    words = shlex.split(command)
    assert words[:4] == ["washboard", "cell", "edit", "my cell.yaml"]
    done = washboard(*words[1:])
    assert (done.code, done.err) == (0, "")
    assert done.out.splitlines()[:-1] == described
    assert washboard("check", program, "my cell.yaml").code == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changed", "message", "edit"),
    [
        pytest.param(
            ("kind: box, size_mm: [1100, 900, 40]", "kind: mesh, file: no.stl"),
            r"my cell\.yaml:\d+: fixtures\.table\.file: .*no\.stl: no such file; give the path of a mesh",
            "fixtures.table.file: table.stl",
            id="a mesh",
        ),
        pytest.param(
            ("\n  1:\n    name: cone\n", "\n  3:\n    name: cone\n"),
            r"the program needs tool 1 \(nozzle ring60, .*\), and cell ur5e-bench has 2, 3\. Add the tool to the cell",
            "tools.1: {name: cone, tcp: {xyz_mm: [0, 0, 180]}}",
            id="a tool",
        ),
    ],
)
def test_what_is_missing_is_named_and_the_check_passes_once_it_is_there(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: tuple[str, str], message: str, edit: str
) -> None:
    monkeypatch.chdir(tmp_path)
    text = cell_library()["ur5e-bench"].read_text()
    assert text.count(changed[0]) == 1
    Path("my cell.yaml").write_text(text.replace(*changed))
    refused = washboard("check", program, "my cell.yaml")
    assert refused.code == 2
    assert re.search(message, refused.err.replace("\n", " "))
    trimesh.creation.box((1100.0, 900.0, 40.0)).export(tmp_path / "table.stl")
    assert washboard("cell", "edit", "my cell.yaml", edit, "-o", "my cell.yaml").code == 0
    assert washboard("check", program, "my cell.yaml").code == 0


@pytest.mark.slow
def test_the_same_check_gives_the_same_bytes(program: Path, tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        files = (f"--report={tmp_path / name / 'r.json'}", f"--report={tmp_path / name / 'j.svg'}")
        assert washboard("check", program, "kr6-bench", *files).code == 0
    assert contents(tmp_path / "one") == contents(tmp_path / "two")


@pytest.mark.slow
def test_what_cannot_be_done_ends_with_one_and_says_why(program: Path, tmp_path: Path) -> None:
    cell = tmp_path / "far.yaml"
    text = (Path(recipes.__file__).parent.parent / "robotcell/library/cells/ur5e-bench.yaml").read_text()
    assert "xyz_mm: [400, -50, 150]" in text
    cell.write_text(text.replace("xyz_mm: [400, -50, 150]", "xyz_mm: [1400, -50, 150]"))
    refused = washboard("check", program, cell, "--report", tmp_path / "r.json", "--report", tmp_path / "j.png")
    assert refused.code == 1
    assert "cannot be done" in refused.out
    assert "out-of-reach" in refused.out
    assert "board moved by -" in refused.out
    assert not (tmp_path / "j.png").exists()
    assert not json.loads((tmp_path / "r.json").read_text())["possible"]
    assert "board-out-of-reach" in refused.out  # what the cell's own check says
    allowed = ["--allow", "out-of-reach", "--allow", "board-out-of-reach"]
    assert washboard("check", program, cell, *allowed).code == 0


def test_a_missing_cell_or_program_is_one_line(tmp_path: Path, program: Path) -> None:
    for words in ((tmp_path / "no.wash", "ur5e-bench"), (program, "ur5x-bench")):
        refused = washboard("check", *words)
        assert refused.code == 2
        assert refused.err.startswith("error: ")
        assert refused.err.count("\n") == 1


def test_the_board_is_found_beside_the_program(program: Path, tmp_path: Path) -> None:
    loaded = load_program(program)
    board = find_workpiece(loaded, program)
    assert board is not None
    assert board.sha256 == loaded.origin.board_sha256
    other = dataclasses.replace(loaded, origin=dataclasses.replace(loaded.origin, board="mine"))
    assert find_workpiece(other, program) is None
    from boards.load import board_library

    (tmp_path / "mine.tri").write_bytes(board_library()["tiny"].read_bytes())
    assert find_workpiece(other, program) is not None


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mine.tri", "mine.kicad_pcb", "mine.obj", "mine.yaml"])
def test_a_board_beside_the_program_that_cannot_be_read_is_named(program: Path, tmp_path: Path, name: str) -> None:
    loaded = load_program(program)
    other = dataclasses.replace(loaded, origin=dataclasses.replace(loaded.origin, board="mine"))
    (tmp_path / name).write_bytes(b"nothing of the kind")
    with pytest.raises(BoardError, match=rf"'mine', on which .* was not found: .*{re.escape(name)}.*remove that file"):
        find_workpiece(other, program)
    (tmp_path / "mine.ply").write_bytes(b"ply")
    from boards.load import board_library

    good = "mine.tri.gz" if name == "mine.tri" else "mine.tri"
    content = board_library()["tiny"].read_bytes()
    (tmp_path / good).write_bytes(gzip.compress(content) if good.endswith(".gz") else content)
    assert find_workpiece(other, program) is not None


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        ("check", "kr6-bench"),
        ("show", "--picture", "x.png"),
        ("analyse",),
        ("export", "--cell", "kr6-bench", "-o", "x"),
        ("operate", "--cell", "gantry", "--dry"),
    ],
)
def test_every_command_names_the_board_that_it_could_not_read(
    program: Path, tmp_path: Path, words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    text = program.read_text()
    board = load_program(program).origin.board
    Path("own.wash").write_text(text.replace(f" {board} ", " mine ", 1))
    assert load_program(Path("own.wash")).origin.board == "mine"
    Path("mine.tri").write_text("nothing of the kind")
    refused = washboard(words[0], "own.wash", *words[1:])
    assert refused.code == 2
    assert "mine.tri" in refused.err
    assert refused.err.count("\n") == 1


def test_another_board_is_not_taken_for_the_one_that_was_planned(program: Path) -> None:
    loaded = load_program(program)
    changed = dataclasses.replace(loaded, origin=dataclasses.replace(loaded.origin, board_sha256="00"))
    assert find_workpiece(changed, program) is None


@pytest.mark.slow
def test_a_board_that_is_not_at_hand_is_a_finding(tmp_path: Path) -> None:
    path = tmp_path / "line.wash"
    path.write_text(native.render(line_program()))
    done = washboard("check", path, "ur5e-bench")
    assert done.code == 0, done.err
    assert "board-not-checked" in done.out


@pytest.mark.slow
def test_pictures_are_drawn_or_refused_early(program: Path, tmp_path: Path) -> None:
    assert washboard("check", program, "gantry", "--report", tmp_path / "j.png").code == 0
    assert (tmp_path / "j.png").read_bytes().startswith(b"\x89PNG")
    refused = washboard("check", program, "gantry", "--report", tmp_path / "j.txt")
    assert refused.code == 2
    assert "is written as .png or .svg" in refused.err
