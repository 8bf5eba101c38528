"""Fail, kill and interrupt commands at every system call on their files, and check what they leave.

    tools/inject_faults.py                             plan, analyse, export, tune, operate, the page, ...
    tools/inject_faults.py --only plan --fault ENOSPC --every 5
    tools/inject_faults.py --all --every 3             every command, and study with a worker of its own
    tools/inject_faults.py --moments 50                and 50 kills and 50 interrupts of each at any moment

Each run begins with other files in the place of the outputs. After it every output must be old or new, byte for byte
(of tuning also a whole recipe in between); after the next writing in the folder nothing else may be there, nor a
process of the run. What the system refuses must end with 2 and one line that names the file and the reason, or have
no effect; an interrupt with 130 and one line. A run is a fork of a process that has imported what the command needs.
"""

# ruff: noqa: E402
import argparse
import random
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support"), str(ROOT / "tools")]

from audited import STUDY, WORDS
from each_workpiece import RECIPES, SOURCES, write_inputs
from injection.calls import FAULTS
from injection.runs import command, points_of, prepare, run_point
from step_writer import StepWriter

EXPORT = ("export", "board.wash", "--cell", "kr6-bench", "--dialect", "kuka", "--board", "small.tri", "-o", "robot")
PROGRAM = ("plan", "small.tri", "brief.yaml", "-o", "board.wash")
FOLDER = "export #folder"
BOARDS = ROOT / "tests" / "boards" / "data"
FORMATS = {file.name: file for file in sorted((*BOARDS.glob("*.*"), *BOARDS.glob("exported/*.[!c]*")))}
"""A board in each format, single, packed and beside its tables."""
OTHERS = [each for each in SOURCES if each != "board"]
MADE = {"operate": "export", **{f"analyse #{each}": f"plan #{each}" for each in OTHERS}}
"""What makes the input of a command."""
CHOSEN = ("plan", "analyse", "export", FOLDER, "operate", "tune", "study", "board import", "part scan", "ui")


def _study() -> None:
    """Compute a study in this process: what it does to files is the same, and a cluster takes seconds to begin."""
    import washboard.studied

    compute = washboard.studied.study
    washboard.studied.study = lambda file, output, client, progress, **_: compute(file, output, None, progress)
    command(("study", *WORDS["study"]))()


def _page() -> None:
    """What the page saves, in a process that listens for signals as its server does."""
    from commandline.process import watch
    from commandline.start import _finish
    from robotcell.cell.cell_edits import CellEdit
    from specs import ending
    from specs.errors import JobError
    from specs.input_file import InputFile
    from webui.page.document import NamedCell, open_document, plan_change
    from webui.page.project import open_project, uploaded_table

    watch()
    ending.begin()
    code = 0
    try:
        project = open_project(Path.cwd())
        project.store("uploaded.tri", InputFile(Path("small.tri")).read())
        with uploaded_table("parts.csv", b"ref,height\n", "parts.csv", "a table of parts") as table:
            InputFile(table).read()
        document = open_document(project.recipe_file("brief"))
        document.edited(f"{document.text}\n").save()
        document.save_as(project.recipe_file("saved"))
        cell = project.open_cell("gantry")
        plan_change(
            NamedCell("gantry", cell), [CellEdit(("base", "xyz_mm"), [0, 0, 9])], project.place_of_edited_cell(cell), ()
        ).write()
    except JobError as error:
        sys.stderr.write(f"error: {error}\n")
        code = 2
    _finish(code)


