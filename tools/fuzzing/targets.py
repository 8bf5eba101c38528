"""Every target, derived: board formats, robot languages, kinds of YAML files, other readers, parameters of commands.

A format, a language or a kind enrols by the table that it is in, a parameter by the parser of the command. Valid files
are in ``tests/fuzz/corpus``, a folder a target: each entry is one input, a folder where files belong together.
"""

import ast
import importlib
import io
import os
import pkgutil
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Set
from contextlib import redirect_stdout, suppress
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from random import Random
from typing import Any, Literal, get_args, get_origin

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT / "tests" / "support"), str(ROOT)]

import click
from audited import WORDS, prepare  # pyright: ignore[reportMissingImports]  # of tests/support, which joins above
from command import washboard  # pyright: ignore[reportMissingImports]
from typer import Typer
from typer.main import get_command

from boards.formats.table import FORMATS, Format
from boards.load import load_board
from boards.part.load import load_part
from boards.part.silhouette import read_silhouette
from boards.parts_table.columns import read_columns
from cleaning.calibration.coupon import CouponSetup, read_coupons
from cleaning.calibration.fit_spray import calibrate_pattern, calibrate_ring
from cleaning.calibration.fitted_files import choose_nozzle
from cleaning.parameters.load import load_parameters
from cleaning.uncertainty.measured_table import read_measured
from cleaning.validation.reference import read_reference, read_rows, reference_library
from commandline.arguments import input_name, input_path
from commandline.commands.operate import _print_replay, _read_job  # pyright: ignore[reportPrivateUsage]
from commandline.main import app
from commandline.process import PACKAGES
from fuzzing.mutation import mutate, odd_word
from programs.errors import ProgramError
from programs.foreign import read_files
from programs.load import load_program
from programs.posts.dialects import DIALECTS
from programs.run_log import read_run_log
from recipes.load import load_recipe
from reports.files.robot_programs import rebuild_in_cell
from robotcell.cell.load import LoadedCell, cell_library, read_cell
from robotcell.cell.robot_library import load_robot
from specs.errors import JobError
from specs.output_file import OutputPlace
from specs.progress import no_progress
from specs.yaml.file_kind import FileKind
from studies.results.read_tables import read_tables
from studies.study import load_study

CORPUS = ROOT / "tests" / "fuzz" / "corpus"
_FORMATS_OF_FILES = ROOT / "tests" / "specs" / "yaml" / "formats"
_GOLDEN = ROOT / "tests" / "golden"
_PARAMETER_WEIGHT = 0.003
"""Share of the cases where that of a reader is 1: a case runs a command, takes as long as twenty of a reader, and has
few words to vary; there are two hundred of them."""
_SMALL = 200
"""Bytes: valid files are mutated the less often the larger they are, as they take longer; below this size all alike."""

Files = Mapping[str, bytes]


@dataclass(frozen=True, slots=True)
class Case:
    """One input."""

    files: Files
    """By name, the one to open first."""
    words: tuple[str, ...] = ()
    """Of the command, after its name."""


@dataclass(frozen=True, slots=True)
class Target:
    """What takes an input."""

    name: str
    seeds: tuple[Case, ...]
    read: Callable[[Path], object] | None = None
    """A reader, as commands call it."""
    command: str = ""
    """The command, in place of a reader."""
    is_folder: bool = False
    """Whether the reader opens the folder of several files rather than the first of them."""
    values: tuple[str, ...] = ()
    """Of a parameter that is no file: valid ones."""
    kind: Literal["file", "value"] = "file"
    at: tuple[int, int] = (0, 0)
    """Where the parameter is among the words."""
    weight: float = 1.0

    def case(self, pool: tuple[Case, ...], rng: Random) -> Case:
        """Make an input out of a valid one, or one of those that reached more than they did."""
        (seed,) = rng.choices(pool, [1.0 / (_SMALL + sum(map(len, each.files.values()))) for each in pool])
        if self.kind == "value" or (self.command and rng.random() < 0.1):
            begin, end = self.at
            given = seed.words[begin:end][-1:]
            valid = rng.choice(self.values or given)
            changed = mutate(valid.encode(), tuple(each.encode() for each in self.values), rng)[:100_000]
            value = odd_word(rng) if rng.random() < 0.3 else changed.decode("utf-8", "replace").replace("\0", "")
            return Case({}, (*seed.words[: end - 1], value, *seed.words[end:]))
        name = rng.choice([*seed.files, next(iter(seed.files))])
        kin = tuple(each.files[name] for each in pool if name in each.files)
        return Case({**seed.files, name: mutate(seed.files[name], kin, rng)}, seed.words)

    def run(self, case: Case, folder: Path) -> "tuple[int, str] | None":
        """Read an input; a command gives its exit code and what it printed on stderr."""
        for name, content in case.files.items():
            place = folder / name
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        if self.read is not None:
            first = next(iter(case.files))
            self.read(folder / first.split("/")[0] if self.is_folder and "/" in first else folder / first)
            return None
        outcome = washboard(*self.command.split(), *case.words)
        return outcome.code, outcome.err


