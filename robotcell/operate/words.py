"""The words of the handshake, once: links, register map, node set and the reference controller have them here.

A block of Modbus registers has the words in this order, high register first, arrays last; OPC UA has a variable each.
"""

import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

Kind: TypeAlias = Literal["Boolean", "UInt16", "UInt32", "UInt64", "Int32"]
FORMATS: Mapping[Kind, str] = {"Boolean": "H", "UInt16": "H", "UInt32": "I", "UInt64": "Q", "Int32": "i"}
"""Of ``struct``, in registers; the names are those of OPC UA."""


@dataclass(frozen=True, slots=True)
class Word:
    """A number of the handshake, or an array of them."""

    name: str
    """OPC UA's browse name."""
    kind: Kind
    meaning: str
    is_array: bool = False

    @property
    def registers(self) -> int:
        """Registers of the number, or of one of the array's."""
        return struct.calcsize(f">{FORMATS[self.kind]}") // 2


ORDER = (
    Word("Heartbeat", "UInt16", "another number with every order"),
    Word("Command", "UInt16", "0 stop: queue empty; 1 hold on the path; 2 go home; 3 go from node to node"),
    Word("JetPermitted", "Boolean", "0: every valve shut, whatever the outputs state"),
    Word(
        "WatchdogMs",
        "UInt16",
        "after so long with the same heartbeat: stop, every valve shut, until Run is another number",
    ),
    Word("Run", "UInt32", "another number: queue empty, sequence numbers begin at 1"),
    Word("Sequence", "UInt32", "of the node; 0: there is none"),
    Word("Node", "UInt32", "its number in the table"),
    Word("DurationUs", "UInt32", "from the node before; the joints go straight"),
    Word("Check", "UInt32", "CRC-32 of the node"),
    Word("Routine", "UInt16", "0; up to 99 change to that tool; from 100 on a call"),
    Word("Outputs", "Int32", "of the cell in their order: 0 or 1, a whole number, or 1e-6 V or mA", is_array=True),
    Word("Joints", "Int32", "1e-5 degrees or mm", is_array=True),
)
STATUS = (
    Word("Epoch", "UInt16", "another number after each start of the controller's program"),
    Word("Mode", "UInt16", "0 stopped, 1 held, 2 homing, 3 home, 4 running"),
    Word("JetOn", "Boolean", "whether any valve is open"),
    Word("HeartbeatTaken", "UInt16", "heartbeat of the last order that the program took"),
    Word("Accepted", "UInt32", "sequence number of the last node accepted"),
    Word("AcceptedCheck", "UInt32", "CRC-32 of that node as it was received"),
    Word("Reached", "UInt32", "sequence number of the last node reached"),
    Word("Inputs", "UInt64", "bit n is digital input n"),
    Word("Readings", "Int32", "of io.sensors in their order, 1e-6 V or mA", is_array=True),
)
BEAT = ("Heartbeat", "Command", "JetPermitted", "WatchdogMs", "Run")
"""In every order; the other words of one are those of its node."""


def names_of(words: Sequence[Word]) -> tuple[str, ...]:
    """Names of words, in their order."""
    return tuple(word.name for word in words)


def _head(words: Sequence[Word]) -> struct.Struct:
    return struct.Struct(">" + "".join(FORMATS[word.kind] for word in words if not word.is_array))


def count_registers(words: Sequence[Word], elements: int) -> int:
    """Registers of a block whose arrays have so many elements together."""
    return _head(words).size // 2 + 2 * elements


def register_at(words: Sequence[Word], name: str) -> int:
    """Place of a word in its block."""
    return count_registers(words[: names_of(words).index(name)], 0)


def pack(words: Sequence[Word], values: Mapping[str, Any]) -> list[int]:
    """Write a block as registers."""
    head = _head(words)
    plain = [values[word.name] for word in words if not word.is_array]
    elements = [each for word in words if word.is_array for each in values[word.name]]
    data = head.pack(*plain) + struct.pack(f">{len(elements)}i", *elements)
    return list(struct.unpack(f">{len(data) // 2}H", data))


def unpack(words: Sequence[Word], registers: Sequence[int], elements: Sequence[int]) -> dict[str, Any]:
    """Read a block from at least its registers.

    Args:
        words: Of the block.
        registers: From its first on.
        elements: Of each array.
    """
    data = struct.pack(f">{len(registers)}H", *registers)
    head, arrays = _head(words), [word.name for word in words if word.is_array]
    plain = [word.name for word in words if not word.is_array]
    found: dict[str, Any] = dict(zip(plain, head.unpack_from(data), strict=True))
    place = head.size
    for name, count in zip(arrays, elements, strict=True):
        found[name] = struct.unpack_from(f">{count}i", data, place)
        place += 4 * count
    return found


def checksum(plain: Sequence[int], elements: Sequence[int]) -> int:
    """CRC-32 of a node.

    Args:
        plain: Run, Sequence, Node, DurationUs, Routine.
        elements: Outputs, then joints; each 32 bits, the high byte first, as those before.
    """
    return zlib.crc32(struct.pack(f">5I{len(elements)}i", *plain, *elements))
