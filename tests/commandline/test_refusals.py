"""Bad input through the whole command: one error that says what, where, what to do; nothing written, nothing lost."""

import os
import random
from collections.abc import Callable
from pathlib import Path

import pytest
from command import contents, washboard

from boards.load import board_library

JUNK = random.Random(7).randbytes(4000)
RECIPE = "recipe: mine\nextends: smt-aqueous\n"
PROGRAM = (
    "WASHBOARD 1\nUNITS mm s\nFRAME board\nBOARD tiny sha256 00\nRECIPE mine sha256 00\n"
    "TOTALS duration_s 0.0000 spray_s 0.0000 travel_mm 0.000 moves 1\nBEGIN\n"
    "0.0000 MOVE 0.000 0.000 110.000 0.0000000 1.0000000 0.0000000 0.0000000 0.000 ; a\nEND\n"
)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in which the command is run."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def refused(place: Path, *words: str | Path) -> str:
    """Run a command that has to be refused in one line, with every file as it was; return that line."""
    before = contents(place)
    outcome = washboard(*words)
    assert outcome.code == 2, outcome
    assert outcome.err.startswith("error: ")
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.endswith("\n")
    assert len(outcome.err) < 1100
    assert "Traceback" not in outcome.out + outcome.err
    assert contents(place) == before
    return outcome.err.removeprefix("error: ").rstrip("\n")


def tiny() -> bytes:
    return board_library()["tiny"].read_bytes()


BOARDS: dict[str, tuple[bytes, str]] = {
    "empty.tri": (b"", "is empty"),
    "empty.step": (b"", "is not a STEP file"),
    "junk.tri": (JUNK, "Save the board as UTF-8"),
    "junk.tri.gz": (JUNK, "damaged gzip file"),
    "junk.step": (JUNK, "Export it as STEP"),
    "junk.glb": (JUNK, "Export it again"),
    "junk.stl": (JUNK, "Export or copy it again"),
    "junk.obj": (JUNK, "Export"),
    "junk.ply": (JUNK, "Export it again"),
    "junk.emn": (JUNK, "Export it again as IDF"),
    "junk.kicad_pcb": (JUNK, "Save the board in KiCad again"),
    "board.pdf": (JUNK, "Known are .tri,"),
    "board": (JUNK, "Known are .tri,"),
    "magic.tri": (tiny().replace(b"board-tri 1", b"bored-tri 1"), "expected 'board-tri 1' first"),
    "short.tri": (tiny()[:5000], "short.tri:"),
    "nan.tri": (tiny().replace(b"0.0000 20.0000", b"nan 20.0000", 1), "nan.tri:6: "),
    "inf.tri": (tiny().replace(b"0.0000 20.0000", b"inf 20.0000", 1), "inf.tri:6: "),
    "two.tri": (tiny().replace(b"role=component", b"role=board", 1), "a second board"),
    "role.tri": (tiny().replace(b"role=component", b"role=compnent", 1), "compnent"),
}


@pytest.mark.parametrize("name", BOARDS)
def test_board_files_that_cannot_be_used(place: Path, name: str) -> None:
    content, said = BOARDS[name]
    (place / name).write_bytes(content)
    for words in (["plan", name, "-o", "x.wash"], ["board", "show", name], ["board", "import", name, "-o", "x.tri"]):
        error = refused(place, *words)
        assert error.startswith(name)
        assert said in error


def test_boards_that_are_not_there(place: Path) -> None:
    (place / "folder.tri").mkdir()
    assert refused(place, "plan", "none.step") == "none.step: no such file; give the path of a board file"
    assert "no such file" in refused(place, "plan", "none.stl")
    assert "is a directory" in refused(place, "plan", "folder.tri")
    assert "Did you mean 'smt-demo'? The samples are: radio-stick, sensor-hub, smt-demo, tiny" in refused(
        place, "plan", "smt-dmo"
    )
    assert "Did you mean 'two-sided'?" in refused(place, "demo", "--board", "two-side")


SLOWLY = [pytest.param(name, marks=pytest.mark.slow) for name in ("a.tri", "a.step", "a.stl", "a.kicad_pcb", "a.csv")]