def seeds_in(folder: Path) -> Iterator[Case]:
    """Read the inputs in a folder."""
    for place in sorted(folder.iterdir()) if folder.is_dir() else []:
        inside = sorted(each for each in place.rglob("*") if each.is_file()) if place.is_dir() else [place]
        yield Case({each.relative_to(folder).as_posix(): each.read_bytes() for each in inside})


def _formats() -> Iterator[Target]:
    for form in FORMATS:
        read = load_board if form.read else load_part
        yield Target(form.name, tuple(seeds_in(CORPUS / form.name)), read, is_folder=_takes_folders(form))


def _takes_folders(form: Format) -> bool:
    return "/" in form.suffixes


def _languages() -> Iterator[Target]:
    for name in DIALECTS:
        golden = _GOLDEN / "posts" / name
        files = {each.name: each.read_bytes() for each in sorted(golden.iterdir())} if golden.is_dir() else {}
        seeds = (Case({f"program/{each}": text for each, text in files.items()}), *seeds_in(CORPUS / name))
        yield Target(name, seeds[not files :], partial(_read_language, name), is_folder=True)


def _read_language(name: str, place: Path) -> object:
    return rebuild_in_cell(*read_files(place), _cell_of(name))


@cache
def _cell_of(name: str) -> LoadedCell:
    """A cell of the library whose robot has the axes that a sample in a language moves."""
    for cell in ("ur5e-bench", *cell_library()):
        for place in (CORPUS / name).iterdir() if (CORPUS / name).is_dir() else (_GOLDEN / "posts" / name,):
            with suppress(ProgramError):
                rebuild_in_cell(*read_files(place), loaded := read_cell(cell))
                return loaded
    raise AssertionError(f"no cell of the library reads a sample of {name}: put one into {CORPUS.name}")


def _file_kinds() -> Iterator[Target]:
    for noun, kind in file_kinds().items():
        library = [Case({"a.yaml": file.read_bytes()}) for file in kind.library().values()]
        earlier = [Case({"a.yaml": file.read_bytes()}) for file in _FORMATS_OF_FILES.glob(f"{slug(noun)}-*.yaml")]
        kept = [*seeds_in(CORPUS / noun)]
        yield Target(noun, (*kept, *earlier, *library[:3]), READERS_OF_KINDS.get(noun))


def slug(noun: str) -> str:
    """Give the noun as it stands in a file's name."""
    return noun.replace(" ", "-")


def import_product() -> None:
    """Import every module: kinds of files become known, and no command is stopped while it imports half of one."""
    for package in PACKAGES:
        for module in pkgutil.walk_packages([str(ROOT / package)], f"{package}."):
            if not module.name.endswith("__main__"):
                importlib.import_module(module.name)


def file_kinds() -> dict[str, FileKind[Any]]:
    """Every kind of YAML file that a person writes, by its noun: all that the product's modules define."""
    import_product()
    modules = [module for name, module in sys.modules.items() if name.split(".")[0] in PACKAGES]
    found = {value.noun: value for module in modules for value in vars(module).values() if isinstance(value, FileKind)}
    return {noun: kind for noun, kind in found.items() if noun not in NO_INPUT}


NO_INPUT = {"file": "a text that is edited, whatever it is", "library of chemistries": "comes with the product"}
READERS_OF_KINDS: dict[str, Callable[[Path], object]] = {
    "recipe": load_recipe, "cell": read_cell, "robot": load_robot, "study": load_study, "part": load_part,
    "panel": load_board, "parameter set": load_parameters, "columns file": read_columns,
    "reference": read_reference,
}  # fmt: skip
READERS: dict[str, Callable[[Path], object]] = {
    "program": load_program,
    "order": lambda path: load_board(path.parent),
    "parts-table": lambda path: load_board(path.with_name("b.tri"), path),
    "silhouette": lambda path: read_silhouette(path, 0.5),
    "run-log": read_run_log,
    "joint-job": lambda path: _read_job(path, _operated(), (None, None, [])),
    "operate-log": _print_replay,
    "study-tables": lambda path: read_tables(path.with_name("runs.csv"), no_progress),
    "ring": lambda path: calibrate_ring(path, "volume"),
    "pattern": calibrate_pattern,
    "coupons": lambda path: read_coupons(path, _coupon_setup()),
    "reference-data": lambda path: read_rows(path, read_reference(reference_library()["film-jump"])),
    "measured": lambda path: read_measured(path, ["U1", "R1", "board"]),
}
"""Readers that are in no table, by the name of their folder in the corpus."""


