"""A cell with ``operate``, joint tables for it, and operations of them on model controllers."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from model_controller import ModelController
from small_cells import CELL

from robotcell.cell.load import LoadedCell, read_cell_text
from robotcell.operate.drive import Controls, Drive, planned_link, terms_of
from robotcell.operate.handshake import Link
from robotcell.operate.links.opening import open_link
from robotcell.operate.log import Log
from robotcell.operate.nodes import Job, read_job
from robotcell.operate.states import Operation

HEAD = "# Joint look-up table, written by Washboard\n# Cell   small  robot ur5e\n"
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
EMERGENCY, DOOR, BOARD, HOME, HOMED, END = 5, 2, 1, 6, 7, 8
ALL_MET = 1 << EMERGENCY | 1 << DOOR | 1 << BOARD | 1 << HOME | 1 << HOMED | 1 << END
_OPERATE = """
operate:
  link: LINK
  interlocks:
    emergency_stop: {input: diEmergency}
    door_closed: {input: diDoor, message: close the door}
  sensors:
    part_present: {input: diBoard}
    home: {input: diHome}
    homed: {input: diHomed}
    end: {input: diEnd}
  routines: {flip_to_bottom: 101}
  queue: 5
  watchdog_s: WATCHDOG
  acknowledge_s: ACKNOWLEDGE
  part_s: 1
  home_s: 1
"""
_INPUTS = "    diDoor: {number: 2}\n"
_MORE = "    diEmergency: {number: 5}\n    diHome: {number: 6}\n    diHomed: {number: 7}\n    diEnd: {number: 8}\n"


WATCHDOG_S = 0.4
"""For tests of what happens when it expires: longer than a busy machine mostly keeps a process waiting."""
PATIENT_S = 5.0
"""Longer than it ever does."""
_LINK = "{kind: modbus, host: 127.0.0.1, port: 5020}"


@cache
def cell_text(link: str = _LINK, watchdog_s: float = PATIENT_S) -> str:
    operate = _OPERATE.replace("LINK", link).replace("WATCHDOG", f"{watchdog_s:g}")
    operate = operate.replace("ACKNOWLEDGE", f"{max(1.0, 0.8 * watchdog_s):g}")
    return CELL.replace(_INPUTS, _INPUTS + _MORE).replace("diDoor, state: 0", "diDoor") + operate


@cache
def small_cell(link: str = _LINK, watchdog_s: float = PATIENT_S) -> LoadedCell:
    return read_cell_text(cell_text(link, watchdog_s))


def table(nodes: int, step_us: int = 1000, events: dict[int, str] | None = None) -> str:
    """A joint table of so many rows; joints have all digits, and a jet is on from the third row to the last but two."""
    switched = {1: "doRing = 0", 2: "tool 1", 3: "doRing = 1", nodes - 2: "doRing = 0", **(events or {})}
    columns = ",".join(("node,time_s", *(f"{name}_deg" for name in JOINTS), "x,y,z,qw,qx,qy,qz,events,made_by"))
    rows = [columns]
    for number in range(1, nodes + 1):
        joints = (f"{(-1) ** joint * (number * 0.01371 + joint * 7.00003):.5f}" for joint in range(6))
        time_s = f"{(number - 1) * step_us / 1e6:.6f}"
        rows.append(",".join((str(number), time_s, *joints, "0,0,0,1,0,0,0", switched.get(number, ""), "")))
    return HEAD + "\n".join(rows) + "\n"


def looped(key: str = "resistivity_mohm_cm", step_us: int = 1000) -> str:
    """Nodes 2 to 4 up to three times."""
    rows = table(6, step_us, events={2: f"repeat 3 until {key} >= 1", 4: "end repeat"}).splitlines()
    place = rows[4].split(",")[2:8]
    rows[6] = ",".join((*rows[6].split(",")[:2], *place, *rows[6].split(",")[8:]))
    return "\n".join(rows) + "\n"


def job_of(text: str) -> Job:
    return read_job(text, small_cell())


def model_of(job: Job, **differences: object) -> ModelController:
    """A controller for the small cell, with every condition met and a reading that ends loops."""
    valves = tuple(index for index, name in enumerate(job.outputs) if name in job.valves)
    settings = {"inputs": ALL_MET, "readings": (10_000_000,), **differences}
    return ModelController(valves, **settings)


@dataclass(frozen=True, slots=True)
class Done:
    """An operation and its log."""

    operation: Operation
    log: Log
    begun: float
    """On the clock of ``time.monotonic``."""


def dry_run(job: Job, first: int = 1) -> Done:
    terms = terms_of(small_cell(), job)
    return perform(job, planned_link(job, terms), first)


def perform(
    job: Job,
    link: Link,
    first: int = 1,
    controls: Controls = lambda: None,
    run: int = 7,
    watchdog_s: float = PATIENT_S,
) -> Done:
    """Operate in the small cell."""
    terms = terms_of(small_cell(watchdog_s=watchdog_s), job)
    log = Log("small", job.sha256, terms.rules)
    drive = Drive(job, terms, link, log, controls=controls, run=run)
    try:
        operation = drive.perform(first)
    finally:
        link.close()
    return Done(operation, log, drive.begun)


def connect(job: Job, link: str) -> Link:
    """Open the link of the small cell's text."""
    spec = small_cell(link).spec.operate
    assert spec is not None
    return open_link(spec, job)


def write_cell(folder: Path, link: str, watchdog_s: float = PATIENT_S) -> Path:
    file = folder / "small.yaml"
    file.write_text(cell_text(link, watchdog_s))
    return file


def write_whole(value: int, digits: int) -> str:
    """Write a whole number of a last digit as the joint table does."""
    sign, text = "-" * (value < 0), f"{abs(value):0{digits + 1}d}"
    return f"{sign}{text[:-digits]}.{text[-digits:]}"
