"""Mutation score of the tests: small deliberate bugs, drawn by seed from the operators of cosmic-ray.

A quota is drawn for each room. The quick tests run once in a copy of the checkout, to learn which of them execute which
line; those that fail there are left out. Then each mutant is written into the copy, and the tests that execute its line
run, cheapest first, and the slow ones of its room last. Survivors are listed with their line before and after. Each run
is a process forked from this one, which has imported libraries but nothing of the product.

python tools/mutants.py [--seed 1] [--count 150] [--rooms rulesengine/timing,cleaning/film] [--folder F]
"""

import argparse
import ast
import contextlib
import difflib
import functools
import gc
import importlib
import itertools
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import coverage
import pytest
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
LIBRARIES = ("numba", "scipy.optimize", "scipy.spatial", "shapely", "trimesh", "pydantic", "ruamel.yaml",
             "rich.console", "typer", "matplotlib.figure", "hypothesis.strategies")  # fmt: skip
FAR_S = 60.0
"""Time for tests of other rooms"""
COMPILED = re.compile(r"^@(compiled|quick|inner|vectorised|inlined)\b", re.MULTILINE)
_NO_TESTS = 5
"""What pytest ends with where none is selected"""
MEMORY_BYTES = 8 << 30
"""A mutant may never cease to append."""


@dataclass(frozen=True)
class Mutant:
    """One occurrence of one operator in one file."""

    file: str
    operator: str
    occurrence: int
    line: int

    @property
    def tests(self) -> tuple[str, str]:
        """The folders of the tests of its room and of its package."""
        rooms = [f"tests/{room}/" for room in Path(self.file).parents if (ROOT / "tests" / room).is_dir()]
        return rooms[0], f"tests/{self.file.split('/')[0]}/"


@dataclass(eq=False)
class Observed:
    """Plugin of pytest: how long each test takes, and which lines it executes."""

    coverage: coverage.Coverage
    seconds: dict[str, float] = field(default_factory=dict[str, float])
    failed: list[str] = field(default_factory=list[str])
    file: str = ""

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        """Begin a test; each file prepares anew what others have kept, so that these lines count for its tests too."""
        if self.file != (file := nodeid.split("::")[0]):
            self.file = file
            for each in gc.get_objects():
                if isinstance(each, functools._lru_cache_wrapper):
                    path = getattr(sys.modules.get(each.__module__), "__file__", None) or ""
                    if path.startswith(str(Path.cwd())):
                        each.cache_clear()
        self.coverage.switch_context(nodeid)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Add the time of a test's set-up, call and end."""
        self.failed += [report.nodeid] if report.failed else []
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration


def no_mutants(tree: ast.AST) -> list[ast.expr]:
    """What no test can notice: annotations of functions, what type checkers read, and what is not used unless it fails.

    ``slots`` refuse attributes that no field declares, ``strict`` lengths that differ.
    """
    found: list[ast.expr | None] = []
    for node in ast.walk(tree):
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                found += [node.returns, *(each.annotation for each in ast.walk(node.args) if isinstance(each, ast.arg))]
                found += [each.annotation for each in ast.walk(node) if isinstance(each, ast.AnnAssign)]
            case ast.If(test=ast.Name(id="TYPE_CHECKING")):
                found.append(node.test)
            case ast.Call(func=ast.Name(id="dataclass" | "zip")):
                found += [each.value for each in node.keywords if each.arg in ("slots", "strict")]
    return [each for each in found if each is not None]


def mutants_of(file: str, operators: dict[str, Any]) -> list[Mutant]:
    """All mutants of a file."""
    text = (ROOT / file).read_text("utf-8")
    left_out = [
        ((each.lineno, each.col_offset), (each.end_lineno, each.end_col_offset)) for each in no_mutants(ast.parse(text))
    ]
    # Most leaves are names and brackets, which no operator changes.
    nodes = [
        node
        for node in ast_nodes(get_ast(text))
        if node.type not in ("name", "string", "newline") and (node.type != "operator" or node.value in "+-*/")
    ]
    stars = {node.start_pos for node in nodes if node.type == "operator" and node.parent.type == "parameters"}
    found: list[Mutant] = []
    for name, operator in operators.items():
        places = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        found += [
            Mutant(file, name, number, start[0])
            for number, start in enumerate(places)
            if start not in stars and not any(begin <= start < end for begin, end in left_out)
        ]
    return found


