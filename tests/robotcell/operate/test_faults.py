"""Faults on a real link: the jet is off at once, nothing goes on by itself, and a named node finishes the job."""

import itertools
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from injected_faults import KINDS, entries, inject
from model_controller import (
    HELD,
    HOME,
    RUN,
    STOP,
    Controller,
    ModbusController,
    ModelController,
    OpcuaController,
    modbus,
)
from operated import ALL_MET, BOARD, WATCHDOG_S, Done, connect, job_of, model_of, perform, small_cell, table, write_cell
from waiting import WAIT_S, wait_for

from robotcell.operate.drive import planned_link, terms_of
from robotcell.operate.handshake import Found, Link, OperateError, Order, Status
from robotcell.operate.log import replay
from robotcell.operate.nodes import Job
from robotcell.operate.states import Event

NODES, STEP_US = 40, 2000
FAULTS, AT_ONCE = 100, 4
UNHEARD = ("link cut", "program halted")
"""Faults after which nothing is heard of the controller."""


@pytest.fixture(scope="module")
def job() -> Job:
    return job_of(table(NODES, STEP_US))


@pytest.fixture
def controller(job: Job) -> Iterator[ModbusController]:
    served = ModbusController(model_of(job))
    yield served
    served.close()


@pytest.mark.slow
def test_a_hundred_faults_shut_the_jet_at_once_and_leave_it_to_the_operator() -> None:
    job = job_of(table(NODES, 10 * STEP_US))  # long enough for a fault to come before the end on a busy machine
    draw = random.Random(15)
    faults = [(kind, draw.randint(4, NODES - 8)) for kind in itertools.islice(itertools.cycle(KINDS), FAULTS)]

    def handle(some: list[tuple[str, int]]) -> None:
        controller = ModbusController(model_of(job))
        try:
            for kind, at in some:
                assert_fault_is_handled(job, kind, at, controller)
        finally:
            controller.close()

    with ThreadPoolExecutor(AT_ONCE) as pool:  # each operation waits for nearly all of its time
        assert len([*pool.map(handle, (faults[at : at + 10] for at in range(0, FAULTS, 10)))]) == FAULTS // 10


@pytest.mark.slow
def test_every_kind_of_fault_over_opcua(opcua_controller: OpcuaController) -> None:
    job = job_of(table(NODES, 10 * STEP_US))  # an order takes milliseconds there, and on a busy machine more
    draw = random.Random(15)
    for kind in KINDS:
        assert_fault_is_handled(job, kind, draw.randint(4, NODES - 8), opcua_controller)


def assert_fault_is_handled(job: Job, kind: str, at: int, controller: Controller) -> None:
    """The jet is off, nothing moves, and the rest is done from the node of the fault on."""
    done, model = inject(job, kind, at, controller)
    assert done.operation.state == "faulted", kind
    assert KINDS[kind][1] in done.operation.reason
    model.halted = False
    if kind in UNHEARD:  # nothing of ours arrives any more: the controller's watchdog shuts
        time.sleep(1.5 * WATCHDOG_S)
        wait_for(lambda: not model.open, "the watchdog")
    assert not model.open, kind
    assert_shut_next(done, kind)
    reached = model.reached
    if kind == "link cut":
        controller.serve_again()
    time.sleep(0.005)
    assert (model.open, model.reached) == (False, reached), "nothing resumes by itself"
    finish(job, done.operation.node, controller)


def assert_shut_next(done: Done, kind: str) -> None:
    """The order after the fault shut the valves, and the controller confirmed it."""
    at = next(index for index, row in enumerate(entries(done)) if row[3] == "faulted")
    assert not any(row[5] for row in entries(done)[at:])
    following = [row[1] for row in entries(done)[at + 1 :]]
    assert following == (["not shut"] if kind in UNHEARD else ["shut"]), kind


def finish(job: Job, node: int, controller: Controller) -> None:
    """Resume from the node of a fault: the rest is sprayed, and nothing before it."""
    model = controller.model = model_of(job, epoch=controller.model.epoch)
    first = max(node, 3)
    opened: list[int] = []
    model.at_node = lambda sequence: opened.append(sequence) if model.open else None
    done = perform(job, connect(job, controller.link), first, run=1000)
    assert done.operation.state == "end", done.operation.reason
    assert opened == list(range(first, NODES - 2))
    assert [each.joints for each in model.received] == [each.joints for each in job.nodes]