WORKS: dict[str, Callable[[], object]] = {
    **{name: command((*name.partition(" #")[0].split(), *words)) for name, words in WORDS.items()},
    "study": _study,
    "study #worker": command(("study", "study.yaml", "-o", "worked", "--workers", "1")),
    FOLDER: command(EXPORT),
    "board import": command(("board", "import", "in.step", "-o", "y.tri.gz")),
    **{f"board show #{name}": command(("board", "show", name)) for name in (*FORMATS, "order")},
    **{f"part show #{name}": command(("part", "show", name)) for name in ("points.xyz", "in.step")},
    **{f"plan #{each}": command(("plan", SOURCES[each], RECIPES[each], "-o", f"{each}.wash")) for each in OTHERS},
    **{f"analyse #{each}": command(("analyse", f"{each}.wash", SOURCES[each], "--html", "a.html")) for each in OTHERS},
    "ui": _page,
}


def main() -> None:
    """Run what the arguments name; exit 1 if anything was wrong."""
    reader = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    reader.add_argument("--only", action="append", choices=WORKS, help="a command; may be repeated")
    reader.add_argument("--all", action="store_true", help="every command")
    reader.add_argument("--fault", action="append", choices=FAULTS, help="a fault; may be repeated")
    reader.add_argument("--every", type=int, default=1, metavar="N", help="every N-th call")
    reader.add_argument("--moments", type=int, default=0, metavar="N")
    reader.add_argument("--seed", type=int, default=1)
    arguments = reader.parse_args()
    named = arguments.only or (WORKS if arguments.all else CHOSEN)
    chosen = [name for name in WORKS if name in named]  # programs come before what needs them
    folder = Path(tempfile.mkdtemp()).resolve()  # forks would remove that of a TemporaryDirectory when they end
    try:
        total, wrong = _run_all(chosen, arguments, folder)
    finally:
        shutil.rmtree(folder)
    print(f"{total} points, {wrong} wrong")
    sys.exit(bool(wrong))


def _run_all(chosen: Sequence[str], arguments: argparse.Namespace, place: Path) -> tuple[int, int]:
    """Run commands at all their points, and print a line for each fault; gives how many, and how many were wrong."""
    chance, total, wrong = random.Random(arguments.seed), 0, 0
    inputs = _make_inputs(place / "inputs")
    prepare(command(PROGRAM), inputs, place / "program", as_one=False, stops=False)
    for name in chosen:
        for each in ([MADE[name]] if name in MADE and MADE[name] not in chosen else []) + [name]:
            bench = prepare(
                WORKS[each], inputs, place / each.replace(" ", "-"), as_one=each == FOLDER, stops=each == "operate"
            )
        for kind in arguments.fault or FAULTS:
            fault, ends, problems = FAULTS[kind], Counter[str](), list[str]()
            points: list[float] = [*points_of(bench, fault)[:: arguments.every]]
            points += [-chance.random() * bench.seconds for _ in range(arguments.moments * fault.is_signal)]
            for point in points:
                end, found = run_point(bench, fault, point, place / "run")
                ends[end] += 1
                problems += found
            total, wrong = total + len(points), wrong + len(problems)
            text = "; ".join(f"{count} {end}" for end, count in sorted(ends.items()))
            print(f"{name:<24} {kind:<10} {len(points):4d}  {text}", *problems, sep="\n  WRONG ", flush=True)
    return total, wrong


def _make_inputs(folder: Path) -> Path:
    """Write what the commands read."""
    folder.mkdir()
    write_inputs(folder)
    (folder / "study.yaml").write_text(STUDY, "utf-8")
    (folder / "own.yaml").write_text("parameters: own\nextends: default\n", "utf-8")
    parts = [("PCB", "PCB", (100.0, 80.0, 1.6), (45.0, 35.0, -1.6)), ("R1", "R_0603", (4.0, 3.0, 1.0), (8.0, 8.0, 0.0))]
    for name, file in FORMATS.items():
        shutil.copyfile(file, folder / name)
    shutil.unpack_archive(FORMATS["gerber.zip"], folder / "order")
    shutil.copyfile(BOARDS / "exported" / "pos.csv", folder / "order" / "pos.csv")
    (folder / "in.step").write_text(StepWriter().write(parts), "utf-8")
    return folder


if __name__ == "__main__":
    main()
