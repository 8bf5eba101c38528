"""``washboard operate``: a program fed to a robot's controller node by node."""

import gc
import signal
import sys
import threading
from collections.abc import Generator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Annotated

import typer

from commandline.arguments import (
    Allow,
    CellName,
    NoToken,
    Parts,
    ProgramBoard,
    input_argument,
    input_option,
    output_option,
)
from specs.errors import JobError
from specs.output_file import PART, OutputFile

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from robotcell.operate.drive import Drive
    from robotcell.operate.log import Log
    from robotcell.operate.nodes import Job
    from robotcell.operate.states import Event, Operation
    from specs.ending import Stop
    from specs.progress import Progress

_LARGEST_TABLE = 500_000_000
_NOT_FINISHED, _UNMET, _NOT_SHUT = 1, 3, 4
"""Exit codes: it ended before its end; at it, but a loop did not reach its quantity; not confirmed shut."""
_SHOWN_S = 0.1
CLOCK = ".clock"
"""Ending of the file beside a log that has its clock."""


def operate(
    program: Annotated[
        Path | None, input_argument("PROGRAM.wash|TABLE.csv", "Native program, or its joint table.")
    ] = None,
    cell: CellName = None,
    dry: Annotated[bool, typer.Option("--dry", help="Without a controller: every condition is met at once.")] = False,
    first: Annotated[
        int,
        typer.Option(
            "--from",
            help="Node from which on the jet is on again; until there valves stay shut.",
            metavar="NODE",
            min=1,
        ),
    ] = 1,
    log: Annotated[
        OutputFile | None, output_option("--log", "FILE", "Log to write; its clock goes to FILE.clock.", PART, CLOCK)
    ] = None,
    replay: Annotated[
        Path | None, input_option("--replay", "LOG", "Check a log: its events lead to its states.")
    ] = None,
    hal: Annotated[
        OutputFile | None, output_option("--hal", "FILE", "HAL file for LinuxCNC to write, and stop.")
    ] = None,
    live: Annotated[
        int | None,
        typer.Option(
            "--live",
            help="Serve the live view, with its stop, at this port of this machine; 0 takes any.",
            metavar="PORT",
            min=0,
            max=65535,
        ),
    ] = None,
    no_token: NoToken = False,
    board: ProgramBoard = None,
    parts: Parts = None,
    allow: Allow = None,
) -> None:
    """Feed a program to a robot's controller node by node, each acknowledged, while interlocks and sensors allow it.

    Lines on the standard input pause, resume and stop it, and so does the live view; Ctrl-C shuts the valves first,
    then ends.

    [dim]washboard operate demo.wash --cell my-cell.yaml --dry --log dry.csv
    washboard operate demo.wash --cell my-cell.yaml --log run.csv --live 8090
    washboard operate --replay run.csv[/dim]
    """
    from robotcell.cell.load import read_cell

    if replay is not None:
        _print_replay(replay)
        return
    if hal is not None and cell is not None:
        from commandline.loading import finish
        from robotcell.operate.links.linuxcnc import hal_text

        finish(written=(hal, hal_text(read_cell(cell))))
        return
    if program is None or cell is None:
        raise JobError("a program and --cell CELL are needed, or --replay LOG; `washboard operate --help` shows how.")
    loaded = read_cell(cell)
    job = _read_job(program, loaded, (board, parts, allow or []))
    if first > len(job.nodes):
        raise JobError(f"--from {first}: the program has nodes 1 to {len(job.nodes)}.")
    view = None if live is None else (live, not no_token)
    code = _operate((job, program.name), loaded, first, (log, view), is_dry=dry)
    if code:
        raise typer.Exit(code)


def _print_replay(file: Path) -> None:
    from commandline.loading import finish
    from reports.tables.table import Card, FactList
    from robotcell.operate.handshake import OperateError
    from robotcell.operate.log import replay
    from specs.errors import LocatedError
    from specs.input_file import InputFile

    text = InputFile(file, LocatedError, "log of washboard operate", _LARGEST_TABLE).read().decode("utf-8", "replace")
    states = replay(text, file)
    if not states:
        raise OperateError("the log has no entries.", file=file)
    faults = [state.reason for state in states if state.state == "faulted"]
    facts = [("entries", f"{len(states)}, each in the state that its events lead to"), ("ended", states[-1].state)]
    facts += [("fault", fault) for fault in faults[:1]]
    finish(Card("", (FactList((*facts, *_doubts(states[-1]))),)))