@cache
def _operated() -> LoadedCell:
    return read_cell("gantry")


@cache
def _coupon_setup() -> CouponSetup:
    known = load_parameters("default")
    washing = next(liquid for liquid in known.liquids.values() if liquid.use == "wash")
    return CouponSetup(choose_nozzle("smt-aqueous", None)[1], washing, known)


_PROGRAM = "TINY__SMT_AQUEOUS.h"
FILES = {"CELL": "cell.yaml", "LOG.csv": "drive.csv", "DIR": "."}
"""Of parameters that are read: the input that stands for them, by metavar, where no command of the audit has one."""
_EDITS = ("base.xyz_mm: [0, 0, 10]", "tools.1.tcp.xyz_mm: [0, 0, 300]", "home_deg_mm[1]: 4", "cell: mine")
VALUES: dict[str, tuple[str, ...]] = {
    "allow": ("board-differs", "tcp-units"), "tune --allow": ("speeds,tilts", "heights"), "dialect": tuple(DIALECTS),
    "demo --dialect": ("ur", "abb"), "verify": ("U1", "U1,C1"), "serial": ("0001",), "detergent": ("lot 7",),
    "bath_c": ("58",), "conductivity": ("0.1",), "date": ("2026-11-28",), "boards": ("1,100,400",),
    "flux": ("kester-951:3",), "limit": ("time=300", "litres=2"), "worth": ("saving=5", "requirement=10"),
    "keep": ("templates.lines.height_mm", "sequence[0]", "lines"), "scheduler": ("tcp://127.0.0.1:1",),
    "nozzle": ("ring60",), "spacing nozzle": ("fan",), "solution": ("saponifier-15",), "table": ("-350 350 -850 0",),
    "host": ("127.0.0.1", "localhost"), "part scan --side-mm-per-pixel": ("0.5", "1"),
    "part scan --threshold": ("0.5", "0", "1"), "cell place --report": ("out.json", "out.png", "out"),
    "edits": _EDITS, "answer": _EDITS,
}  # fmt: skip
"""Valid values of free text, and of what takes no other: by the parameter's name, or that of its command before it."""
_JUDGED = ("--verdict", "--dialect", "linuxcnc")
OTHER_WORDS: Mapping[str, tuple[str, ...]] = {
    **{f"check --{name}": ("board.wash", "gantry", *_JUDGED)
       for name in ("verdict", "dialect", "recipe", "parameters")},
    **{f"export --{name}": ("board.wash", "--cell", "gantry", *_JUDGED)
       for name in ("verdict", "dialect", "recipe", "parameters")},
    "analyse --cell": ("board.wash", "small.tri", "--dialect", "linuxcnc"),
    "export --without-joints": ("board.wash", "--cell", "kr6-bench", "--board", "small.tri", "-o", "robot"),
    "show --cell": (_PROGRAM,), "operate --replay": (), "study --scheduler": ("study.yaml", "-o", "studied"),
    "analyse --dialect": ("board.wash", "small.tri", "--cell", "gantry"), "ui recipe": ("small.tri",),
    **{f"operate --{name}": ("board.wash", "--cell", "gantry", "--dry") for name in ("board", "parts", "allow")},
    **{f"controller simulate {name}": ("cairo-bench",) for name in ("cell", "--link", "--host", "--port")},
    "controller check cell": ("gantry",),
    "demo --cell": (*WORDS["demo"], "--dialect", "linuxcnc"), "cell place --board": ("board.wash", "gantry"),
    "cell place --parts": ("board.wash", "gantry", "--board", "small.tri"),
}  # fmt: skip
"""Of parameters that do not go with the words of the audit: the others that they go with."""
REFUSED = {
    "controller check cell": "no controller is there",
    "controller simulate cell": "LinuxCNC is the controller of the gantry",
    "tune --resume": "there is no tuning to go on from", "check --dialect": "abb is no language of the gantry",
    "export --dialect": "the same", "analyse --dialect": "the same", "analyse --log": "it is that of another program",
}  # fmt: skip
"""Parameters whose first valid value is refused, with the reason."""


