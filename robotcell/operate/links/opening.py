"""Every kind of link, by the name it has in a cell's file."""

from collections.abc import Callable, Mapping
from typing import Any

from robotcell.cell.operate_spec import OperateSpec
from robotcell.operate.handshake import Link
from robotcell.operate.links.linuxcnc import open_linuxcnc
from robotcell.operate.links.modbus import open_modbus
from robotcell.operate.links.opcua import open_opcua
from robotcell.operate.nodes import Job

LINKS: Mapping[str, Callable[[Any, Job, float], Link]] = {
    "modbus": open_modbus,
    "opcua": open_opcua,
    "linuxcnc": open_linuxcnc,
}


def open_link(spec: OperateSpec, job: Job) -> Link:
    """Connect to a cell's controller.

    Raises:
        OperateError: it cannot be reached, or what the link needs is missing.
    """
    return LINKS[spec.link.kind](spec.link, job, spec.acknowledge_s)
