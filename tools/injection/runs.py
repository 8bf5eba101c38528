"""Runs of a command in forks, with a fault at one of its calls, and what is wrong with how they end."""

import atexit
import importlib
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from injection.calls import Call, Fault, FaultyCalls
from recipes.load import load_recipe
from robotcell.operate.log import replay
from specs.errors import JobError
from specs.output_file import OutputFile
from specs.temporary import sweep

OLD = b"old\n"
"""In place of an output before."""
KEPT = (".part", ".tuning")
"""Endings of what is left on purpose, so that the work is not lost."""
ENDS_S = 120.0
CHILDREN_S = 5.0
"""A child is ended by its parent's end, not by the signal: it may take a moment."""
SAME = 3
"""Of calls of one kind the first and the last so many are points: lines of a log, pieces, files of a folder."""
_Work = Callable[[], object]


@dataclass(frozen=True)
class Ended:
    """How a run ended."""

    code: int
    """Below 0 the signal."""
    err: str
    calls: tuple[Call, ...]
    """Until the fault."""
    wrong: tuple[str, ...]
    modules: tuple[str, ...]
    """That it had imported."""


@dataclass(frozen=True)
class Bench:
    """A command with its folder before, its outputs by their paths, old and new, and the calls between."""

    work: _Work
    before: Path
    known: Mapping[str, tuple[bytes | None, bytes]]
    calls: tuple[Call, ...]
    seconds: float
    as_one: bool
    """Whether its outputs appear together."""
    stops: bool
    """Whether it ends in order at an interrupt."""


def command(words: tuple[str, ...]) -> _Work:
    """Make the work of a command line."""

    def work() -> None:
        from commandline.start import main

        sys.argv = ["washboard", *words]
        main()

    return work


def prepare(work: _Work, inputs: Path, place: Path, *, as_one: bool, stops: bool) -> Bench:
    """Run a command twice without faults: where nothing is, and over other files in the place of its outputs.

    The outputs of the first run are left in the folder of inputs, for the commands after it.
    """
    before, after = inputs, Path(shutil.copytree(inputs, place / "first"))
    first = _run_well(work, after)
    for module in first.modules:  # so that forks have them
        with suppress(Exception):
            importlib.import_module(module)
    old, new = contents(before), contents(after)
    outputs = [name for name, content in new.items() if old.get(name) != content]
    over = Path(shutil.copytree(inputs, place / "before"))
    for name in outputs:
        if name not in old:
            (over / name).parent.mkdir(parents=True, exist_ok=True)
            (over / name).write_bytes(OLD)
    again = Path(shutil.copytree(over, place / "again"))
    begun = time.monotonic()
    ended = run(work, again, frozenset(set(old) - set(outputs)), None)
    if ended.code not in (0, 1) or contents(again) != new:  # it refuses to write over them
        shutil.rmtree(over)
        shutil.copytree(inputs, over)
        ended = first
    seconds = time.monotonic() - begun
    shutil.copytree(after, inputs, dirs_exist_ok=True)
    there = contents(over)
    known = {name: (there.get(name), new[name]) for name in outputs}
    return Bench(work, over, known, ended.calls, seconds, as_one, stops)


def _run_well(work: _Work, folder: Path) -> Ended:
    ended = run(work, folder, frozenset(contents(folder)), None)
    if ended.code not in (0, 1) or ended.err or ended.wrong:
        raise SystemExit(f"without a fault: {ended.code} {ended.err} {ended.wrong}")
    return ended


def points_of(bench: Bench, fault: Fault) -> list[int]:
    """Numbers of the calls at which a fault may occur."""
    alike: dict[tuple[str, ...], list[int]] = {}
    for number, call in enumerate(bench.calls):
        if fault.occurs(call):
            alike.setdefault(call.kind, []).append(number)
    return sorted({number for numbers in alike.values() for number in (*numbers[:SAME], *numbers[-SAME:])})


