"""Mutation score of the tests: small deliberate bugs, drawn by seed from the operators of cosmic-ray.

A quota is drawn for each room. Each mutant is written into a copy of the checkout, and the quick tests of its room are
run, those of its package, and the slow ones of its room. Survivors are listed with their line before and after. Tests
that fail without any mutant would notice everything: that ends the run.

python tools/mutants.py [--seed 1] [--count 150] [--rooms rulesengine/timing,cleaning/film]
"""

import argparse
import difflib
import os
import random
import shutil
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "specs", "geometry", "boards", "programs", "recipes", "cleaning", "robotcell", "rulesengine", "reports", "studies",
    "washboard", "commandline",
)  # fmt: skip
KINDS = ("AddNot", "NumberReplacer", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceBreakWithContinue",
         "ReplaceComparisonOperator", "ReplaceFalseWithTrue", "ReplaceTrueWithFalse", "ReplaceUnaryOperator_USub",
         "ZeroIterationForLoop", "ReplaceBinaryOperator_Add_Sub", "ReplaceBinaryOperator_Sub_Add",
         "ReplaceBinaryOperator_Mul_Div", "ReplaceBinaryOperator_Div_Mul")  # fmt: skip
TIMEOUT_S = 240
"""Of one test: one that never ends notices its mutant too."""
_NO_TESTS = 5
"""What pytest ends with where none is selected"""


@dataclass(frozen=True)
class Mutant:
    """One occurrence of one operator in one file."""

    file: str
    operator: str
    occurrence: int

    @property
    def room(self) -> str:
        """The folder of the file."""
        return str(Path(self.file).parent)


def all_mutants(rooms: tuple[str, ...]) -> dict[str, list[Mutant]]:
    """All mutants of the product's files, by room."""
    operators = [name for name in sorted(operator_names()) if name.split("/")[1].startswith(KINDS)]
    listed = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, check=True, capture_output=True, text=True)
    found: dict[str, list[Mutant]] = defaultdict(list)
    for file in listed.stdout.split():
        inside = file.startswith(rooms) if rooms else file.split("/")[0] in PACKAGES
        if not inside or file.endswith("__init__.py"):
            continue
        nodes = list(ast_nodes(get_ast((ROOT / file).read_text("utf-8"))))
        for name in operators:
            operator = get_operator(name)()
            count = sum(len(list(operator.mutation_positions(node))) for node in nodes)
            found[str(Path(file).parent)] += [Mutant(file, name, number) for number in range(count)]
    return found


def draw(found: dict[str, list[Mutant]], count: int, seed: int) -> list[Mutant]:
    """Draw mutants: one of each room while any are left to draw, then in proportion to what a room has."""
    chance = random.Random(seed)
    shuffled = {room: chance.sample(mutants, len(mutants)) for room, mutants in sorted(found.items()) if mutants}
    drawn = [mutants.pop() for mutants in shuffled.values()][:count]
    rest = [mutant for mutants in shuffled.values() for mutant in mutants]
    return drawn + chance.sample(rest, max(0, min(count - len(drawn), len(rest))))


def tests_of(room: str) -> tuple[tuple[str, str], ...]:
    """Folders of tests and the marks of those to run, one after the other: quick ones first, of the room before others.

    Slow ones of a package take longer than all else together: of these, only the room's.
    """
    places = [Path("tests", *Path(room).parts[:depth]) for depth in range(len(Path(room).parts), 0, -1)]
    there = [str(place) for place in places if (ROOT / place).is_dir()]
    return (*((place, "not slow and not controller") for place in there), (there[0], "slow and not controller"))


def notices(tests: str, marks: str, copy: Path) -> bool:
    """Whether a test fails in a copy of the checkout; one that does not end does, after ``TIMEOUT_S``."""
    options = f"-q -x -n 0 -p no:cacheprovider -o timeout={TIMEOUT_S}".split()
    words = [sys.executable, "-m", "pytest", *options, "-m", marks, tests]
    environment = os.environ | {"PYTHONPATH": str(copy), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(words, cwd=copy, env=environment, capture_output=True, check=False)
    return run.returncode not in (0, _NO_TESTS)


def survives(mutant: Mutant, copy: Path) -> str:
    """The difference that a mutant makes if no test notices it; empty where one does, or where it changes nothing."""
    place = copy / mutant.file
    before = place.read_text("utf-8")
    after = mutate_code(before, get_operator(mutant.operator)(), mutant.occurrence)
    if after is None or after == before:
        return ""
    try:
        place.write_text(after, "utf-8")
        if any(notices(tests, marks, copy) for tests, marks in tests_of(mutant.room)):
            return ""
    finally:
        place.write_text(before, "utf-8")
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), mutant.file, mutant.file, lineterm="", n=0)
    return "\n".join(lines)


def main() -> None:
    """Print each survivor, and the share of mutants that the tests notice."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--rooms", default="")
    given = parser.parse_args()
    rooms = tuple(each for each in given.rooms.split(",") if each)
    drawn = draw(all_mutants(rooms), given.count, given.seed)
    survivors: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "checkout"
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(".venv", ".git", "site", "*.pyc"), symlinks=True)
        for tests, marks in sorted({pair for mutant in drawn for pair in tests_of(mutant.room)}):
            if notices(tests, marks, copy):
                sys.exit(f"{tests} ({marks}): tests fail without a mutant")
        for number, mutant in enumerate(drawn, start=1):
            left = survives(mutant, copy)
            survivors += [left] if left else []
            print(
                f"{number}/{len(drawn)} {'SURVIVES' if left else 'noticed'} {mutant.file} {mutant.operator}", flush=True
            )
            if left:
                print(left, flush=True)
    noticed = len(drawn) - len(survivors)
    print(f"{noticed} of {len(drawn)} mutants are noticed ({noticed / max(len(drawn), 1):.0%}), seed {given.seed}")


if __name__ == "__main__":
    main()
