"""``washboard controller``: the controller that is operated, for whoever writes its program.

A noun of its own and no option of ``operate``: its commands need a cell and no program.
"""

import shlex
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import CellSource, output_option
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from robotcell.cell.operate_spec import ModbusLink, OpcuaLink
    from robotcell.operate.interface import Place
    from robotcell.operate.reference.program import ControllerProgram

app = typer.Typer(
    help="The controller that `operate` feeds: its registers or nodes, a simulated one, and its test.",
    no_args_is_help=True,
)
_SHOWN_S = 0.1
_PORTS = {"modbus": 5020, "opcua": 4840}
LinkKind: TypeAlias = Literal["modbus", "opcua"]
LinkOption = Annotated[LinkKind | None, typer.Option("--link", help="Kind of the link; left out, that of the cell.")]


@app.command("map")
def show_map(
    cell: CellSource,
    link: LinkOption = None,
    output: Annotated[
        OutputFile | None, output_option("--output -o", "CSV|XML", "The same as a table, or as an OPC UA NodeSet2.")
    ] = None,
) -> None:
    """List the registers, or the variables, that the program of a cell's controller reads and writes.

    [dim]washboard controller map cairo-bench -o registers.csv
    washboard controller map cairo-bench --link opcua -o nodes.xml[/dim]
    """
    from commandline.loading import finish
    from reports.tables.table import Card, Column, Table
    from robotcell.cell.load import read_cell
    from robotcell.operate.interface import columns_of, link_of, places_of

    loaded = read_cell(cell)
    linked = link_of(loaded, link)
    places = places_of(loaded, linked)
    content = None if output is None else _content(output, loaded, linked, places)
    columns = [Column(name.replace("_", " "), "right" if name in ("register", "bit") else "left")
               for name in columns_of(linked)]  # fmt: skip
    rows = [(each.at, each.count, each.bit, each.type, each.name, each.writer, each.meaning) for each in places]
    finish(Card("", (Table.of(columns, rows),)), written=None if content is None else (output, content))


def _content(
    output: OutputFile, loaded: "LoadedCell", link: "ModbusLink | OpcuaLink", places: "tuple[Place, ...]"
) -> str:
    """Write a map as the suffix of its file states.

    Raises:
        OutputError: it states neither, or a node set for a link that has none.
    """
    from robotcell.cell.operate_spec import OpcuaLink
    from robotcell.operate.interface import render_csv, render_node_set
    from specs.output_file import OutputError

    suffix = output.path.suffix.lower()
    if suffix == ".csv":
        return render_csv(places, link)
    if suffix != ".xml":
        raise OutputError(output.path, "a map is .csv or .xml", "Give it one of these endings.")
    if not isinstance(link, OpcuaLink):
        raise OutputError(output.path, "a node set is of OPC UA, and the link is modbus", "Give --link opcua, or .csv.")
    return render_node_set(loaded, link)


