"""The interface of a cell's controller for whoever programs it: a register map, a set of nodes, as CSV and NodeSet2."""

import csv
import io
from collections.abc import Iterator
from dataclasses import astuple, dataclass, fields
from itertools import chain
from pathlib import Path
from xml.etree import ElementTree

from robotcell.cell.load import LoadedCell
from robotcell.cell.operate_spec import LinkSpec, LinuxcncLink, ModbusLink, OpcuaLink, OperateSpec
from robotcell.operate.handshake import MOST_INPUTS, OperateError, require_registers
from robotcell.operate.nodes import joint_columns
from robotcell.operate.words import ORDER, STATUS, Word

_NODE_SET = "http://opcfoundation.org/UA/2011/03/UANodeSet.xsd"
_TYPES = "http://opcfoundation.org/UA/2008/02/Types.xsd"
_TYPE_IDS = {"Boolean": 1, "UInt16": 5, "Int32": 6, "UInt32": 7, "UInt64": 9}
"""Of OPC UA's own types (OPC 10000-6, annex A)."""
_ALIASES = {**{name: f"i={number}" for name, number in _TYPE_IDS.items()},
            "Organizes": "i=35", "HasTypeDefinition": "i=40", "HasComponent": "i=47"}  # fmt: skip
_OBJECTS, _BASE_OBJECT, _BASE_VARIABLE = "i=85", "i=58", "i=63"
_READ, _READ_WRITE = 1, 3
"""Access levels."""


@dataclass(frozen=True, slots=True)
class Place:
    """A number of the interface, an element of an array, or a bit."""

    at: str
    """First holding register, or the path of the variable under Objects."""
    count: str
    """Registers, or the index in the array."""
    bit: str
    """Of an input: counted from 0, the lowest, in that register or variable."""
    type: str
    """OPC UA's name."""
    name: str
    writer: str
    """``washboard`` writes the order, the ``controller`` the status."""
    meaning: str


def operated(loaded: LoadedCell) -> OperateSpec:
    """Give how a cell is operated.

    Raises:
        OperateError: its file does not state it.
    """
    if loaded.spec.operate is None:
        raise OperateError(f"cell {loaded.spec.cell} has no operate: state its link, interlocks and sensors there.")
    return loaded.spec.operate


def link_of(loaded: LoadedCell, kind: str | None) -> ModbusLink | OpcuaLink:
    """Give the link to a controller whose program others write: of the cell, or of the other kind with its defaults.

    Raises:
        OperateError: the cell has none.
    """
    link: LinkSpec = operated(loaded).link
    if kind == "modbus" and not isinstance(link, ModbusLink):
        return ModbusLink(host="127.0.0.1")
    if kind == "opcua" and not isinstance(link, OpcuaLink):
        return OpcuaLink(url="opc.tcp://127.0.0.1:4840")
    if isinstance(link, LinuxcncLink):
        raise OperateError(
            f"cell {loaded.spec.cell} is linked to LinuxCNC, whose HAL file `washboard operate --hal` writes: "
            "give --link modbus or --link opcua for a controller that is programmed otherwise.",
            file=Path(loaded.root.mark.file),
        )
    return link


def elements_of(loaded: LoadedCell) -> dict[str, tuple[str, ...]]:
    """Names of the elements of each array of the interface."""
    io = loaded.spec.io
    return {"Outputs": tuple(io.outputs), "Joints": joint_columns(loaded.cell.robot), "Readings": tuple(io.sensors)}


def places_of(loaded: LoadedCell, link: ModbusLink | OpcuaLink) -> tuple[Place, ...]:
    """Give every number of a cell's interface on a link, with what each element stands for.

    Raises:
        OperateError: the cell has no ``operate``, or is too large for the link.
    """
    elements = {name: len(each) for name, each in elements_of(loaded).items()}
    if isinstance(link, ModbusLink):
        require_registers(elements["Outputs"] + elements["Joints"], elements["Readings"])
    begins = (0, 0) if isinstance(link, OpcuaLink) else (link.orders_at, link.status_at)
    blocks = zip((ORDER, STATUS), begins, ("washboard", "controller"), strict=True)
    return tuple(chain.from_iterable(_block(loaded, link, *block) for block in blocks))


