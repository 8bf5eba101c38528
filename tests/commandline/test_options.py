"""Every option of every command is heard on every kind of workpiece: it changes the result, or is refused.

The table is walked from the parser, so that a new option enrols itself: it is given another value than its default,
which follows from its type or stands in ``VALUES``, and the outcome is compared with the run without it.
"""

import inspect
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import pytest
from command import Outcome
from each_workpiece import CELL, FEW_PLACES, KINDS, RECIPES, SOURCES, make_inputs, run_in
from typer import Typer
from typer.models import OptionInfo

from commandline.main import app

APART = {
    "ui": "serves until it is ended; its options are in tests/webui/server",
    "demo": "runs the other commands on a sample board; tests/commandline/commands/test_demo.py",
    "study": "its workpieces are in its file; tests/commandline/commands/test_study.py",
    "controller simulate": "serves until it is ended; tests/commandline/nouns/test_controller.py",
    "operate": "drives a controller, which knows joints and no workpiece; tests/commandline/commands/test_operate.py",
    "tune": "takes minutes; tests/commandline/commands/test_tune.py",
}
"""Commands that are not walked, with the reason and where their options are tried."""


@dataclass(frozen=True)
class Option:
    """An option of a command, and the words that give it another value."""

    command: tuple[str, ...]
    name: str
    words: tuple[str, ...]


def commands(group: Typer = app, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Callable[..., None]]]:
    for each in group.registered_commands:
        assert each.callback is not None
        yield (*path, each.name or each.callback.__name__), each.callback
    for inner in group.registered_groups:
        assert inner.typer_instance is not None
        yield from commands(inner.typer_instance, (*path, str(inner.name)))


BASES: dict[str, Callable[[str], tuple[str, ...]]] = {
    "plan": lambda kind: (SOURCES[kind], RECIPES[kind]),
    "show": lambda kind: (f"{kind}.wash",),
    "classify": lambda kind: (SOURCES[kind], RECIPES[kind]),
    "check": lambda kind: (f"{kind}.wash", CELL),
    "export": lambda kind: (f"{kind}.wash", "--cell", CELL, "--dialect", "linuxcnc"),
    "analyse": lambda kind: (f"{kind}.wash", SOURCES[kind], "--json", "a.json"),
    "bath": lambda kind: (f"{kind}.wash", SOURCES[kind], "--boards", "1"),
    "compare": lambda kind: (SOURCES[kind], RECIPES[kind], RECIPES[kind].replace(".", "-2."), "--json", "a.json"),
    "results": lambda kind: (f"{kind}.wash", "measured.csv", SOURCES[kind], "--json", "a.json"),
    "level": lambda kind: (SOURCES[kind], RECIPES[kind], "--output", "levelled.wash"),
    "board import": lambda kind: (SOURCES[kind], "-o", "out.tri"),
    "board show": lambda kind: (SOURCES[kind],),
    "part show": lambda kind: (SOURCES[kind], "--recipe", "faces.yaml"),
    "part import": lambda kind: (SOURCES[kind], "-o", "out.tri"),
    "cell place": lambda kind: (SOURCES[kind] if kind in ("part", "cloud") else f"{kind}.wash", CELL),
    "cell show": lambda _: (CELL,),
}
"""Words of a command on each kind of workpiece; other commands have none."""

SEARCHED_PLACES = {"cell place --configurations": 300, "cell place --lift": 120}
KINDS_OF = {"cell place": ("board", "part")}
"""A place is searched for a program, whatever it was planned on, or for points on a part: a search takes seconds."""

ALONE: dict[str, tuple[str, ...]] = {
    "spacing": ("coat.yaml", "fan", "--film-um", "20"),
    "validate": ("blow-off",),
    "part scan": ("disc.png", "disc.png", "--mm-per-pixel", "0.5", "-o", "ball.tri"),
    "recipe new": ("smt-aqueous",),
    "cell interview": ("gantry", "--dialect", "linuxcnc"),
    "cell edit": ("gantry", "base.xyz_mm: [0, 0, 10]", "-o", "mine.yaml"),
    "controller map": ("cairo-bench",),
    "calibrate ring": ("ring.csv",),
    "calibrate pattern": ("pattern.csv",),
    "calibrate gap": ("coupons.csv",),
}
"""Words of commands that have no workpiece."""

CONDITIONAL = {
    "check --tilt-band": "used where something is in the way: tests/robotcell/test_track.py",
    "cell place --seed": "another seed may find the same place: benchmarks/cell_placement.py",
    "board show --all": "for boards with many components: tests/reports/cards",
    "recipe new --force": "for a file that is there: tests/commandline/nouns/test_recipe.py",
}
"""Options that rightly change nothing on these inputs, with the condition and where they are tried."""