@pytest.mark.parametrize("name", ["a.wash", "a.yaml", *SLOWLY])
def test_huge_files_of_nothing_are_refused(place: Path, name: str) -> None:
    with (place / name).open("wb") as file:
        file.truncate(200_000_001)
    commands = {
        "a.wash": ["show", name],
        "a.yaml": ["recipe", "check", name],
        "a.csv": ["plan", "tiny", "--parts", name],
    }
    outcome = washboard(*commands.get(name, ["plan", name]))
    assert (outcome.code, outcome.out) == (2, "")
    assert outcome.err.startswith(f"error: {name}:")
    assert len(outcome.err) < 300
    assert list(place.iterdir()) == [place / name]


RECIPES = {
    "templates:\n  sweep: {sped_mm_s: 3}\n": "a.yaml:4: templates.sweep.sped_mm_s: unknown key; did you mean 'spe",
    "templates:\n  sweep:\n    speed_mm_s: fast\n": "a.yaml:5: templates.sweep.speed_mm_s: ",
    "templates:\n  sweep:\n    speed_mm_s: 130\n": "a.yaml:5: templates.sweep.speed_mm_s: ",
    "templates:\n  around: {passes: {smal: 3, default: 1}}\n": "a.yaml:4: templates.around.passes.smal: ",
    "sequence: [{function: clen, nozzle: ring60, paths: [sweep]}]\n": "a.yaml:3: sequence[0].function: ",
    "functions: [\n": "a.yaml:",
    "nozzles: {ring60: {flow_lpm: .nan}}\n": "a.yaml:3: nozzles.ring60.flow_lpm: ",
}


@pytest.mark.parametrize("text", RECIPES)
def test_recipes_that_cannot_be_used(place: Path, text: str) -> None:
    (place / "a.yaml").write_text(RECIPE + text)
    for words in (
        ["plan", "tiny", "a.yaml", "-o", "x.wash"],
        ["recipe", "check", "a.yaml"],
        ["classify", "tiny", "a.yaml"],
    ):
        assert refused(place, *words).startswith(RECIPES[text])


def test_recipes_that_are_not_there(place: Path) -> None:
    (place / "empty.yaml").touch()
    (place / "junk.yaml").write_bytes(JUNK)
    assert "Did you mean 'smt-aqueous'?" in refused(place, "plan", "tiny", "smt-aquous")
    assert "`washboard recipe list`" in refused(place, "plan", "tiny", "none.yaml")
    assert "is a directory" in refused(place, "plan", "tiny", ".")
    assert "the file is empty" in refused(place, "recipe", "check", "empty.yaml")
    assert refused(place, "recipe", "show", "junk.yaml").startswith("junk.yaml:")


def test_a_component_that_no_class_takes(place: Path) -> None:
    base = (Path(__file__).parents[2] / "recipes" / "library" / "smt-aqueous.yaml").read_text("utf-8")
    (place / "a.yaml").write_text(base.replace("\n  large: {}", "\n  large: {area_mm2: {min: 1000}}"))
    error = refused(place, "plan", "tiny", "a.yaml", "-o", "x.wash")
    assert "J1" in error
    assert "class" in error