def all_mutants(rooms: tuple[str, ...]) -> dict[str, list[Mutant]]:
    """All mutants of the product's files, by room."""
    # Identity in place of equality is a warning of Python's, and the same for short words and small numbers.
    names = [name for name in sorted(operator_names()) if name.split("/")[1].startswith(KINDS)]
    names = [name for name in names if "Operator_Is" in name or not name.endswith(("_Is", "_IsNot"))]
    operators = {name: get_operator(name)() for name in names}
    listed = subprocess.run(["git", "ls-files", "*.py"], cwd=ROOT, check=True, capture_output=True, text=True)
    found: dict[str, list[Mutant]] = defaultdict(list)
    for file in listed.stdout.split():
        inside = file.startswith(rooms) if rooms else file.split("/")[0] in PACKAGES
        if inside and not file.endswith("__init__.py"):
            found[str(Path(file).parent)] += mutants_of(file, operators)
    return found


def draw(found: dict[str, list[Mutant]], count: int, seed: int) -> list[Mutant]:
    """Draw mutants: one of each room while any are left to draw, then in proportion to what a room has."""
    chance = random.Random(seed)
    shuffled = {room: chance.sample(mutants, len(mutants)) for room, mutants in sorted(found.items()) if mutants}
    drawn = [mutants.pop() for mutants in shuffled.values()][:count]
    rest = [mutant for mutants in shuffled.values() for mutant in mutants]
    return drawn + chance.sample(rest, max(0, min(count - len(drawn), len(rest))))


def run_tests(words: list[str], copy: Path, cache: str = "", observed: Observed | None = None) -> int:
    """Run pytest in a process of its own, and return what it ends with; its output is kept beside the copy."""

    def forked() -> None:
        os.setsid()
        resource.setrlimit(resource.RLIMIT_DATA, (MEMORY_BYTES, MEMORY_BYTES))
        with copy.with_name("output.txt").open("w") as output:
            os.dup2(output.fileno(), 1)
            os.dup2(output.fileno(), 2)
        os.chdir(copy)
        os.environ |= {"PYTHONPATH": str(copy), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        if cache:
            os.environ["NUMBA_CACHE_DIR"] = cache
            importlib.import_module("numba.core.config").reload_config()
        sys.path.insert(0, str(copy))
        if observed:
            observed.coverage.start()
        # The timer ends the process even in a compiled loop.
        options = "-q -n 0 --assert=plain -p no:cacheprovider -o timeout=120 -o timeout_method=thread"
        code = int(pytest.main([*options.split(), *words], plugins=[observed] if observed else []))
        if observed:
            observed.coverage.stop()
            observed.coverage.save()
            kept = {test: time for test, time in observed.seconds.items() if test not in observed.failed}
            copy.with_name("seconds.json").write_text(json.dumps([kept, observed.failed]), "utf-8")
        sys.stdout.flush()
        os._exit(code)

    process = multiprocessing.get_context("fork").Process(target=forked)
    process.start()
    process.join()
    with contextlib.suppress(ProcessLookupError):  # what a test has started and not ended
        os.killpg(process.pid or 0, signal.SIGKILL)
    return process.exitcode or 0


@dataclass(frozen=True)
class Executed:
    """Which quick tests execute which line of which file, and how long they take."""

    lines: dict[str, dict[int, set[str]]]
    seconds: dict[str, float]

    def tests_of(self, mutant: Mutant) -> list[list[str]]:
        """The quick tests that can notice a mutant, in the order to run them: those of its room before others.

        What runs while a module is imported, or is compiled, is not seen: all tests of the module and of its room and
        package are for these, up to ``FAR_S`` beyond the room.
        """
        touched = self.lines.get(mutant.file, {})
        if lines := statement_lines(ROOT / mutant.file, mutant.line):
            hits = {test for line in lines for test in touched.get(line, ())}
        else:
            hits = {test for tests in touched.values() for test in tests}
            hits |= {test for test in self.seconds if test.startswith(mutant.tests)}
        ordered = sorted(hits, key=lambda test: (self.seconds[test], test))
        far = [test for test in ordered if not test.startswith(mutant.tests[0])]
        times = itertools.accumulate(self.seconds[test] for test in far)
        return [
            [test for test in ordered if test.startswith(mutant.tests[0])],
            [test for test, time in zip(far, times, strict=True) if time < FAR_S],
        ]


def statement_lines(file: Path, line: int) -> range | None:
    """The lines of a statement in a function (of one with a body, its head); none in what is imported or compiled."""

    def last(node: ast.stmt) -> int:
        return node.end_lineno or node.lineno

    nodes = [node for node in ast.walk(ast.parse(file.read_text("utf-8"))) if isinstance(node, ast.stmt)]
    nodes = [node for node in nodes if node.lineno <= line <= last(node)]
    functions = [each for each in nodes if isinstance(each, ast.FunctionDef) and each.body[0].lineno <= line]
    decorators = {f"@{ast.unparse(each)}" for function in functions for each in function.decorator_list}
    if not functions or any(COMPILED.match(each) for each in decorators):
        return None
    statement = min(nodes, key=lambda each: last(each) - each.lineno)
    body = getattr(statement, "body", None)
    return range(statement.lineno, body[0].lineno if body else last(statement) + 1)


def is_compiled(file: str) -> bool:
    """Whether a file has compiled functions, or one that imports it has."""
    own, module = (ROOT / file).read_text("utf-8"), file.removesuffix(".py").replace("/", ".")
    texts = [each.read_text("utf-8") for package in PACKAGES for each in (ROOT / package).rglob("*.py")]
    return any(COMPILED.search(text) and (text == own or f"from {module} import" in text) for text in texts)


def survives(mutant: Mutant, copy: Path, executed: Executed) -> str:
    """The difference that a mutant makes if no test notices it; empty where one does, or where it changes nothing."""
    place = copy / mutant.file
    before, stat = place.read_text("utf-8"), place.stat()
    after = mutate_code(before, get_operator(mutant.operator)(), mutant.occurrence)
    if after is None or after == before:
        return ""
    # What numba keeps is known by the time and size of a function's own file: constants and callees may be old.
    stale = statement_lines(place, mutant.line) is None and is_compiled(mutant.file)
    slow = ["-m", "slow and not long and not controller", mutant.tests[0]]
    with tempfile.TemporaryDirectory() as folder:
        try:
            place.write_text(after, "utf-8")
            for words in (*executed.tests_of(mutant), slow):
                if words and run_tests(["-x", *words], copy, folder if stale else "") not in (0, _NO_TESTS):
                    return ""
        finally:
            place.write_text(before, "utf-8")
            os.utime(place, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), mutant.file, mutant.file, lineterm="", n=0)
    return "\n".join(lines)