def run_point(bench: Bench, fault: Fault, point: float, place: Path) -> tuple[str, list[str]]:
    """Run with a fault at a call, or at a moment (below 0, in seconds); how it ended, and what is wrong with that."""
    shutil.copytree(bench.before, place)
    try:
        ended = run(bench.work, place, frozenset(set(contents(place)) - set(bench.known)), (fault, point))
        found = contents(place)
        states = {name: _state(found.get(name), *known) for name, known in bench.known.items()}
        for name in [name for name, state in states.items() if state == "other" and _is_whole(place / name)]:
            states[name] = "between"
        end, problems = judge(bench, fault, ended, place)
        problems += contradictions(end, ended.err, states)
        problems += [f"{name} is neither old nor new" for name, state in states.items() if state == "other"]
        if bench.as_one and len(set(states.values())) > 1:
            problems.append("some outputs are old and some are new")
        problems += left_behind(bench, place)
    finally:
        shutil.rmtree(place, ignore_errors=True)
        shutil.rmtree(temporary_of(place), ignore_errors=True)
    at = f"at {-point:.3f} s" if point < 0 else f"call {point} {bench.calls[int(point)]}"
    return f"{end}, {'/'.join(sorted(set(states.values())))}", [f"{at}: {problem}" for problem in problems]


def contradictions(end: str, err: str, states: Mapping[str, str]) -> list[str]:
    """What a run says of its outputs and is not so."""
    new = [name for name, state in states.items() if state == "new"]
    if end == "unhindered" and len(new) < len(states):
        return [f"ended well, and {states}"]
    if end == "interrupted" and new and "nothing was written" in err:
        return [f"nothing was written, and {new} are there"]
    denied = [name for name in new if end == "refused" and f"{Path(name).name}: cannot be written" in err]
    return [f"{name} cannot be written, and is there" for name in denied]


def judge(bench: Bench, fault: Fault, ended: Ended, place: Path) -> tuple[str, list[str]]:
    """How a run ended, and what is wrong with that."""
    if ended.code in (0, 1) and not ended.err:
        return "unhindered", []
    shown = [f"exit {ended.code}, printed {ended.err!r}"]
    one = ended.err.startswith("error: ") and ended.err.count("\n") == 1 and ended.err.endswith("\n")
    if fault.is_signal and fault.number == signal.SIGKILL:
        return "killed", [] if (ended.code, ended.err) == (-signal.SIGKILL, "") else shown
    if fault.is_signal:
        right = ended.code == 130 and one and "error: interrupted; " in ended.err
        return "interrupted", [] if right or (ended.code, ended.err, bench.stops) == (130, "", True) else shown
    call = ended.calls[-1]
    names = [part for name in bench.known for part in (name, Path(name).name, f"{Path(name).parts[0]}:")]
    if call.place != "output":
        names = [call.name] if call.place == "input" else [str(temporary_of(place))]
    elif call.name in bench.known:
        names = [call.name]
    elif call.event in ("list", "mkdir"):  # what is in an order, or beside an input; a folder in that of the output
        names.append("the current folder: " if call.name == "." else f"{call.name}: ")
    reason = os.strerror(fault.number) in ended.err or "is full" in ended.err
    right = ended.code == 2 and one and reason and any(name in ended.err for name in names)
    return "refused", [] if right else shown


def left_behind(bench: Bench, place: Path) -> list[str]:
    """Processes that live on, and files that are still there after the next writing."""
    temporary = temporary_of(place)
    deadline = time.monotonic() + CHILDREN_S
    while (children := _processes_of(temporary)) and time.monotonic() < deadline:
        time.sleep(0.02)
    for folder in {place, *((place / name).parent for name in bench.known)}:
        if folder.is_dir():
            OutputFile(folder / "next").write(b"")
            (folder / "next").unlink()
    sweep(temporary)
    expected = {*contents(bench.before), *bench.known, *(name + ending for name in bench.known for ending in KEPT)}
    left = [*(set(contents(place)) - expected), *(str(each) for each in temporary.iterdir())]
    return [f"a process lives on: {line}" for line in children] + [f"{name} is left" for name in sorted(left)]