VALUES: dict[str, tuple[str, ...]] = {
    "plan --cell": (CELL,),
    "plan --allow": ("unreachable",),
    "show --board": ("SOURCE-2",),
    "show --cell": (CELL,),
    "analyse --cell": (CELL, "--dialect", "linuxcnc"),
    "analyse --dialect": ("linuxcnc",),
    "analyse --log": ("measured.csv",),
    "check --verdict": ("--dialect", "linuxcnc", "--board", "SOURCE"),
    "check --dialect": ("linuxcnc",),
    "check --recipe": ("RECIPE-2",),
    "check --parameters": ("other.yaml",),
    "export --verdict": ("--board", "SOURCE"),
    "export --recipe": ("RECIPE-2",),
    "export --parameters": ("other.yaml",),
    "check --board": ("SOURCE-2",),
    "check --tilt-band": ("5",),
    "check --allow": ("unreachable",),
    "export --cell": ("ur5e-bench",),
    "export --dialect": ("heidenhain",),
    "export --board": ("SOURCE-2",),
    "export --allow": ("unreachable",),
    "analyse --recipe": ("RECIPE-2",),
    "analyse --parameters": ("other.yaml",),
    "analyse --verify": ("U1",),
    "analyse --results": ("measured.csv",),
    "analyse --serial": ("A1",),
    "analyse --detergent": ("lot 7",),
    "analyse --bath-c": ("58",),
    "analyse --conductivity": ("12",),
    "analyse --date": ("today",),
    "bath --litres": ("5",),
    "bath --boards": ("1,50",),
    "bath --flux-mg": ("90",),
    "bath --flux": ("rosin:3",),
    "bath --drag-out-ml": ("3",),
    "bath --begin-pct": ("2",),
    "bath --recipe": ("RECIPE-2",),
    "bath --parameters": ("other.yaml",),
    "compare --parameters": ("other.yaml",),
    "results --recipe": ("RECIPE-2",),
    "results --parameters": ("other.yaml",),
    "level --for": ("even-film",),
    "level --film-um": ("40",),
    "part show --recipe": ("faces-2.yaml",),
    "cell place --board": ("SOURCE-2",),
    "cell place --floor": ("1.5",),
    "cell place --lift": ("20",),
    "cell place --table": ("-200", "200", "-200", "200"),
    "cell place --configurations": ("2",),
    "cell place --standoff": ("250",),
    "cell place --points": ("20",),
    "cell place --seed": ("3",),
    "cell place --report": ("x.json",),
    "cell show --board": ("SOURCE",),
    "cell interview --dialect": ("heidenhain",),
    "cell interview --answer": ("margin_mm: 12", "-o", "new.yaml"),
    "controller map --link": ("opcua",),
    "spacing --film-um": ("25",),
    "spacing --height-mm": ("70",),
    "spacing --max-speed-mm-s": ("40",),
    "part scan --mm-per-pixel": ("0.4",),
    "part scan --side-mm-per-pixel": ("0.4",),
    "part scan --threshold": ("0.2",),
    "calibrate ring --recipe": ("brief.yaml", "-o", "new.yaml"),
    "calibrate ring --nozzle": ("knife",),
    "calibrate gap --parameters": ("other.yaml",),
    "calibrate gap --recipe": ("brief.yaml",),
    "calibrate gap --nozzle": ("knife",),
    "calibrate gap --solution": ("di-water",),
    "calibrate gap --date": ("2026-01-01",),
}
"""Another value of an option whose type alone does not give one; SOURCE stands for the workpiece's file."""
FILES = {
    "PNG|SVG": "x.png", "JSON": "x.json", "HTML": "x.html", "OUT.wash": "x.wash", "CSV": "table.csv", "OUT": "out",
    "Y.tri": "y.tri", "OUT.yaml": "new.yaml",
    "CSV|XML": "map.csv", "PAGE.md": "x.md",
}  # fmt: skip


def options() -> Iterator[Option]:
    for path, callback in commands():
        command = " ".join(path)
        hints = get_type_hints(callback, include_extras=True)
        for name, parameter in inspect.signature(callback).parameters.items():
            kind, about = _kind(hints[name])
            if command in APART or not isinstance(about, OptionInfo):
                continue
            stated = [each for each in (about.default, *(about.param_decls or ())) if str(each).startswith("--")]
            flag = str(next(iter(stated), f"--{name.replace('_', '-')}"))
            yield Option(path, flag, _words(f"{command} {flag}", flag, kind, about, parameter.default))


