"""The link to LinuxCNC: its HAL file, and real HAL that is fed live."""

import csv

import numpy as np
import pytest
from operated import small_cell
from real_hal import HalLog, run_on_hal
from real_linuxcnc import CYCLE_S, MISSING

from robotcell.cell.load import cell_library, read_cell
from robotcell.operate.handshake import OperateError
from robotcell.operate.links.linuxcnc import hal_text

CONTROLLER = [pytest.mark.controller, pytest.mark.skipif(bool(MISSING), reason=MISSING)]
HOME = (0.0, 0.0, 30.0, -90.0, 0.0)
JOINTS = ("X", "Y", "Z", "C", "B")
WATCHDOG = 500
"""Servo cycles: longer than a busy machine keeps a process waiting."""


def gantry_table(nodes: int, step_us: int) -> str:
    """Joints of the gantry that leave home and return, by cosines, with a jet on in the middle half."""
    units = ("mm", "mm", "mm", "deg", "deg")
    columns = (f"{name}_{unit}" for name, unit in zip(JOINTS, units, strict=True))
    lines = ["# Cell   gantry  robot gantry", ",".join(("node,time_s", *columns, "events,made_by"))]
    events = {1: "doRing60 = 0", 2: "tool 1", nodes // 4: "doRing60 = 1", 3 * nodes // 4: "doRing60 = 0"}
    for number in range(1, nodes + 1):
        share = 0.5 - 0.5 * np.cos(2 * np.pi * (number - 1) / (nodes - 1))
        joints = (f"{home + way * share:.5f}" for home, way in zip(HOME, (100, 60, -20, 30, 15), strict=True))
        lines.append(
            ",".join((str(number), f"{(number - 1) * step_us / 1e6:.6f}", *joints, events.get(number, ""), ""))
        )
    return "\n".join(lines) + "\n"


def operate(nodes: int, step_us: int, commands: str, watchdog: int = WATCHDOG, limit_s: float = 120.0) -> HalLog:
    text, before = cell_library()["gantry"].read_text(), "  watchdog_s: 0.1 "
    assert before in text
    acknowledge = f"  acknowledge_s: {2 * watchdog * CYCLE_S:g}\n"
    patient = text.replace(before, f"{acknowledge}  watchdog_s: {watchdog * CYCLE_S:g} ")
    return run_on_hal(gantry_table(nodes, step_us), patient, commands, len(JOINTS), ("doRing60",), limit_s)


RUN = "run operate job.csv --cell cell.yaml --log run.csv < /dev/null"
BEGIN = (
    "mkfifo words; (eval exec $washboard operate job.csv --cell cell.yaml --log run.csv < words) & pid=$!; "
    "exec 3> words"
)
AWAIT = "until grep -q ,reached,400,running run.csv.part; do sleep 0.1; done"
"""The process with its standard input, and the wait until it reports a node at which the jet is on."""


def test_a_valve_is_gated_by_permit_watchdog_and_every_interlock() -> None:
    lines = hal_text(read_cell("gantry")).splitlines()
    feeds = {target: line.split()[1] for line in lines if line.startswith("net ") for target in line.split()[2:]}
    nets = {line.split()[1]: line.split()[2] for line in lines if line.startswith("net ") and ".out " in f"{line} "}
    gates, found = [nets["wb-out-doRing60"]], set()
    while gates:
        gate = gates.pop().removesuffix(".out")
        for pin in (f"{gate}.in0", f"{gate}.in1"):
            signal = feeds.get(pin, "")
            found.add(signal)
            source = nets.get(signal, "")
            if source.startswith(("and2", "xor2")):
                gates.append(source)
    assert {"wb-set-doRing60", "wb-permit", "wb-watchdog-ok", "wb-in-1", "wb-in-2"} <= found


def test_a_cell_with_another_link_has_no_hal_file() -> None:
    with pytest.raises(OperateError, match="cell small is not operated by the link linuxcnc"):
        hal_text(small_cell())


class TestOnRealHal:
    pytestmark = CONTROLLER

    def test_ten_thousand_nodes_arrive_in_order_and_to_the_last_digit(self) -> None:
        nodes = 10_000
        log = operate(nodes, 3000, RUN, watchdog=10 * WATCHDOG)
        assert "end, after node 10000" in log.printed
        passed = np.flatnonzero(np.diff(log.sequence)) + 1
        assert log.sequence[passed].tolist() == list(range(1, nodes + 1))
        rows = list(csv.DictReader(gantry_table(nodes, 3000).splitlines()[1:]))
        table = np.array([[float(row[key]) for key in row if key.endswith(("_mm", "_deg"))] for row in rows])
        steps = np.abs(np.diff(table, axis=0, append=table[-1:]))
        assert (np.abs(log.joints[passed] - table) <= steps + 1e-6).all()  # in that cycle it is on its way to the next
        (on, _), (off, _) = log.edges()
        assert log.sequence[[on, off]].tolist() == [nodes // 4, 3 * nodes // 4]

    def test_a_pause_comes_to_rest_and_resume_finishes(self) -> None:
        script = f"{BEGIN}; {AWAIT}; echo pause >&3; sleep 2; echo resume >&3; wait $pid"
        log = operate(1000, 10_000, script)
        assert "end, after node 1000" in log.printed
        states = [state for _, state in log.edges()]
        assert states in ([True, False], [True, False, True, False])
        moving = np.flatnonzero(np.abs(np.diff(log.joints, axis=0)).max(axis=1) > 0)
        gaps = np.diff(moving)
        assert gaps.max() > 1000  # it stood for most of the two seconds
        speeds = np.abs(np.diff(log.joints[:, 0]))
        assert np.abs(np.diff(speeds)).max() < 0.02  # mm in a cycle: it slows down, and does not stop dead

    def test_a_stop_comes_to_rest_with_the_valve_shut_and_a_node_finishes_the_job(self) -> None:
        again = "run operate job.csv --cell cell.yaml --from 400 < /dev/null"
        log = operate(600, 10_000, f"{BEGIN}; {AWAIT}; echo stop >&3; wait $pid; {again}")
        assert "idle, after node" in log.printed
        assert "end, after node 600" in log.printed
        assert [on for _, on in log.edges()] == [True, False, True, False]
        (_, _), (off, _), (on, _), _ = log.edges()
        assert log.sequence[on] == 400
        assert np.abs(np.diff(np.abs(np.diff(log.joints[off : off + 400, 0])))).max() < 0.02  # mm in a cycle

    def test_an_emergency_stop_shuts_the_valve_in_the_next_cycle(self) -> None:
        script = f"{BEGIN}; {AWAIT}; $as halcmd setp or2.2.in0 0; wait $pid"
        log = operate(1500, 10_000, script)
        pressed = int(np.flatnonzero(~log.emergency)[0])
        (_, _), (off, _) = log.edges()  # on, off: it stays off
        assert 0 <= off - pressed <= 2
        assert "emergency_stop is not met: release the emergency stop" in log.printed
        assert not log.valves[pressed + 2 :].any()

    def test_where_our_process_is_killed_the_agent_comes_to_rest_with_the_valve_shut(self) -> None:
        log = operate(1500, 10_000, f"{BEGIN}; {AWAIT}; kill -9 $pid; sleep 2")
        (_, _), (off, _) = log.edges()
        speeds = np.abs(np.diff(log.joints[:, 0]))
        assert speeds[off:].max() > 0.0
        assert np.abs(np.diff(speeds)).max() < 0.02  # mm in a cycle
        assert speeds[-500:].max() == 0.0

    def test_where_both_processes_are_killed_the_watchdog_of_hal_shuts_the_valve(self) -> None:
        log = operate(1500, 10_000, f"{BEGIN}; {AWAIT}; kill -9 $pid $(pgrep -f linuxcnc_agent); sleep 2")
        (_, _), (off, _) = log.edges()
        last = int(np.flatnonzero(np.diff(log.sequence))[-1])
        assert last < off <= last + WATCHDOG