@pytest.mark.parametrize("kind", ["emergency stop", "acknowledgement wrong"])
def test_the_log_of_a_fault_replays(kind: str, job: Job, controller: ModbusController) -> None:
    done, _ = inject(job, kind, 12, controller)
    assert KINDS[kind][1] in done.operation.reason
    assert replay(done.log.render(), "run.csv")[-1] == done.operation
    assert entries(done)[-1][1] == "shut"


def test_a_pause_shuts_the_jet_and_holds_and_resume_finishes(job: Job, controller: ModbusController) -> None:
    model = controller.model = model_of(job, haste=1.0)
    events: list[Event] = []
    model.at_node = lambda sequence: events.append("pause") if sequence == 12 else None
    paused: list[tuple[float, int]] = []

    def controls() -> Event | None:
        if events:
            paused.append((time.monotonic(), model.reached))
            return events.pop()
        if len(paused) == 1 and time.monotonic() > paused[0][0] + 0.05:
            assert not model.open
            paused.append((time.monotonic(), model.reached))
            return "resume"
        return None

    done = perform(job, connect(job, controller.link), controls=controls)
    assert done.operation.state == "end", done.operation.reason
    assert paused[1][1] - paused[0][1] <= 3  # it stood meanwhile
    assert [on for _, on in model.switched] == [True, False, True, False]
    assert [each.sequence for each in model.received] == list(range(1, NODES + 1))


MOMENTS: dict[str, Callable[[ModelController], bool]] = {
    "waiting for the part": lambda model: model.run == 7,
    "first node": lambda model: model.reached >= 1,
    "jet just on": lambda model: model.open,
    "jet on": lambda model: model.reached >= 30,
    "paused": lambda model: model.mode == HELD,
}


@pytest.mark.slow
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("link", [ModbusController, OpcuaController])
def test_a_second_start_is_refused_and_sends_nothing(
    link: Callable[[ModelController], Controller], moment: str
) -> None:
    job = job_of(table(2000, 20_000))
    waits = moment == "waiting for the part"
    model = model_of(job, haste=1.0, inputs=ALL_MET & ~(1 << BOARD) if waits else ALL_MET)
    controller, over, pauses = link(model), threading.Event(), ["pause"] if moment == "paused" else []
    done: list[Done] = []

    def controls() -> Event | None:
        if over.is_set():
            return "stop"
        return pauses.pop() if pauses and model.open else None  # type: ignore[return-value]

    first = threading.Thread(target=lambda: done.append(perform(job, connect(job, controller.link), controls=controls)))
    first.start()
    try:
        wait_for(lambda: MOMENTS[moment](model), moment)
        with pytest.raises(OperateError, match=r"run 7 has it\. Nothing was sent to it; end that run first"):
            perform(job, connect(job, controller.link), run=9)
        reached = model.reached
        assert (model.run, done) == (7, [])
    finally:
        over.set()
        first.join()
        controller.close()
    assert done[0].operation.state == "idle"
    assert [each.sequence for each in model.received] == list(range(1, len(model.received) + 1))
    assert len(model.received) >= reached


@dataclass
class Contested:
    """Another operation, run 9, writes right after the first order."""

    planned: Link
    orders: list[Order] = field(default_factory=list)

    def look(self) -> Found:
        return Found(Status(1, "stopped", jet_on=False, heartbeat=5, accepted=0, check=0, reached=0, inputs=0), 9, 5)

    def exchange(self, order: Order) -> Status:
        self.orders.append(order)
        return self.planned.exchange(order)

    def close(self) -> None:
        self.planned.close()


def test_of_two_that_begin_at_once_the_earlier_leaves_the_controller_to_the_later(job: Job) -> None:
    link = Contested(planned_link(job, terms_of(small_cell(), job)))
    with pytest.raises(OperateError, match="run 9 took the controller over as this one began"):
        perform(job, link)
    assert {order.command for order in link.orders} == {"stop"}