def observe(drawn: list[Mutant], copy: Path) -> Executed:
    """Run all quick tests of the packages once; not again in a folder where that was done."""
    files = sorted({mutant.file for mutant in drawn})
    kept = str(copy.with_name("executed"))
    measured = coverage.Coverage(kept, config_file=False, include=[str(copy / file) for file in files])
    folders = sorted({mutant.tests[1] for mutant in drawn})
    if not copy.with_name("seconds.json").exists():
        quick = "(not slow or shown) and not controller"
        run_tests(["-m", quick, *dict.fromkeys([*folders, "tests/commandline/"])], copy, observed=Observed(measured))
    seconds, failed = json.loads(copy.with_name("seconds.json").read_text("utf-8"))
    for test in failed:
        print(f"left out, fails without a mutant: {test}", flush=True)
    data = coverage.CoverageData(kept)
    data.read()
    found = {file: data.contexts_by_lineno(str(copy / file)) for file in files}
    lines = {file: {line: seconds.keys() & tests for line, tests in each.items()} for file, each in found.items()}
    return Executed(lines, seconds)


def main() -> None:
    """Print each survivor, and the share of mutants that the tests notice."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n", 1)[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=150)
    parser.add_argument("--rooms", default="")
    parser.add_argument("--folder", help="keep what the tests execute, for another run of the same commit and seed")
    given = parser.parse_args()
    drawn = draw(all_mutants(tuple(each for each in given.rooms.split(",") if each)), given.count, given.seed)
    for library in LIBRARIES:
        importlib.import_module(library)
    survivors = 0
    with tempfile.TemporaryDirectory() if given.folder is None else contextlib.nullcontext(given.folder) as folder:
        copy = Path(folder).resolve() / "checkout"
        left_out = shutil.ignore_patterns(".venv", ".git", "site", "*.pyc")
        shutil.copytree(ROOT, copy, ignore=left_out, symlinks=True, dirs_exist_ok=given.folder is not None)
        executed = observe(drawn, copy)
        for number, mutant in enumerate(drawn, start=1):
            left = survives(mutant, copy, executed)
            survivors += bool(left)
            state = "SURVIVES" if left else "noticed"
            print(
                f"{number}/{len(drawn)} {state} {mutant.file}:{mutant.line} {mutant.operator}",
                left,
                sep="\n",
                flush=True,
            )
    noticed = len(drawn) - survivors
    print(f"{noticed} of {len(drawn)} mutants are noticed ({noticed / max(len(drawn), 1):.0%}), seed {given.seed}")


if __name__ == "__main__":
    main()