TABLES = {
    "empty.csv": (b"", "no line names the columns"),
    "junk.csv": (JUNK, "Export it as CSV"),
    "words.csv": (b"some,words\n1,2\n", "words.csv"),
    "pins.csv": (b"Ref,Package,Pins\nU1,QFN-16,many\n", "pins.csv:2: "),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", TABLES)
def test_parts_tables_that_cannot_be_used(place: Path, name: str) -> None:
    content, said = TABLES[name]
    (place / name).write_bytes(content)
    error = refused(place, "plan", "tiny", "--parts", name, "-o", "x.wash")
    assert error.startswith(name)
    assert said in error


def test_parts_tables_that_are_not_there(place: Path) -> None:
    assert refused(place, "board", "show", "tiny", "--parts", "none.csv").startswith("none.csv: no such file")
    assert "is a directory" in refused(place, "board", "show", "tiny", "--parts", ".")


PROGRAMS = {
    "empty.wash": (b"", "empty.wash:1: this is not a Washboard program"),
    "junk.wash": (JUNK, "junk.wash:"),
    "two.wash": (PROGRAM.replace("1", "2", 1).encode(), "only 'WASHBOARD 1' can be read. Plan the board again."),
    "cut.wash": (PROGRAM[:-4].encode(), "without END"),
    "nan.wash": (PROGRAM.replace("BEGIN\n", "BEGIN\nnan SPRAY ON ; a\n").encode(), "nan.wash:8: "),
    "word.wash": (PROGRAM.replace("BEGIN\n", "BEGIN\n0.0000 SPRY ON ; a\n").encode(), "word.wash:8: "),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_that_cannot_be_read(place: Path, name: str) -> None:
    content, said = PROGRAMS[name]
    (place / name).write_bytes(content)
    error = refused(place, "show", name, "--picture", "x.png")
    assert error.startswith(name)
    assert said in error


def test_a_program_whose_board_is_not_known_cannot_be_drawn(place: Path) -> None:
    (place / "a.wash").write_text(PROGRAM.replace("tiny", "mine"))
    assert "name its board with --board" in refused(place, "show", "a.wash", "--picture", "x.png")
    assert "no program in a robot's language" in refused(place, "show", ".")
    assert "no such file" in refused(place, "show", "none.wash")


def _read_only(folder: Path) -> None:
    folder.chmod(0o500)
    if os.access(folder, os.W_OK):
        pytest.skip("this user may write everywhere")


PLACES: dict[str, tuple[Callable[[Path], None], list[str], str]] = {
    "folder": (lambda place: (place / "d.wash").mkdir(), ["-o", "d.wash"], "d.wash: cannot be written: it is a folder"),
    "nowhere": (lambda _: None, ["-o", "no/x.wash"], "there is no folder no. Make it"),
    "read-only": (_read_only, ["-o", "x.wash"], "permission denied"),
    "input": (lambda place: (place / "a.wash").write_text(RECIPE), ["a.wash", "-o", "a.wash"], "read by this command"),
    "link": (
        lambda place: (place / "l.wash").symlink_to("a.wash"),
        ["./a.wash", "-o", "l.wash"],
        "read by this command",
    ),
    "board": (lambda place: (place / "cad.stl").touch(), ["-o", "cad.stl"], "its name is that of a board"),
    "report": (lambda _: None, ["-o", "x.json"], "its name is that of a report"),
    "twice": (lambda _: None, ["-o", "x.wash", "--report", "./x.wash"], "it is to be written twice"),
    "jpg": (lambda _: None, ["--picture", "x.jpg"], "x.jpg: a picture is written as .png or .svg"),
    "late": (lambda _: None, ["-o", "x.wash", "--picture", "no/x.png"], "there is no folder no"),
    "zero": (lambda _: None, ["-o", "a\0.wash"], "null byte"),
}


@pytest.mark.parametrize("name", PLACES)
def test_places_that_cannot_be_meant(place: Path, name: str) -> None:
    prepare, words, said = PLACES[name]
    prepare(place)
    try:
        assert said in refused(place, "plan", "tiny", *words)
    finally:
        place.chmod(0o700)


def test_other_commands_mind_their_places_too(place: Path) -> None:
    (place / "a.tri").write_bytes(tiny())
    (place / "a.yaml").write_text(RECIPE)
    assert "read by this command" in refused(place, "board", "import", "a.tri", "-o", "a.tri")
    assert ".tri or .tri.gz" in refused(place, "board", "import", "a.tri", "-o", "a.step")
    assert "a picture is written" in refused(place, "board", "show", "a.tri", "--picture", "b.tri")
    assert "overwrite it with --force" in refused(place, "recipe", "new", "-o", "a.yaml")
    assert "read by this command" in refused(place, "recipe", "new", "./a.yaml", "-o", "a.yaml", "--force")
    assert "a.yaml is not a folder" in refused(place, "demo", "--into", "a.yaml")
    assert "a.yaml is not a folder" in refused(place, "demo", "--into", "a.yaml/in")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["plan"], "Missing argument 'BOARD'. `washboard plan --help` shows how it is used."),
        (["plam"], "No such command 'plam'. Did you mean 'plan'?"),
        (["plan", "tiny", "--outptu", "x"], "--outptu"),
        (["plan", "tiny", "smt-aqueous", "more"], "(more)"),
        (["plan", "tiny", "-o"], "'-o' requires an argument"),
        (["board", "shwo"], "`washboard board --help`"),
    ],
)
def test_misused_commands(place: Path, words: list[str], said: str) -> None:
    assert said in refused(place, *words)