def _doubts(ended: "Operation") -> list[tuple[str, str]]:
    """What a run leaves open, whatever state it ended in."""
    not_shut = [("NOT CONFIRMED SHUT", f"{ended.not_shut}; shut the supply by hand")] if ended.not_shut else []
    return [*not_shut, *(("not reached", what) for what in ended.unmet)]


def _read_job(program: Path, loaded: "LoadedCell", how: "tuple[str | None, Parts, list[str]]") -> "Job":
    """Read a joint table, or make that of a program as ``export`` does.

    Raises:
        JobError: it cannot be used, or a finding forbids it.
    """
    from commandline.loading import open_program_workpiece, progress_bar
    from programs.errors import ProgramError
    from programs.load import load_program
    from reports.files.robot_programs import export_in_cell
    from reports.files.write_run import export_refusal
    from reports.terminal.console import open_console, print_findings
    from robotcell.operate.interface import operated
    from robotcell.operate.nodes import read_job
    from specs.finding import blocking
    from specs.finding_rules import check_allowed
    from specs.input_file import InputFile

    operated(loaded)
    board, parts, allow = how
    allowed = check_allowed(allow)
    if program.suffix.lower() == ".csv":
        if how != (None, None, []):
            message = "a joint table is a program as it was exported; leave out --board, --parts and --allow."
            raise ProgramError(message, file=program)
        text = InputFile(program, ProgramError, "joint table (.csv)", _LARGEST_TABLE).read().decode("ascii", "replace")
        return read_job(text, loaded, program)
    planned = load_program(program)
    placed = open_program_workpiece(planned, program, board, parts)
    with progress_bar() as progress:
        done = export_in_cell(planned, loaded, "joint-table", placed, progress)
    if stops := blocking(done.findings, allowed):
        print_findings(open_console(), done.findings)
        raise ProgramError(export_refusal(stops), file=program)
    (text,) = done.exported.files.values()
    return read_job(text, loaded)


def _operate(
    named: "tuple[Job, str]",
    loaded: "LoadedCell",
    first: int,
    outputs: tuple[OutputFile | None, tuple[int, bool] | None],
    *,
    is_dry: bool,
) -> int:
    """Operate, print how it ended, and give the exit code."""
    import secrets

    from commandline.loading import progress_bar
    from robotcell.operate.drive import Drive, planned_link, terms_of
    from robotcell.operate.links.opening import open_link
    from robotcell.operate.log import Log
    from specs.ending import stopped_by_signal

    (job, program), (log, view) = named, outputs
    if log is not None:
        _check_new(log, is_dry=is_dry)
    terms = terms_of(loaded, job)
    with stopped_by_signal() as stop, nullcontext(_to_nobody) if log is None else log.lines() as sink:
        entries = Log(loaded.spec.cell, job.sha256, terms.rules, sink)
        operator = Operator(stop)
        link = planned_link(job, terms) if is_dry else open_link(terms.spec, job)
        try:
            # By chance: two that begin in the same second are two runs.
            run = 1 + secrets.randbelow(0xFFFFFFFF)
            drive = Drive(job, terms, link, entries, controls=operator.next_event, run=run)
            with (
                _without_long_collections(),
                progress_bar() as progress,
                _shown(drive, progress),
                _live_view(drive, operator, view, program, loaded),
            ):
                ended = drive.perform(first)
        finally:
            link.close()
    if log is not None and not is_dry:
        log.all_written[-1].write(entries.render_clock())
    _print_end(job, ended, entries, log, loaded)
    if ended.not_shut:
        return _NOT_SHUT
    if stop.signal is not None:
        return 128 + (stop.signal or signal.SIGINT)
    if ended.state != "end":
        return _NOT_FINISHED
    return _UNMET if ended.unmet else 0


def _check_new(log: OutputFile, *, is_dry: bool) -> None:
    """Refuse to write over the log of an earlier run, or over what is left of one that was killed.

    A log without a clock beside it is that of a dry run, which another dry run makes again.

    Raises:
        OperateError: there is one.
    """
    from robotcell.operate.handshake import OperateError
    from robotcell.operate.log import FIRST

    clock = log.path.with_name(f"{log.path.name}{CLOCK}")
    kept = [place for place in log.all_written if place != log or not is_dry or clock.exists()]
    for place in kept:
        if place.begins(FIRST.encode()):
            raise OperateError("is the log of an earlier run; name another, or move it away.", file=place.path)


