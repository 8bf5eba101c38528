"""The interface that a controller's programmer gets: what the links carry, read back by parsers of others."""

import csv
import io
import re
import struct
import zlib
from pathlib import Path

import pytest
from asyncua.common.xmlparser import NodeData, XMLParser
from model_controller import ModbusController, Received
from operated import connect, dry_run, job_of, model_of, perform, small_cell, table

from robotcell.cell.load import LoadedCell, cell_library, read_cell
from robotcell.operate.drive import terms_of
from robotcell.operate.handshake import Order, check_of, order_values
from robotcell.operate.interface import elements_of, link_of, places_of, render_csv, render_node_set
from robotcell.operate.links.opcua import NODE, TYPES
from robotcell.operate.nodes import Node, still_job
from robotcell.operate.reference.program import program_for
from robotcell.operate.words import BEAT, ORDER, STATUS, Word, count_registers, names_of, pack

OPERATED = [*cell_library()]
PAGE = Path(__file__).parents[3] / "docs" / "operating.md"
READERS = {"Boolean": "H", "UInt16": "H", "UInt32": "L", "Int32": "l"}
"""Of the CSV's types, for ``struct``: of this test's own."""


def rows_of(loaded: LoadedCell) -> list[dict[str, str]]:
    link = link_of(loaded, "modbus")
    return list(csv.DictReader(io.StringIO(render_csv(places_of(loaded, link), link))))


def test_an_order_has_the_registers_of_the_document() -> None:
    """Written by hand from docs/operating.md, so that the definitions cannot change unseen."""
    node = Node(3, 0, 70_000, (-1, 65_536), (1, -2), routine=101)
    order = Order("run", True, 0xABCD, 100, 0x10002, 0x20003, node, 0xDEADBEEF)
    registers = [0xABCD, 3, 1, 100, 1, 2, 2, 3, 0, 3, 1, 4464, 0xDEAD, 0xBEEF, 101]
    assert pack(ORDER, order_values(order)) == [*registers, 0, 1, 0xFFFF, 0xFFFE, 0xFFFF, 0xFFFF, 1, 0]
    checked = "00010002 00020003 00000003 00011170 00000065 00000001 fffffffe ffffffff 00010000"
    assert check_of(0x10002, 0x20003, node) == zlib.crc32(bytes.fromhex(checked))