def run(work: _Work, folder: Path, inputs: frozenset[str], fault: tuple[Fault, float] | None) -> Ended:
    """Do a work in a fork, with a fault at the call of a number, or (below 0) at a moment in seconds."""
    temporary = temporary_of(folder)
    temporary.mkdir()
    pipes = [os.memfd_create(name) for name in ("out", "err", "calls")]
    begun = os.eventfd(0)
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        try:
            atexit._clear()
            os.chdir(folder)
            os.environ["TMPDIR"] = tempfile.tempdir = str(temporary)  # Python would try it out first
            for stream, pipe in zip((1, 2), pipes, strict=False):
                os.dup2(pipe, stream)
            at = None if fault is None or fault[1] < 0 else (fault[0], int(fault[1]))
            FaultyCalls((folder, temporary), inputs, pipes[2], at).install()
            _end_with_modules(pipes[2])
            os.eventfd_write(begun, 1)
            work()
        finally:
            os._exit(99)
    with _ended(pid) as wait:
        if fault is not None and fault[1] < 0:
            os.eventfd_read(begun)  # what is before it is the tool's
            time.sleep(-fault[1])
            os.kill(pid, fault[0].number)
        code = wait()
    _, err, heard = (os.pread(pipe, os.fstat(pipe).st_size, 0).decode(errors="replace") for pipe in pipes)
    for each in (*pipes, begun):
        os.close(each)
    lines = [json.loads(line) for line in heard.splitlines()]
    said: dict[str, list[Any]] = {"wrong": [], "modules": []}
    for line in lines:
        for key, value in line.items() if isinstance(line, dict) else ():
            said[key] += value if isinstance(value, list) else [value]
    calls = tuple(Call(*line) for line in lines if isinstance(line, list))
    return Ended(code, err, calls, tuple(said["wrong"]), tuple(said["modules"]))


def _end_with_modules(pipe: int) -> None:
    """Have the process name its modules when it ends by itself."""
    write, end = os.write, os._exit

    def named(code: int) -> None:
        write(pipe, f"{json.dumps({'modules': [*sys.modules]})}\n".encode())
        end(code)

    os._exit = named  # type: ignore[assignment]


@contextmanager
def _ended(pid: int) -> Iterator[Callable[[], int]]:
    """Give what waits for a process, and gives its exit code."""

    def wait() -> int:
        deadline = time.monotonic() + ENDS_S
        while (ended := os.waitpid(pid, os.WNOHANG))[0] == 0:
            if time.monotonic() > deadline:
                os.kill(pid, signal.SIGKILL)
            time.sleep(0.002)
        return os.waitstatus_to_exitcode(ended[1])

    yield wait


def temporary_of(place: Path) -> Path:
    """Where the temporary files of a run are."""
    return place.with_name(f"{place.name}.tmp")


def _processes_of(temporary: Path) -> list[str]:
    """Command lines of the processes that were started with this folder for temporary files."""
    found: list[str] = []
    for each in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if os.fsencode(f"TMPDIR={temporary}") in (each / "environ").read_bytes().split(b"\0"):
                found.append((each / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")[:80])
    return found


def contents(folder: Path) -> dict[str, bytes]:
    """Files below a folder by their paths in it."""
    return {str(each.relative_to(folder)): each.read_bytes() for each in sorted(folder.rglob("*")) if each.is_file()}


def _state(found: bytes | None, old: bytes | None, new: bytes) -> str:
    return "old" if found == old else "new" if found == new else "other"


def _is_whole(path: Path) -> bool:
    """Whether a file is a recipe, as at the end of a stage of tuning, or the log of an operation that was stopped."""
    try:
        return bool(load_recipe(path) if path.suffix == ".yaml" else replay(path.read_text("utf-8"), path))
    except (JobError, OSError, UnicodeDecodeError):
        return False