def test_a_valve_that_stays_open_is_not_called_shut(job: Job, controller: ModbusController) -> None:
    model = controller.model = model_of(job, haste=1.0, stuck=True)
    stops: list[Event] = []
    model.at_node = lambda sequence: stops.append("stop") if sequence == 12 else None
    done = perform(job, connect(job, controller.link), controls=lambda: stops.pop() if stops else None)
    assert done.operation.not_shut == "a valve is still open after 0.1 s"
    assert entries(done)[-1][1] == "not shut"
    assert replay(done.log.render(), "run.csv")[-1] == done.operation


def test_a_stop_shuts_the_jet_before_anything_else(job: Job, controller: ModbusController) -> None:
    model = controller.model = model_of(job, haste=1.0)
    stops: list[Event] = []
    model.at_node = lambda sequence: stops.append("stop") if sequence == 12 else None
    done = perform(job, connect(job, controller.link), controls=lambda: stops.pop() if stops else None)
    assert done.operation.state == "idle"
    assert not model.open
    assert [row[1] for row in entries(done)][-2:] == ["stop", "shut"]


def test_a_pause_of_ours_that_lets_the_watchdog_expire_is_a_fault_and_no_node_is_left_out(
    job: Job, controller: ModbusController
) -> None:
    """The controller has emptied its queue then: what we would send next follows on nodes that it never reached."""
    model = controller.model = model_of(job, haste=1.0)
    starved: list[int] = []

    def controls() -> None:
        if model.reached >= 12 and not starved:
            starved.append(model.reached)
            time.sleep(1.5 * WATCHDOG_S)
            wait_for(lambda: not model.open, "the watchdog")

    done = perform(job, connect(job, controller.link), controls=controls, watchdog_s=WATCHDOG_S)
    assert done.operation.state == "faulted"
    assert "the controller's watchdog of 0.4 s expired" in done.operation.reason
    assert [on for _, on in model.switched] == [True, False]
    assert entries(done)[-1][1] == "shut"


@pytest.mark.parametrize("command", ["run", "home"])
def test_a_controller_whose_watchdog_expired_stays_stopped_until_another_run(command: str, job: Job) -> None:
    model = model_of(job)
    beat = {"home": HOME, "run": RUN}[command], 1, 20, 7
    model.order((1, *beat), None, 0)
    model.tick(time.monotonic() + 1.0)
    assert model.command == STOP
    model.order((2, *beat), None, 0)
    assert (model.command, model.permitted) == (STOP, False)
    model.order((3, *beat[:-1], 8), None, 0)
    assert model.command == beat[0]


def test_a_defect_of_ours_shuts_the_jet_before_it_is_reported(job: Job, controller: ModbusController) -> None:
    model = controller.model = model_of(job, haste=1.0)

    def controls() -> None:
        if model.reached >= 12:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        perform(job, connect(job, controller.link), controls=controls)
    assert [on for _, on in model.switched] == [True, False]
    assert model.command == STOP


def run_command(folder: Path, port: int) -> "subprocess.Popen[str]":
    file = folder / "board.csv"
    file.write_text(table(400, 5000))
    words = [
        "operate",
        str(file),
        "--cell",
        str(write_cell(folder, modbus(port), WATCHDOG_S)),
        "--log",
        str(folder / "run.csv"),
    ]
    code = "from commandline.start import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", code, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, env={**os.environ, "COLUMNS": "200"},
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_process_that_is_killed_or_interrupted_leaves_no_jet_on(
    number: signal.Signals, controller: ModbusController, tmp_path: Path
) -> None:
    model = controller.model = model_of(job_of(table(400, 5000)), haste=1.0)
    reached = threading.Event()
    model.at_node = lambda sequence: reached.set() if sequence == 20 else None
    process = run_command(tmp_path, controller.port)
    assert reached.wait(WAIT_S)
    assert model.open
    process.send_signal(number)
    out, err = process.communicate(timeout=WAIT_S)
    wait_for(lambda: not model.open, "the watchdog")
    left = model.reached
    time.sleep(2 * WATCHDOG_S)
    assert model.reached == left
    log = tmp_path / ("run.csv.part" if number == signal.SIGKILL else "run.csv")
    assert ",reached,10,running,10,doRing" in log.read_text()
    if number == signal.SIGINT:
        assert process.returncode == 130, err
        assert "nothing goes on by itself; --from 3" in out
        assert replay(log.read_text(), log)[-1].state == "idle"
