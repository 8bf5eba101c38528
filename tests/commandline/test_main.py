"""The command as a person at a terminal and a script in a pipe meet it."""

import gzip
import json
import os
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command import contents, washboard

from boards.load import board_library, load_board
from commandline.arguments import complete_board, complete_recipe
from programs.load import load_program
from recipes.load import load_recipe, recipe_library
from rulesengine.planning import pipeline

ROOT = Path(__file__).parents[2]
PROCESS = f"'{sys.executable}' -c 'import sys; sys.argv[0] = \"washboard\"; from commandline.start import main; main()'"
CONFLICT = "recipe: masked\nextends: smt-aqueous\nmasks: [{avoid: [C1]}, {clean: [C1]}]\n"
EVERY = ("plan", "show", "classify", "demo", "board import", "board show", "board list")
RECIPES = ("recipe list", "recipe new", "recipe check", "recipe show", "recipe schema", "recipe keys")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder in which the command is run."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def shell(line: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which ``washboard`` is the real thing, in a process of its own."""
    start = f'washboard() {{ {PROCESS} "$@"; }}; '
    keep = {name: value for name, value in os.environ.items() if name != "COLUMNS"}
    environment = keep | {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"} | more
    return subprocess.run(["bash", "-c", start + line], env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("words", ["", "board", "recipe", *EVERY, *RECIPES])
def test_every_command_explains_itself(words: str) -> None:
    outcome = washboard(*words.split(), "--help", columns=100)
    assert (outcome.code, outcome.err) == (0, "")
    assert f"Usage: washboard {words}".rstrip() in outcome.out


def test_no_words_at_all_get_help() -> None:
    outcome = washboard(columns=100)
    assert (outcome.code, outcome.err) == (2, "")
    assert "Usage: washboard" in outcome.out


def test_version() -> None:
    assert washboard("--version").out.startswith("washboard 0.")


HEAVY = ["numpy", "scipy", "shapely", "trimesh", "toppra", "matplotlib", "numba", "ruamel"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "heavy"),
    [
        (["--help"], HEAVY),
        (["plan", "--help"], HEAVY),
        (["recipe", "check", "smt-aqueous"], ["numpy", "scipy", "shapely", "numba", "cleaning.exposure"]),
        (["classify", "tiny"], ["scipy.optimize", "numba", "trimesh", "toppra", "cleaning.exposure"]),
        (["plan", "tiny"], ["scipy.optimize", "trimesh", "cleaning.exposure"]),
    ],
)
def test_a_command_loads_nothing_heavy_that_it_does_not_use(words: list[str], heavy: list[str]) -> None:
    code = (
        "import sys\nfrom commandline.main import main\n"
        f"sys.argv = ['washboard', *{words!r}]\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        f"print('LOADED', sorted(set({heavy!r}) & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout.endswith("LOADED []\n")


def test_the_shell_is_offered_what_the_libraries_hold() -> None:
    assert complete_board("") == list(board_library())
    assert complete_board("tw") == ["two-sided"]
    assert complete_recipe("") == list(recipe_library())
    assert complete_recipe("no") == []
    offered = shell("washboard", _WASHBOARD_COMPLETE="complete_bash", COMP_WORDS="washboard plan --p", COMP_CWORD="2")
    assert offered.stdout.split() == ["--picture", "--parts"]


@pytest.mark.slow
def test_plan_writes_what_it_says_and_says_what_it_writes(place: Path) -> None:
    outcome = washboard("plan", "tiny", "rinse-only", "-o", "a.wash", "--picture", "a.png", "--report", "a.json")
    assert (outcome.code, outcome.err) == (0, "")
    assert outcome.out.startswith("tiny with rinse-only: ")
    assert outcome.out.endswith("Program  a.wash\nPicture  a.png\nReport   a.json\n")
    assert sorted(contents(place)) == ["a.json", "a.png", "a.wash"]
    totals = load_program(place / "a.wash").totals
    assert json.loads((place / "a.json").read_text())["totals"]["moves"] == totals.moves
    assert (place / "a.png").read_bytes().startswith(b"\x89PNG")


def test_plan_without_a_place_says_that_nothing_was_written(place: Path) -> None:
    outcome = washboard("plan", "tiny", "rinse-only")
    assert outcome.out.endswith("No program was written; -o OUT.wash writes it.\n")
    assert contents(place) == {}


@pytest.mark.slow
def test_a_program_is_shown_as_it_was_planned(place: Path) -> None:
    planned = washboard("plan", "tiny", "rinse-only", "-o", "a.wash").out.splitlines()
    shown = washboard("show", "a.wash", "--picture", "a.svg")
    assert (shown.code, shown.err) == (0, "")
    assert shown.out.splitlines()[:3] == planned[:3]  # the head line and the table
    for words in ("orifice ", "FUNCTION rinse, NOZZLE ring60 TOOL 1", "REPEAT 4 UNTIL", "Picture  a.svg"):
        assert words in shown.out
    assert (place / "a.svg").read_text().startswith("<?xml")


@pytest.mark.slow
def test_a_program_is_told_from_one_for_another_board(place: Path) -> None:
    washboard("plan", "tiny", "rinse-only", "-o", "a.wash")
    assert washboard("show", "a.wash", "--board", "tiny").err == ""
    (place / "tiny.tri").write_bytes(board_library()["tiny"].read_bytes().replace(b"QFN-16", b"QFN-17"))
    outcome = washboard("show", "a.wash", "--board", "tiny.tri", "--picture", "a.png")
    assert outcome.code == 0
    assert outcome.err.startswith("warning: tiny (sha256 ")
    assert (place / "a.png").exists()


@pytest.mark.slow
def test_board_commands(place: Path) -> None:
    (place / "parts.csv").write_text("Ref,Package,Pins\nR1,R_0603_1608Metric,2\nX9,SOT-23,3\n")
    assert washboard("board", "list").out.split() == list(board_library())
    card = washboard("board", "show", "two-sided", "--picture", "a.png")
    assert "and 3 more components; --all lists them" in card.out
    assert "\nQ1 " in washboard("board", "show", "two-sided", "--all").out
    assert washboard("board", "import", "tiny", "-o", "a.tri", "--parts", "parts.csv").code == 0
    assert "X9" in washboard("board", "show", "tiny", "--parts", "parts.csv").out
    assert [each.name for each in load_board(place / "a.tri").components] == ["C1", "J1", "R1", "R2", "U1"]
    washboard("board", "import", "a.tri", "-o", "b.tri.gz")
    assert gzip.decompress((place / "b.tri.gz").read_bytes()) == (place / "a.tri").read_bytes()


def test_classify_says_which_rule_took_each_component(place: Path) -> None:
    (place / "a.yaml").write_text(CONFLICT)
    outcome = washboard("classify", "tiny", "a.yaml")
    assert outcome.code == 0
    lines = outcome.out.splitlines()
    assert [line.split()[0] for line in lines[1:6]] == ["C1", "J1", "R1", "R2", "U1"]
    assert lines[5].rstrip().endswith("bottom_terminated  package QFN-16-1EP_3x3mm_P0.5mm is *QFN*")
    assert outcome.out.index("error mask-conflict") < outcome.out.index("info class-empty")


@pytest.mark.slow
def test_in_a_pipe_a_sentence_stays_on_one_line_and_nothing_is_coloured(place: Path) -> None:
    outcome = washboard("plan", "tiny")
    assert max(map(len, outcome.out.splitlines())) > 100
    assert "\x1b" not in outcome.out + outcome.err
    narrow = washboard("plan", "tiny", columns=80)
    assert max(map(len, narrow.out.splitlines())) <= 80


@pytest.mark.slow
def test_the_same_command_gives_the_same_bytes(place: Path) -> None:
    for folder in ("one", "two"):
        (place / folder).mkdir()
        out = f"{folder}/a"
        washboard(
            "plan", "tiny", "rinse-only", "-o", f"{out}.wash", "--report", f"{out}.json", "--picture", f"{out}.png"
        )
        washboard("show", f"{out}.wash", "--picture", f"{out}.svg")
        washboard("board", "import", "tiny", "-o", f"{out}.tri")
        washboard("board", "import", "tiny", "-o", f"{out}.tri.gz")
    assert len(contents(place / "one")) == 6
    assert contents(place / "one") == contents(place / "two")
    assert (place / "one" / "a.tri.gz").read_bytes()[4:8] == bytes(4)  # both formats could tell when they were made
    assert "<dc:date>" not in (place / "one" / "a.svg").read_text()


@pytest.mark.parametrize(
    "words",
    [("plan", "tiny"), ("check", "demo.wash", "ur5e-bench"), ("export", "demo.wash", "--cell", "ur5e-bench")],
    ids=lambda words: words[0],
)
def test_a_rule_that_does_not_exist_cannot_be_allowed(words: tuple[str, ...]) -> None:
    outcome = washboard(*words, "--allow", "mask-conflct")
    assert outcome.code == 2
    assert outcome.err.startswith(
        "error: --allow mask-conflct: no finding has this rule; the nearest are mask-conflict, "
    )


@pytest.mark.slow
def test_errors_forbid_the_export_until_they_are_allowed_by_name(place: Path) -> None:
    (place / "a.yaml").write_text(CONFLICT)
    (place / "x.wash").write_text("mine")
    words = ["plan", "tiny", "a.yaml", "-o", "x.wash", "--picture", "x.png", "--report", "x.json"]
    for more in ([], ["--allow", "not-served"]):
        outcome = washboard(*words, *more)
        assert outcome.code == 2
        assert outcome.err.startswith(
            "error: x.wash: not written: 1 finding of severity error forbids it. First mask-con"
        )
        assert "--allow mask-conflict" in outcome.err
        assert "error mask-conflict" in outcome.out
        assert sorted(contents(place)) == ["a.yaml", "x.json", "x.wash"]
        assert (place / "x.wash").read_text() == "mine"
    assert json.loads((place / "x.json").read_text())["findings"][0]["rule"] == "mask-conflict"
    assert washboard(*words, "--allow", "mask-conflict").code == 0
    assert load_program(place / "x.wash").origin.recipe == "masked"


@pytest.mark.slow
def test_errors_do_not_forbid_looking(place: Path) -> None:
    (place / "a.yaml").write_text(CONFLICT)
    assert washboard("plan", "tiny", "a.yaml", "--picture", "x.png").code == 0
    assert (place / "x.png").exists()


def test_recipe_commands_print_for_a_file_of_ones_own(place: Path) -> None:
    assert washboard("recipe", "new", "-o", "mine.yaml").out.startswith(
        "mine.yaml: edit it, then run `washboard recipe"
    )
    assert washboard("recipe", "check", "mine.yaml").out.startswith("mine: can be used; 6 steps")
    assert washboard("recipe", "show", "mine.yaml", columns=100).out.startswith("mine  ")
    assert load_recipe(place / "mine.yaml").recipe == "mine"


@pytest.mark.parametrize(
    ("error", "code"), [(KeyboardInterrupt(), 130), (ZeroDivisionError("x"), 70), (MemoryError(), 2)]
)
def test_what_ends_a_plan_midway_leaves_everything_as_it_was(
    place: Path, monkeypatch: pytest.MonkeyPatch, error: BaseException, code: int
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.delenv("WASHBOARD_DEBUG", raising=False)
    monkeypatch.setattr(pipeline, "time_plan", fail)
    (place / "a.wash").write_text("mine")
    outcome = washboard("plan", "tiny", "-o", "a.wash", "--report", "a.json")
    assert (outcome.code, outcome.out) == (code, "")
    assert outcome.err.count("\n") == 1
    assert contents(place) == {"a.wash": b"mine"}


@pytest.mark.slow
def test_ctrl_c_ends_the_real_process_with_130(place: Path) -> None:
    ready = "import boards.understand, time; from rulesengine.planning import pipeline\n"
    wait = "def wait(*_):\n    print('now', flush=True); time.sleep(60)\npipeline.time_plan = wait\n"
    code = f"{ready}{wait}from commandline.start import main; main()"
    words = ["plan", "tiny", "-o", str(place / "a.wash")]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "now\n"
    process.send_signal(signal.SIGINT)
    assert process.communicate()[1] == "error: interrupted; nothing was written\n"
    assert process.returncode == 130
    assert contents(place) == {}


@pytest.mark.slow
def test_a_reader_that_stops_early_is_no_error() -> None:
    for command in ("board show tiny", "--help"):
        run = shell(f"washboard {command} | head -1")
        assert run.stdout.count("\n") == 1
        assert run.stderr == ""


@pytest.mark.slow
def test_streams_that_are_closed_or_full(place: Path) -> None:
    assert shell("washboard recipe show >&-").returncode == 0
    assert shell("washboard show none.wash 2>&-").returncode == 2
    full = shell("washboard board list > /dev/full")
    assert (full.returncode, full.stderr) == (2, "error: stdout: No space left on device\n")
    for command, code in (("show none.wash", 2), ("show --none", 2), ("board list", 0)):
        assert shell(f"washboard {command} 2> /dev/full").returncode == code
    gone = shell("mkdir gone; cd gone; rmdir ../gone; washboard plan none.tri -o x.wash")
    assert (gone.returncode, gone.stderr) == (2, "error: the current folder: No such file or directory\n")


@pytest.mark.slow
def test_a_terminal_that_knows_only_ascii(place: Path) -> None:
    plain = {"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    run = shell("washboard recipe show; washboard --help; washboard board show größe.tri", **plain)
    assert "?C" in run.stdout
    assert "Usage: washboard" in run.stdout
    assert run.stdout.isascii()
    assert run.stderr.startswith("error: gr")
    assert run.stderr.endswith("e.tri: no such file; give the path of a board file\n")
    assert run.returncode == 2


@pytest.mark.slow
def test_progress_shows_on_a_terminal_only(place: Path) -> None:
    (place / "run.sh").write_text(f"stty cols 100\n{PROCESS} plan tiny rinse-only\n")
    run = shell("script -qec 'bash run.sh' /dev/null < /dev/null")
    if run.returncode == 127:
        pytest.skip("this machine has no script(1)")
    assert "reading tiny.tri" in run.stdout
    assert "planning rinse" in run.stdout
    assert run.stdout.index("planning rinse") < run.stdout.index("spraying; ")
    assert washboard("plan", "tiny", "rinse-only").err == ""


def test_memory_that_is_freed_goes_back_to_the_system():
    """Ten arrays of 30 MB each, of which every second is freed: the heap would keep all of them."""
    freed = (
        "from commandline.process import return_memory; return_memory(); import numpy as np\n"
        "resident = lambda: int(open('/proc/self/statm').read().split()[1]) * 4096\n"
        "np.ones(4_000_000); kept = [np.ones(3_750_000) for _ in range(10)]; full = resident()\n"
        "kept[::2] = [None] * 5; print(full - resident())"
    )
    given_back = int(subprocess.run([sys.executable, "-c", freed], capture_output=True, check=True).stdout)
    assert given_back >= 5 * 29_000_000


@pytest.mark.slow
def test_a_line_in_another_encoding_does_not_end_the_listening(place: Path) -> None:
    """As of a terminal in Latin 1: a stop that is typed after it is still heard."""
    words = [*shlex.split(PROCESS), "controller", "simulate", "gantry", "--link", "modbus", "--port", "0"]
    strict = os.environ | {"PYTHONIOENCODING": "utf-8:strict", "PYTHONPATH": str(ROOT)}
    pipe = subprocess.PIPE
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe, env=strict) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        process.stdin.write(b"\xe4\nx\n")
        process.stdin.flush()
        answers = [process.stderr.readline() for _ in range(2)]
        process.kill()
    assert all(each.startswith(b"give an input and its state") for each in answers)