def _kind(hint: Any) -> tuple[Any, Any]:
    if get_origin(hint) is Annotated:
        base, *about = get_args(hint)
        return base, about[0]
    return hint, None


def _words(place: str, flag: str, kind: Any, about: OptionInfo, default: Any) -> tuple[str, ...]:
    if place in VALUES:
        return (flag, *VALUES[place])
    if kind is bool:
        return (flag,)
    if get_origin(kind) is Literal:
        return flag, str(next(each for each in get_args(kind) if each != default))
    literals = [each for inner in get_args(kind) if get_origin(inner) is Literal for each in get_args(inner)]
    if literals:
        return flag, str(next(each for each in literals if each != default))
    metavar = str(about.metavar).split("|")[0] if str(about.metavar).startswith("JSON|") else str(about.metavar)
    if metavar in FILES:
        return flag, FILES[metavar]
    raise AssertionError(f"{place} ({kind}, {about.metavar}): name another value for it in VALUES")


def test_every_command_is_walked_or_says_where_its_options_are_tried() -> None:
    with_options = {" ".join(each.command) for each in options()}
    assert with_options <= {*BASES, *ALONE}
    assert {" ".join(path) for path, _ in commands()} >= {*BASES, *ALONE, *APART}


@pytest.fixture(scope="session")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_inputs(tmp_path_factory.mktemp("options"))


def is_refused(outcome: Outcome) -> bool:
    """One sentence on the error stream, and nothing else."""
    return (
        outcome.code == 2 and outcome.out == "" and outcome.err.startswith("error: ") and outcome.err.count("\n") == 1
    )


@cache
def base_of(command: tuple[str, ...], kind: str, inputs: Path, places: int) -> tuple[Outcome, dict[str, bytes]]:
    words = BASES[" ".join(command)](kind) if kind else ALONE[" ".join(command)]
    folder = inputs.with_name(f"{inputs.name}-{'-'.join(command)}-{kind}-{places}")
    return run_in(folder, inputs, (*command, *words), places)


def kinds_of(command: str) -> tuple[str, ...]:
    return KINDS_OF.get(command, KINDS) if command in BASES else ("",)


CELLS = [(option, kind) for option in options() for kind in kinds_of(" ".join(option.command))]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("option", "kind"),
    CELLS,
    ids=[f"{' '.join(option.command)} {option.name} {kind}".strip() for option, kind in CELLS],
)
def test_it_changes_the_result_or_is_refused(option: Option, kind: str, inputs: Path, tmp_path: Path) -> None:
    command = " ".join(option.command)
    places = SEARCHED_PLACES.get(f"{command} {option.name}", FEW_PLACES)
    base, left = base_of(option.command, kind, inputs, places)
    if base.code == 2:
        assert is_refused(base), base.err
        return
    words = BASES[command](kind) if kind else ALONE[command]
    outcome, files = run_in(tmp_path / "run", inputs, (*option.command, *with_option(words, option, kind)), places)
    assert outcome.code != 70, outcome.err
    if outcome.code == 2:
        assert is_refused(outcome) or outcome.out, outcome.err
    elif f"{command} {option.name}" not in CONDITIONAL:
        assert (outcome, files) != (base, left), "nothing was different, and nothing said why"


def with_option(words: tuple[str, ...], option: Option, kind: str) -> list[str]:
    """The words of a command with an option in place of the same one, if it is stated already."""
    source, recipe = SOURCES.get(kind, ""), RECIPES.get(kind, "")
    meant = {"SOURCE": source, "SOURCE-2": source.replace(".", "-2."), "RECIPE-2": recipe.replace(".", "-2.")}
    given = [meant.get(each, each) for each in option.words]
    if given[0] not in words:
        return [*words, *given]
    at = words.index(given[0])
    same = list(words[at : at + len(given)]) == given
    return [*words[:at], *([] if same else given), *words[at + len(given) :]]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("option", [("--capability",), ("--verify", "U1"), ("--results", "measured.csv")], ids=" ".join)
def test_a_page_is_written_with_what_an_option_adds_or_none_at_all(
    option: tuple[str, ...], kind: str, inputs: Path, tmp_path: Path
) -> None:
    words = ("analyse", *BASES["analyse"](kind), "--html", "a.html", *option)
    outcome, files = run_in(tmp_path / "run", inputs, words, FEW_PLACES)
    assert is_refused(outcome) or outcome.code in (0, 1), outcome.err
    assert set(files) == (set() if outcome.code == 2 else {"a.html", "a.json"})
