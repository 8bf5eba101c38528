"""One analysis as it is and as an earlier revision had it: the same board, program, recipe and parameters, in turns.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cleaning_revision.py [--revision 9153384] [--rounds 5] BOARD.tri``

The earlier revision comes from the repository's history into a temporary folder. It plans its own ``smt-aqueous`` and
writes the program; both read that program, that recipe and the parameters of the earlier revision (what has been added
since has its defaults). Each side runs in a process of its own, compiles in a first round that does not count, and then
analyses when its turn comes, from the loaded board to the verdicts. Medians of user processor time of all threads and
of the clock; the ratio is now over then.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

_ROOT = Path(__file__).parents[1]
_PLAN = """
import sys
from pathlib import Path
from boards.load import load_board
from recipes.load import load_recipe
from rulesengine.pipeline import run
from programs.posts import native
board, recipe, out = (Path(word) for word in sys.argv[1:])
out.write_text(native.render(run(load_recipe(recipe), load_board(board)).program))
"""

_WORK = """
import runpy, sys
from pathlib import Path
sys.path.append(sys.argv.pop(1))  # last: a benchmark has the name of the package
runpy.run_module("cleaning_revision")["work"](*(Path(word) for word in sys.argv[1:]))
"""


def user_s() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def work(board_file: Path, recipe_file: Path, program_file: Path, parameters_file: Path) -> None:
    """Analyse whenever a line comes in; give user seconds and those of the clock."""
    from boards.load import load_board
    from cleaning.analyse import analyse
    from programs.load import load_program
    from recipes.load import load_recipe

    try:
        from cleaning.parameters.load import load_parameters
    except ImportError:  # the earlier revision
        from cleaning.load import load_parameters  # pyright: ignore
    board, recipe = load_board(board_file), load_recipe(recipe_file)
    program, parameters = load_program(program_file), load_parameters(parameters_file)
    for _ in sys.stdin:
        user, clock = user_s(), time.perf_counter()
        report = analyse(program, board, recipe, parameters)
        print(user_s() - user, time.perf_counter() - clock, sum(each.rays for each in report.exposures), flush=True)


def environment(root: Path) -> dict[str, str]:
    """What makes Python import the packages of a checkout."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join((str(root), str(root / "tools")))}


def started(root: Path, files: list[Path]) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, "-c", _WORK, str(_ROOT / "benchmarks"), *map(str, files)],
        env=environment(root),
        cwd=root,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def turn(process: subprocess.Popen[str]) -> tuple[float, float, int]:
    """User seconds, seconds of the clock and rays of one analysis."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write("\n")
    process.stdin.flush()
    user, clock, rays = process.stdout.readline().split()
    return float(user), float(clock), int(rays)


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("board", type=Path)
    parser.add_argument("--revision", default="9153384")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args(words)
    board = arguments.board.resolve()
    with tempfile.TemporaryDirectory() as name:
        then = Path(name) / "then"
        then.mkdir()
        archive = subprocess.run(["git", "archive", arguments.revision], cwd=_ROOT, check=True, capture_output=True)
        subprocess.run(["tar", "-x", "-C", then], input=archive.stdout, check=True)
        recipe, program = then / "recipes/library/smt-aqueous.yaml", Path(name) / "program.wash"
        plan = [sys.executable, "-c", _PLAN, board, recipe, program]
        subprocess.run(plan, env=environment(then), cwd=then, check=True)
        files = [board, recipe, program, then / "cleaning/library/default.yaml"]
        sides = [started(root, files) for root in (_ROOT, then)]
        try:
            found = [[turn(side) for side in sides] for _ in range(arguments.rounds + 1)][1:]
        finally:
            for side in sides:
                side.communicate("")
    for column, what in enumerate(("user", "clock")):
        now, before = (statistics.median(each[side][column] for each in found) for side in (0, 1))
        print(f"{what}: now {now:.2f} s, {arguments.revision} {before:.2f} s, ratio {now / before:.3f}")
    print(f"rays: now {found[0][0][2]:,}, {arguments.revision} {found[0][1][2]:,}")


if __name__ == "__main__":
    main(sys.argv[1:])