@app.command()
def simulate(
    cell: CellSource,
    link: LinkOption = None,
    host: Annotated[
        str, typer.Option("--host", help="Address to listen on, such as 0.0.0.0 for other machines to reach it.")
    ] = "127.0.0.1",
    port: Annotated[
        int | None,
        typer.Option(
            "--port",
            help="Port to listen on, 0 for any; left out, 5020 for Modbus and 4840 for OPC UA.",
            min=0,
            max=65535,
        ),
    ] = None,
) -> None:
    """Simulate the controller of a cell until Ctrl-C: every condition is met, the robot moves in the nodes' times.

    A line such as ``diDoor 0`` on the standard input changes an input.

    [dim]washboard controller simulate cairo-bench
    washboard controller simulate gantry --link opcua --port 4841[/dim]
    """
    from robotcell.cell.load import read_cell
    from robotcell.operate.interface import link_of
    from robotcell.operate.reference.program import program_for
    from robotcell.operate.reference.servers import serve
    from specs.ending import stopped_by_signal
    from specs.errors import printable

    loaded = read_cell(cell)
    linked, program = link_of(loaded, link), program_for(loaded)
    server = serve(program, loaded, linked, host, _PORTS[linked.kind] if port is None else port)
    inputs = {name: each.number for name, each in loaded.spec.io.inputs.items()}
    with stopped_by_signal() as stop:
        typer.echo(
            f"Serves {linked.kind} at {server.host} port {server.port} (Ctrl-C ends it). A cell that is linked to it:"
        )
        edit = shlex.join(["washboard", "cell", "edit", cell, f"operate.link: {server.link}", "-o", "simulated.yaml"])
        typer.echo(f"  {printable(edit)}")
        sys.stdout.flush()
        threading.Thread(target=_change_inputs, args=(program, inputs), daemon=True).start()
        with suppress(KeyboardInterrupt):
            _show(program, tuple(loaded.spec.io.outputs), lambda: stop.signal is not None)
        server.close()
    typer.echo("Stopped.")
    if stop.signal not in (None, signal.SIGINT):
        raise typer.Exit(128 + stop.signal)


def _change_inputs(program: "ControllerProgram", inputs: dict[str, int]) -> None:
    """Change inputs as the lines of the standard input state."""
    with suppress(OSError, ValueError):  # it is closed
        for line in sys.stdin or ():
            name, _, state = line.strip().partition(" ")
            if name in inputs and state.strip() in ("0", "1"):
                program.set_input(inputs[name], on=state.strip() == "1")
            elif name:
                typer.echo(f"give an input and its state, such as {next(iter(inputs))} 0", err=True)


def _show(program: "ControllerProgram", outputs: tuple[str, ...], is_over: Callable[[], bool]) -> None:
    """Show what a program does, in one line on a terminal; elsewhere in a line for each change but that of the node."""
    from time import sleep

    from robotcell.operate.handshake import MODES

    shown: object = None
    while not is_over():
        with program.lock:
            jets = " ".join(outputs[index] for index in program.open_valves)
            state = MODES[program.mode], program.run, jets
            node = program.at.number if program.at else 0
        line = f"{state[0]}, run {program.run}, node {node}, {f'{jets} open' if jets else 'valves shut'}"
        if sys.stdout.isatty():
            typer.echo(f"\r\x1b[2K{line}", nl=False)
        elif state != shown:
            typer.echo(line)
            sys.stdout.flush()
        shown = state
        sleep(_SHOWN_S)
    if sys.stdout.isatty():
        typer.echo()


@app.command()
def check(cell: CellSource) -> None:
    """Test which rules of the interface a cell's controller keeps: its robot goes home, a valve opens.

    Shut the supply before. Exit code 1 where a rule is not kept.

    [dim]washboard controller check my-cell.yaml[/dim]
    """
    from commandline.loading import finish, progress_bar
    from reports.tables.table import Card, Table
    from robotcell.cell.load import read_cell
    from robotcell.operate.handshake import LinkError, OperateError
    from robotcell.operate.interface import link_of, operated
    from robotcell.operate.links.opening import open_link
    from robotcell.operate.nodes import still_job
    from robotcell.operate.reference.conformance import RULES, Result, check_rules

    loaded, found = read_cell(cell), list[Result]()
    link_of(loaded, None)
    link = open_link(operated(loaded), still_job(loaded))
    try:
        with progress_bar() as progress:
            for result in check_rules(loaded, link):
                found.append(result)
                progress(result.rule, len(found) / len(RULES))
    except LinkError as error:
        raise OperateError(f"the controller does not answer: {error}.") from None
    finally:
        link.close()
    finish(Card("", (Table.of(("rule", "result", "seen"), [(each.rule, each.verdict, each.seen) for each in found]),)))
    if any(each.verdict == "fail" for each in found):
        raise typer.Exit(1)
