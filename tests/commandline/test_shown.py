"""What the commands print, write and draw on each kind of workpiece, kept as files to be reviewed when it changes."""

from collections.abc import Callable
from pathlib import Path
from shutil import copyfile

import pytest
from each_workpiece import FEW_PLACES, RECIPES, SOURCES, make_inputs, run_in
from shown import describe_pictures, shown

BOTH = "smt-aqueous"
"""Recipe with all that can be on both sides: wash, rinse and dry, with every path class"""


_PAGE = {"board": ("--html", "x.html"), "part": ("--html", "x.html", "--json", "x.json")}
DATA = Path(__file__).parents[1] / "boards" / "data"
BOARD_FILES = sorted(file.name for file in DATA.rglob("*.*") if file.suffix not in (".csv", ".emp"))
SAMPLES = ("radio-stick", "sensor-hub", "smt-demo")
LONG = ("analyse-two-sided", "check-joints", "check-arm", "place-board", "place-part", "plan-hood",
        "plan-smt-demo", "tune")  # fmt: skip


def commands() -> dict[str, tuple[str, ...]]:
    found: dict[str, tuple[str, ...]] = {}
    for kind, source in SOURCES.items():
        program, recipe = f"{kind}.wash", RECIPES[kind]
        found |= {
            f"plan-{kind}": ("plan", source, recipe, "-o", "x.wash", "--report", "x.json", "--picture", "x.svg"),
            f"show-{kind}": ("show", program),
            f"check-{kind}": ("check", program, "ur5e-bench", "--report", "x.json"),
            f"analyse-{kind}": ("analyse", program, source, *_PAGE.get(kind, ("--json", "x.json"))),
            f"compare-{kind}": ("compare", source, recipe, recipe.replace(".", "-2."), "--html", "x.html"),
            f"level-{kind}": ("level", source, recipe, "--output", "x.wash"),
        }
    found |= {
        "plan-two-sided": ("plan", "two-sided", BOTH, "--report", "x.json", "--picture", "x.png"),
        "analyse-two-sided": ("analyse", "both.wash", "--json", "x.json", "--html", "x.html"),
        "analyse-radial": ("analyse", "coat.wash", "small.tri", "--verify", "C1", "--json", "x.json"),
        "check-joints": ("check", "both.wash", "gantry", "--report", "x.svg"),
        "capability": ("analyse", "board.wash", "small.tri", "--capability", "--verify", "U1", "--json", "x.json"),
        **{f"import-{Path(name).stem}": ("board", "import", name, "-o", "x.tri") for name in BOARD_FILES},
        "import-parts": ("board", "import", "gerber.zip", "--parts", "pos.csv", "-o", "x.tri"),
        **{f"plan-{name}": ("plan", name, BOTH, "-o", "x.wash", "--report", "x.json") for name in SAMPLES},
        "plan-hood": ("plan", "hood", "part-slices", "-o", "x.wash", "--report", "x.json"),
        "check-arm": ("check", "both.wash", "kr6-bench", "--report", "x.json"),
        "classify": ("classify", "small.tri", "brief.yaml"),
        "bath": ("bath", "board.wash", "small.tri", "--boards", "1,50", "--json", "x.json"),
        "results": ("results", "board.wash", "measured.csv", "small.tri", "--json", "x.json"),
        "board-show": ("board", "show", "small.tri", "--picture", "x.svg"),
        "board-show-panel": ("board", "show", "two.yaml"),
        "part-show": ("part", "show", "plate.yaml", "--recipe", "faces.yaml", "--picture", "x.svg"),
        "part-show-cloud": ("part", "show", "points.xyz", "--recipe", "faces.yaml"),
        "cell-show": ("cell", "show", "ur5e-bench", "--board", "small.tri"),
        "place-board": ("cell", "place", "board.wash", "ur5e-bench", "--board", "small.tri", "--report", "x.html"),
        "place-part": ("cell", "place", "plate.yaml", "ur5e-bench", "--map", "--report", "x.svg"),
        "spacing": ("spacing", "coat.yaml", "fan", "--film-um", "20"),
        "ring": ("calibrate", "ring", "ring.csv"),
        "pattern": ("calibrate", "pattern", "pattern.csv"),
        "gap": ("calibrate", "gap", "coupons.csv"),
        "recipe": ("recipe", "show", "brief.yaml"),
        "parameters": ("parameters", "show", "default"),
        "tune": ("tune", "small.tri", "brief.yaml", "--analyses", "3", "-o", "x.yaml", "--picture", "x.svg"),
    }
    return found


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = make_inputs(tmp_path_factory.mktemp("shown"))
    for name, words in {"both": ("two-sided", BOTH), "coat": ("small.tri", "coat.yaml")}.items():
        outcome, files = run_in(
            tmp_path_factory.mktemp(name) / "run", folder, ("plan", *words, "-o", f"{name}.wash"), 1
        )
        assert outcome.code == 0, outcome.err
        (folder / f"{name}.wash").write_bytes(files[f"{name}.wash"])
    for file in (*DATA.glob("*.*"), *DATA.glob("*/*.*")):
        copyfile(file, folder / file.name)
    return folder


@pytest.mark.shown
@pytest.mark.parametrize("name", [pytest.param(each, marks=[pytest.mark.slow] * (each in LONG)) for each in commands()])
def test_what_is_shown_is_what_was_reviewed(
    name: str, inputs: Path, tmp_path: Path, golden: Callable[[str, str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    describe_pictures(monkeypatch)
    outcome, files = run_in(tmp_path / "run", inputs, commands()[name], FEW_PLACES)
    assert outcome.code in (0, 1, 2), outcome.err
    golden(f"shown/{name}.txt", shown(outcome, files, tmp_path / "run"))