def _to_nobody(_line: str) -> None:
    """Take the lines of a log that nobody keeps."""


class Operator:
    """The operator of a drive: lines on the standard input, the live view, and signals. A stop comes first."""

    def __init__(self, stop: "Stop") -> None:
        """Listen to the standard input in a thread."""
        self._signalled = stop
        self._stopped = threading.Event()
        self._words: SimpleQueue[str] = SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def take(self, word: str) -> None:
        """Take ``stop``, ``pause`` or ``resume``, or the begin of one; from any thread, and without waiting."""
        if word and "stop".startswith(word):
            self._stopped.set()
        self._words.put(word)

    def next_event(self) -> "Event | None":
        """Give the next event for the drive; ``None`` where there is none."""
        if self._signalled.signal is not None or self._stopped.is_set():
            return "stop"
        try:
            word = self._words.get_nowait()
        except Empty:
            return None
        events: tuple[Event, ...] = ("pause", "resume")
        return next((event for event in events if word and str(event).startswith(word)), None)

    def _listen(self) -> None:
        with suppress(OSError, ValueError):  # it is closed
            for line in sys.stdin or ():
                self.take(line.strip().lower())


@contextmanager
def _without_long_collections() -> "Generator[None]":
    """Leave what there is out of garbage collections: one that goes through all of it stops every thread meanwhile."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


@contextmanager
def _live_view(
    drive: "Drive", operator: Operator, view: tuple[int, bool] | None, program: str, loaded: "LoadedCell"
) -> "Generator[None]":
    """Serve the live view, print its address, and let the page of this folder find it; nothing without a view.

    A view is a port, and whether its page needs the token.
    """
    if view is None:
        yield
        return
    from reports.terminal.console import open_console
    from robotcell.cell.load import cell_sha256
    from webui.live.live import LiveServer, Running, announced, live_data

    port, needs_token = view
    server = LiveServer(lambda: live_data(drive.snapshot(), drive.job), operator.take, port, needs_token=needs_token)
    console = open_console()
    if not needs_token:
        console.print("[bold red]Every user of this machine can pause, resume and stop the operation.[/bold red]")
    console.print(f"live view  {server.entrance}", soft_wrap=True)
    sys.stdout.flush()
    try:
        with announced(Path(), Running(server.address, server.token, program, loaded.spec.cell, cell_sha256(loaded))):
            yield
    finally:
        server.close()


@contextmanager
def _shown(drive: "Drive", progress: "Progress") -> "Generator[None]":
    """Show a drive on the terminal from a thread of its own: a terminal that hangs does not keep the drive waiting."""
    over = threading.Event()

    def show() -> None:
        while not over.wait(_SHOWN_S):
            snapshot, last = drive.snapshot(), len(drive.job.nodes)
            node = snapshot.node.number if snapshot.node else 0
            jet = f", {' '.join(snapshot.jets)} open" if snapshot.jets else ""
            progress(f"{snapshot.state}, node {node} of {last}{jet}", node / last)

    threading.Thread(target=show, name="terminal", daemon=True).start()
    try:
        yield
    finally:
        over.set()


def _print_end(job: "Job", ended: "Operation", entries: "Log", log: OutputFile | None, loaded: "LoadedCell") -> None:
    from commandline.loading import finish
    from reports.tables.table import Card, FactList

    facts = [
        ("nodes", f"{len(job.nodes)}, {len(job.starts)} openings of a valve"),
        ("ended", f"{ended.state}, after node {ended.node}" if ended.node else ended.state),
    ]
    if ended.state == "faulted":
        facts.append(("fault", _with_message(ended.reason, loaded)))
    elif ended.state == "idle" and ended.reason:
        facts.append(("not begun", _with_message(ended.reason, loaded)))
    if ended.state != "end" and ended.node:
        before = max((start for start in job.starts if start <= ended.node), default=1)
        facts.append(("resume", f"nothing goes on by itself; --from {before} begins with the last opening of a valve"))
    facts += [*_doubts(ended), ("log", f"{len(entries.seconds)} entries")]
    finish(Card("", (FactList(tuple(facts)),)), log=log)


def _with_message(reason: str, loaded: "LoadedCell") -> str:
    """Add what the cell's file states of a condition that is not met."""
    spec = loaded.spec.operate
    condition = None if spec is None else spec.conditions.get(reason.removesuffix(" is not met"))
    return f"{reason}: {condition.message}" if condition is not None and condition.message else reason