def parameters(group: Typer = app) -> Iterator[tuple[str, click.Command, Any]]:
    """Walk the command: the name of each command, itself, and each of its parameters."""

    def walk(command: Any, path: str) -> Iterator[tuple[str, click.Command]]:
        for name, inner in getattr(command, "commands", {}).items():
            yield from walk(inner, f"{path} {name}")
        if not hasattr(command, "commands"):
            yield path.strip(), command

    for name, command in walk(get_command(group), ""):
        for parameter in command.params:
            yield name, command, parameter


def _parameters(inputs: Files, group: Typer) -> Iterator[Target]:
    every = [*parameters(group)]
    examples: dict[str, str] = {}
    """A file of each metavar."""
    for name, command, parameter in every:
        for words in (words for key, words in WORDS.items() if key.partition(" #")[0] == name):
            for value in _given(command, words).get(parameter.name, ()):
                metavar = parameter.metavar or parameter.name
                examples[metavar] = examples[metavar] if examples.get(metavar) in inputs else value
    for name, command, parameter in every:
        yield _parameter(name, command, parameter, inputs, examples)


def _given(command: Any, words: tuple[str, ...]) -> dict[str, list[str]]:
    """The words of a command by parameter."""
    context = click.Context(command)
    parsed, _, _ = command.make_parser(context).parse_args([*words])
    found = {name: [*value] if isinstance(value, list | tuple) else [value] for name, value in parsed.items()}
    switches = {each.name: each.opts[0] for each in command.params}
    return {name: [switches[name] if each is True else str(each) for each in value] for name, value in found.items()
            if value != [None]}  # fmt: skip


def _parameter(name: str, command: Any, parameter: Any, inputs: Files, examples: Mapping[str, str]) -> Target:
    about, kind = parameter.type_descriptor.parameter_info, parameter.type_descriptor.annotation
    title = f"{name} {parameter.opts[0]}"
    given = _given(command, OTHER_WORDS.get(title, WORDS.get(name, ())))
    metavar = parameter.metavar or parameter.name
    is_file = about.parser in (input_name, input_path)
    example = next((each for each in given.get(parameter.name, ()) if each in inputs), examples.get(metavar, ""))
    valid = [FILES.get(metavar, example)] if is_file else _values_of(title, kind, parameter)
    words, at = _words_with(command, parameter, given, valid[0] if valid else "")
    seed = {each: inputs[each] for each in valid if is_file and each in inputs}
    return Target(
        title,
        (Case(seed, words),) if any(valid) else (),
        command=name,
        values=tuple(valid) if not seed else (*valid, *seed),
        kind="file" if seed else "value",
        at=at,
        weight=_PARAMETER_WEIGHT,
    )


def _values_of(title: str, kind: Any, parameter: Any) -> list[str]:
    """Valid values by the type: those of a choice, numbers at the ends of their range, names of outputs, free text."""
    if found := VALUES.get(title, VALUES.get(parameter.name)):
        return [*found]
    if get_origin(kind) is Literal:
        return [str(each) for each in get_args(kind)]
    if kind is bool:
        return [parameter.opts[0]]
    if kind in (int, float):
        return [str(each) for each in (parameter.min, parameter.max, 1, 0.5, 3) if each is not None]
    inner = get_args(kind)[0] if get_origin(kind) is list else kind
    if isinstance(inner, type) and issubclass(inner, OutputPlace):
        suffix = (parameter.metavar or "").split("|")[0].rpartition(".")[2].lower()
        first = "out" if suffix in ("out", "file", "dir", "folder") else f"out.{suffix}"
        return [first, "out", "out.png", "out.svg", "out.json", "out.yaml", "out.tri", "out.tri.gz", "deep/out.html"]
    return []


def _words_with(
    command: Any, parameter: Any, given: Mapping[str, list[str]], value: str
) -> tuple[tuple[str, ...], tuple[int, int]]:
    """The words of a command with a value of a parameter, and where that is."""
    words: list[str] = []
    at = (0, 0)
    for each in command.params:
        mine = each is parameter
        values = value.split() if mine and each.nargs > 1 else [value] if mine else given.get(each.name, [])
        flag = [each.opts[0]] if each.opts[0].startswith("-") else []
        is_switch = getattr(each, "is_flag", False)
        for one in [values] if each.nargs > 1 and values else [[single] for single in values]:
            begin = len(words)
            words += one if is_switch else [*flag, *one]
            at = (begin, len(words)) if mine else at
    return tuple(words), at


