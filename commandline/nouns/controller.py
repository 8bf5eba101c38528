"""``washboard controller``: what a controller that is operated has to have, for whoever writes its program.

A noun of its own and no option of ``operate``: its commands need a cell and no program.
"""

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import CellSource, output_option
from specs.output_file import OutputFile

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from robotcell.cell.operate_spec import ModbusLink, OpcuaLink
    from robotcell.operate.interface import Place

app = typer.Typer(help="The controller that `operate` feeds: its registers or nodes.", no_args_is_help=True)
LinkKind: TypeAlias = Literal["modbus", "opcua"]
LinkOption = Annotated[LinkKind | None, typer.Option("--link", help="Kind of the link; left out, that of the cell.")]


@app.callback()
def _noun() -> None:
    """The controller that `operate` feeds."""


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