@pytest.mark.parametrize("words", [ORDER, STATUS])
def test_the_document_has_the_definitions(words: tuple[Word, ...]) -> None:
    rows = re.findall(r"^\| ([\dt][^|]*) \| `(\w+)` \| ([^|]*) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    shown = {name: (register, meaning) for register, name, meaning in rows}
    for word in words:
        begin = count_registers(words[: words.index(word)], 0)
        register, meaning = shown[word.name]
        assert register.split(",")[0].split()[0] == ("then" if word.is_array else str(begin))
        assert meaning == word.meaning
    assert len(shown) == len(ORDER) + len(STATUS)


@pytest.mark.parametrize("name", OPERATED)
def test_the_registers_are_those_that_the_link_writes_and_reads(name: str) -> None:
    """Every register of a block once, none left out."""
    loaded = read_cell(name)
    elements = {array: len(names) for array, names in elements_of(loaded).items()}
    for writer, words, count in (
        ("washboard", ORDER, elements["Outputs"] + elements["Joints"]),
        ("controller", STATUS, elements["Readings"]),
    ):
        rows = [row for row in rows_of(loaded) if row["writer"] == writer and row["type"] != "bit"]
        used = [at for row in rows for at in range(int(row["register"]), int(row["register"]) + int(row["registers"]))]
        assert used == list(range(used[0], used[0] + count_registers(words, count)))
    bits = {row["name"]: (int(row["register"]), int(row["bit"])) for row in rows_of(loaded) if row["type"] == "bit"}
    for channel, each in loaded.spec.io.inputs.items():
        register, bit = bits[f"Inputs.{channel}"]
        assert 16 * (213 - register) + bit == each.number


def _by_name(parser: XMLParser) -> dict[str, NodeData]:
    return {each.browsename.removeprefix("1:"): each for each in parser.get_node_datas()}


@pytest.mark.parametrize("name", OPERATED)
def test_another_parser_reads_the_node_set_as_the_link_has_it(name: str) -> None:
    loaded = read_cell(name)
    parser = XMLParser()
    parser.parse_sync(xmlstring=render_node_set(loaded, link_of(loaded, "opcua")))
    assert parser.get_used_namespaces() == ["urn:washboard"]
    aliases, found = parser.get_aliases(), _by_name(parser)
    (top,) = (each for each in found.values() if each.nodetype == "UAObject")
    variables = {name: each for name, each in found.items() if each.nodetype == "UAVariable"}
    assert variables.keys() == set(TYPES) == {*BEAT, *NODE, *names_of(STATUS)}
    names = {value: alias for alias, value in aliases.items()}
    for each, kind in TYPES.items():
        node = variables[each]
        assert names.get(node.datatype, node.datatype) == kind
        assert (node.accesslevel & 2 > 0) == (each in (*BEAT, *NODE))
        assert node.parent == top.nodeid
        length = len(elements_of(loaded).get(each, ()))
        assert (node.rank, node.dimensions) == ((1, [length]) if each in elements_of(loaded) else (-1, None))


@pytest.mark.parametrize("name", OPERATED)
def test_every_cell_of_the_library_has_a_reference_controller_that_lets_it_start(name: str) -> None:
    loaded = read_cell(name)
    program, terms = program_for(loaded), terms_of(loaded, still_job(loaded))
    assert {"emergency_stop", "door_closed", "part_present", "home"} <= terms.conditions.keys()
    assert all(bool(program.inputs >> number & 1) == state for number, state in terms.conditions.values())
    quantities = {
        key: sensor.scale * 1e-6 * program.readings[index] + sensor.offset
        for key, (index, sensor) in terms.sensors.items()
    }
    least = {wait.sensor: wait.least for wait in terms.waits.values() if wait.sensor}
    assert least
    assert all(quantities[sensor] >= value for sensor, value in least.items())


class FromTable(ModbusController):
    """A controller that has nothing but the rows of the CSV."""

    def __init__(self, rows: list[dict[str, str]], *given: object) -> None:
        self.rows = [row for row in rows if row["type"] != "bit"]
        super().__init__(*given)  # type: ignore[arg-type]

    def take_registers(self, words: list[int]) -> None:
        found = {}
        for row in self.rows:
            if row["writer"] == "washboard":
                at, count = int(row["register"]), int(row["registers"])
                data = struct.pack(f">{count}H", *words[at : at + count])
                (found[row["name"]],) = struct.unpack(f">{READERS[row['type']]}", data)
        beat = tuple(found[name] for name in ("Heartbeat", "Command", "JetPermitted", "WatchdogMs", "Run"))
        plain = (found[name] for name in ("Sequence", "Node", "DurationUs", "Routine"))
        arrays = (tuple(found[name] for name in found if name.startswith(each)) for each in ("Outputs.", "Joints."))
        self.model.order(beat, Received(*plain, *arrays), found["Check"])

    def status_registers(self) -> list[int]:
        now, words = self.model, list[int]()
        values = {
            "Epoch": now.epoch, "Mode": now.mode, "JetOn": now.open, "HeartbeatTaken": now.taken,
            "Accepted": now.accepted, "AcceptedCheck": now.check, "Reached": now.reached, "Inputs": now.inputs,
            "Readings.resistivity_mohm_cm": now.readings[0],
        }  # fmt: skip
        for row in self.rows:
            if row["writer"] == "controller":
                assert 200 + len(words) == int(row["register"])
                count = int(row["registers"])
                words += struct.unpack(f">{count}H", int(values[row["name"]]).to_bytes(2 * count, "big"))
        return words


def test_a_controller_built_from_the_table_alone_carries_a_program_out() -> None:
    job = job_of(table(60))
    controller = FromTable(rows_of(small_cell()), model_of(job))
    try:
        done = perform(job, connect(job, controller.link))
    finally:
        controller.close()
    assert done.operation.state == "end", done.operation.reason
    assert done.log.render() == dry_run(job).log.render()
    assert [(each.number, each.outputs, each.joints) for each in controller.model.received] == [
        (node.number, node.outputs, node.joints) for node in job.nodes
    ]