def make_inputs(folder: Path) -> Files:
    """Make the inputs of the commands in a folder; gives their content by name."""
    prepare(folder)
    outside = Path.cwd()
    os.chdir(folder)
    for command in ("export", "operate"):
        assert washboard(command, *WORDS[command]).code == 0
    os.chdir(outside)
    library = {
        "cell.yaml": cell_library()["gantry"],
        "drive.csv": CORPUS / "run-log" / "few.csv",
        _PROGRAM: _GOLDEN / "posts" / "heidenhain" / _PROGRAM,
    }
    places = {path.name: path for path in folder.iterdir()} | library
    return {name: path.read_bytes() for name, path in places.items()}


def make_targets(inputs: Files, group: Typer = app) -> dict[str, Target]:
    """Make all targets by name; ``inputs`` are those of the commands."""
    readers = [Target(name, tuple(seeds_in(CORPUS / name)), read) for name, read in READERS.items()]
    every = [*_formats(), *_languages(), *_file_kinds(), *readers, *_parameters(inputs, group)]
    return {target.name: target for target in every}


def with_valid_seeds(target: Target) -> Target:
    """Run a reader on each of its files, and leave out those that it refuses: a cell names files beside it."""
    valid: list[Case] = []
    for seed in target.seeds if target.read is not None else ():
        with tempfile.TemporaryDirectory(prefix="fuzz-") as folder, suppress(JobError), redirect_stdout(io.StringIO()):
            target.run(seed, Path(folder))
            valid.append(seed)
    return target if target.command else replace(target, seeds=tuple(valid))


def lacking(targets: Mapping[str, Target]) -> list[str]:
    """Name the targets that nothing is made for: without a valid input, or a reader to give it to."""
    return [name for name, target in targets.items() if not target.seeds or not (target.read or target.command)]


def openers() -> set[str]:
    """Every function of the product that opens what a person gives, whatever it calls the door: ``FILE:NAME``."""
    files = [file for package in PACKAGES for file in (ROOT / package).rglob("*.py")]
    trees = {file.relative_to(ROOT).as_posix(): ast.parse(file.read_text("utf-8")) for file in files}
    doors = wrappers(trees)
    return {f"{name}:{each}" for name, tree in trees.items() for each in opens(tree, doors)}


def wrappers(trees: Mapping[str, ast.Module]) -> set[str]:
    """Names of classes that open a file as they are made, and of functions that do nothing else."""
    found = {"InputFile"}
    for tree in trees.values():
        classes = (node for node in tree.body if isinstance(node, ast.ClassDef))
        begun = ((node, each) for node in classes for each in node.body if getattr(each, "name", "")[:2] == "__")
        found |= {
            node.name
            for node, method in begun
            if "InputFile" in {_called(each.func) for each in ast.walk(method) if isinstance(each, ast.Call)}
        }
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and len(node.body) <= 2 and isinstance(node.body[-1], ast.Return):
                given = {each.arg for each in node.args.args}
                calls = [
                    each for each in ast.walk(node) if isinstance(each, ast.Call) and _called(each.func) == "InputFile"
                ]
                if any(isinstance(each.args[0], ast.Name) and each.args[0].id in given for each in calls if each.args):
                    found.add(node.name)
    return found - {"read_text"}  # of YAML, whose kinds enrol by themselves


def opens(tree: ast.Module, doors: Set[str] = frozenset({"InputFile"})) -> set[str]:
    """Functions of a module that call a door: by its name, by another that it was given, or as one of its module."""
    names = set(doors)
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            names |= {each.asname for each in node.names if each.name in doors and each.asname}
        elif isinstance(node, ast.Assign) and _called(node.value) in names:
            names |= {each.id for each in node.targets if isinstance(each, ast.Name)}
    found: set[str] = set()

    def look(node: ast.AST, place: str, within: str) -> None:
        for each in ast.iter_child_nodes(node):
            match each:
                case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name):
                    look(each, f"{within}{name}", f"{within}{name}.<locals>.")
                case ast.ClassDef(name=name):
                    look(each, place, f"{within}{name}.")
                case ast.Call() if any(_called(one) in names for one in (each.func, *each.args)):
                    found.add(place)
                    look(each, place, within)
                case _:
                    look(each, place, within)

    look(tree, "<module>", "")
    return found


def _called(node: ast.expr) -> str:
    return node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""