def _block(
    loaded: LoadedCell, link: ModbusLink | OpcuaLink, words: tuple[Word, ...], begin: int, writer: str
) -> Iterator[Place]:
    is_opcua, register = isinstance(link, OpcuaLink), begin
    elements = elements_of(loaded)
    for word in words:
        path = f"{link.object}/{word.name}" if isinstance(link, OpcuaLink) else ""
        about = (word.kind, word.name, writer, word.meaning)
        if not word.is_array:
            yield Place(path or str(register), "" if is_opcua else str(word.registers), "", *about)
        for index, name in enumerate(elements.get(word.name, ())):
            at, count = (path, index) if is_opcua else (register + index * word.registers, word.registers)
            of = (word.kind, f"{word.name}.{name}", writer, _describe(loaded, word.name, name))
            yield Place(str(at), str(count), "", *of)
        inputs = loaded.spec.io.inputs if word.name == "Inputs" else {}
        carried = {name: each.number for name, each in inputs.items() if each.number < MOST_INPUTS}
        for name, number in carried.items():
            at, bit = (path, number) if is_opcua else (register + word.registers - 1 - number // 16, number % 16)
            yield Place(str(at), "", str(bit), "bit", f"Inputs.{name}", writer, _conditions(loaded, name))
        register += word.registers * (len(elements[word.name]) if word.is_array else 1)


def _describe(loaded: LoadedCell, array: str, name: str) -> str:
    """What an element of an array stands for."""
    if array == "Joints":
        return f"1e-5 {'mm' if name.endswith('_mm') else 'degrees'}"
    if array == "Readings":
        sensor = loaded.spec.io.sensors[name]
        return f"{sensor.input}, 1e-6 {sensor.unit}"
    output = loaded.spec.io.outputs[name]
    meanings = {"digital": "0 or 1", "group": "a whole number", "analog": f"1e-6 {output.unit}"}
    valve = any(nozzle.valve == name for nozzle in loaded.spec.nozzles.values())
    return f"{meanings[output.kind]}{', valve' * valve}"


def _conditions(loaded: LoadedCell, name: str) -> str:
    """The conditions that an input decides."""
    met = {key: each.state for key, each in operated(loaded).conditions.items() if each.input == name}
    met |= {key: wait.state for key, wait in loaded.spec.io.waits.items() if wait.input == name}
    return "; ".join(f"{key} is met at {state}" for key, state in met.items())


def columns_of(link: ModbusLink | OpcuaLink) -> tuple[str, ...]:
    """Names of the columns of ``Place`` on a link."""
    first = ("path", "index") if isinstance(link, OpcuaLink) else ("register", "registers")
    return (*first, *(field.name for field in fields(Place)[2:]))


def render_csv(places: tuple[Place, ...], link: ModbusLink | OpcuaLink) -> str:
    """Write places as CSV."""
    out = io.StringIO()
    table = csv.writer(out, lineterminator="\n")
    table.writerow(columns_of(link))
    table.writerows(astuple(place) for place in places)
    return out.getvalue()


def render_node_set(loaded: LoadedCell, link: OpcuaLink) -> str:
    """Write the object with its variables as an OPC UA NodeSet2 (OPC 10000-6, annex F), each with a first value."""
    root = ElementTree.Element("UANodeSet", xmlns=_NODE_SET)
    uris = ElementTree.SubElement(root, "NamespaceUris")
    ElementTree.SubElement(uris, "Uri").text = link.namespace
    aliases = ElementTree.SubElement(root, "Aliases")
    for name, node in _ALIASES.items():
        ElementTree.SubElement(aliases, "Alias", Alias=name).text = node
    top = f"ns=1;s={link.object}"
    _add_node(root, "UAObject", link.object, {"NodeId": top}, ("Organizes", _OBJECTS, _BASE_OBJECT))
    elements = elements_of(loaded)
    for word in (*ORDER, *STATUS):
        settings = {"NodeId": f"{top}.{word.name}", "ParentNodeId": top, "DataType": word.kind}
        access = str(_READ_WRITE if word in ORDER else _READ)
        settings |= {"AccessLevel": access, "UserAccessLevel": access}
        length = len(elements[word.name]) if word.is_array else 0
        if word.is_array:
            settings |= {"ValueRank": "1", "ArrayDimensions": str(length)}
        variable = _add_node(
            root, "UAVariable", word.name, settings, ("HasComponent", top, _BASE_VARIABLE), word.meaning
        )
        value = ElementTree.SubElement(variable, "Value")
        zero = "false" if word.kind == "Boolean" else "0"
        if word.is_array:
            value = ElementTree.SubElement(value, f"ListOf{word.kind}", xmlns=_TYPES)
        for _ in range(length if word.is_array else 1):
            given = {} if word.is_array else {"xmlns": _TYPES}
            ElementTree.SubElement(value, word.kind, given).text = zero
    ElementTree.indent(root)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{ElementTree.tostring(root, "unicode")}\n'


def _add_node(
    root: ElementTree.Element,
    tag: str,
    name: str,
    settings: dict[str, str],
    below: tuple[str, str, str],
    about: str = "",
) -> ElementTree.Element:
    """Add a node; ``below`` is the reference to its parent, the parent, and its type."""
    node = ElementTree.SubElement(root, tag, {**settings, "BrowseName": f"1:{name}"})
    ElementTree.SubElement(node, "DisplayName").text = name
    if about:
        ElementTree.SubElement(node, "Description").text = about
    references = ElementTree.SubElement(node, "References")
    reference, parent, kind = below
    up = {"ReferenceType": reference, "IsForward": "false"}
    ElementTree.SubElement(references, "Reference", up).text = parent
    ElementTree.SubElement(references, "Reference", {"ReferenceType": "HasTypeDefinition"}).text = kind
    return node
