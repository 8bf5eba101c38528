"""LinuxCNC: joints and outputs are streamed into HAL in every servo cycle, by an agent in LinuxCNC's own Python."""

import json
import os
import select
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotcell.cell.load import LoadedCell
from robotcell.cell.operate_spec import LinuxcncLink
from robotcell.operate.handshake import LinkError, OperateError, Order, Status, order_values, read_status
from robotcell.operate.nodes import JOINT_DIGITS, OUTPUT_DIGITS, Job

_AGENT = Path(__file__).with_name("linuxcnc_agent.py")
_MOST_PINS = 21
_START_S = 10.0
_PINS = {"digital": "b", "group": "s", "analog": "f"}


@dataclass(slots=True)
class _Linuxcnc:
    """The agent's process."""

    process: "subprocess.Popen[bytes]"
    timeout_s: float
    _pending: bytes = b""

    def look(self) -> None:
        """HAL has one component of the agent's name: a second agent does not start."""

    def exchange(self, order: Order) -> Status:
        """Write an order as a line, read the line of the status."""
        return read_status(self.request(order_values(order), self.timeout_s))

    def request(self, words: dict[str, Any], timeout_s: float) -> dict[str, Any]:
        """Write a line, and read the answer.

        Raises:
            LinkError: the process has ended, or does not answer.
        """
        sender, receiver = self.process.stdin, self.process.stdout
        assert sender is not None
        assert receiver is not None
        try:
            sender.write(json.dumps(words).encode() + b"\n")
            sender.flush()
        except OSError:
            raise self._ended() from None
        until = time.monotonic() + timeout_s
        while b"\n" not in self._pending:
            if not select.select([receiver], [], [], max(0.0, until - time.monotonic()))[0]:
                raise LinkError(f"the agent on LinuxCNC's HAL did not answer in {timeout_s:g} s")
            data = os.read(receiver.fileno(), 65536)
            if not data:
                raise self._ended()
            self._pending += data
        line, self._pending = self._pending.split(b"\n", 1)
        return json.loads(line)

    def _ended(self) -> LinkError:
        """Give the error of an agent that has ended, with the last line that it printed."""
        self.process.kill()
        self.process.wait()
        errors = self.process.stderr.read().decode("utf-8", "replace") if self.process.stderr is not None else ""
        last = (errors.strip().splitlines() or ["it printed nothing"])[-1]
        return LinkError(f"the agent on LinuxCNC's HAL has ended ({last})")

    def close(self) -> None:
        """End the agent, which stops on the path with every valve shut."""
        if self.process.stdin is not None:
            with suppress(OSError):  # it has ended already
                self.process.stdin.close()
        try:
            self.process.wait(5.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        for stream in (self.process.stdout, self.process.stderr):
            if stream is not None:
                stream.close()


def open_linuxcnc(spec: LinuxcncLink, job: Job, timeout_s: float) -> _Linuxcnc:
    """Start the agent on a HAL that runs the file of ``hal_text``.

    Args:
        spec: As in the cell.
        job: Its outputs, inputs, sensors and first node, which is home.
        timeout_s: Longest wait for an answer.

    Raises:
        OperateError: the Python is missing, or HAL does not run or lacks the signals.
    """
    outputs = job.io.outputs.values()
    kinds = "".join(_PINS[each.kind] for each in outputs)
    config = {
        "dof": len(job.joints),
        "format": "f" * len(job.joints) + kinds + "s",
        "kinds": kinds,
        "powers": [OUTPUT_DIGITS if each.kind == "analog" else 0 for each in outputs],
        "valves": job.valves,
        "inputs": [each.number for each in job.io.inputs.values()],
        "sensors": [each.number for each in job.io.sensors.values()],
        "home": [value / 10**JOINT_DIGITS for value in job.nodes[0].joints],
        "streamer": spec.streamer,
    }
    pipe = subprocess.PIPE
    try:
        # In a session of its own: Ctrl-C is for us alone, and the agent comes to rest on the path.
        process = subprocess.Popen(
            [spec.python, str(_AGENT)], stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True
        )
    except OSError as error:
        raise OperateError(f"{spec.python} cannot be started ({error.strerror}): name LinuxCNC's Python.") from None
    link = _Linuxcnc(process, timeout_s)
    try:
        link.request(config, _START_S)
    except LinkError as error:
        link.close()
        raise OperateError(f"{error}. Does HAL run, with the file of `washboard operate --hal`?") from None
    return link


def hal_text(loaded: LoadedCell) -> str:
    """Write the HAL file of a cell: stream, way home, watchdog, and the gates of the valves, in the servo thread.

    Each valve is open while the stream has it open and the jet is permitted, the watchdog has not expired and every
    interlock is met; all of that in each cycle of HAL, whatever the processes do.

    Raises:
        OperateError: the cell's link is another one, or it has more pins than a stream carries.
    """
    spec, robot = loaded.spec.operate, loaded.cell.robot
    if spec is None or not isinstance(spec.link, LinuxcncLink):
        raise OperateError(f"cell {loaded.spec.cell} is not operated by the link linuxcnc.")
    outputs = loaded.spec.io.outputs
    pins = "f" * robot.dof + "".join(_PINS[each.kind] for each in outputs.values()) + "s"
    if len(pins) > _MOST_PINS:
        raise OperateError(
            f"joints and outputs are {len(pins)} pins with the counter; a stream of HAL has {_MOST_PINS}."
        )
    valves = list(dict.fromkeys(nozzle.valve for nozzle in loaded.spec.nozzles.values()))
    lines = [
        f"# HAL of washboard operate for cell {loaded.spec.cell}: load it where the thread servo-thread exists.",
        "# Connect wb-joint-N to the joints' position commands, wb-out-NAME to outputs, wb-in-N and wb-ai-N to inputs.",
        *_load(robot.dof, pins, len(valves), len(spec.interlocks), spec.link.streamer),
        f"setp watchdog.timeout-0 {spec.watchdog_s:g}",
        *_joints(loaded, spec.link.streamer),
        "net wb-follow => " + " ".join(f"limit3.{index}.load" for index in range(robot.dof)),
        "net wb-beat => watchdog.input-0",
        f"net wb-beat => xor2.{len(spec.interlocks)}.in0",
        f"net wb-beat-back xor2.{len(spec.interlocks)}.out",
        "net wb-watch => watchdog.enable-in",
        "net wb-watchdog-ok watchdog.ok-out => and2.0.in0",
        "net wb-permit => and2.0.in1",
        *_gates(loaded, valves, spec.link.streamer),
        *(f"newsig {name} s32" for name in ("wb-routine", "wb-routine-done")),
        *(f"newsig wb-ai-{each.number} float" for each in loaded.spec.io.sensors.values()),
    ]
    return "".join(f"{line}\n" for line in lines)


def _load(dof: int, pins: str, valves: int, interlocks: int, streamer: int) -> Iterator[str]:
    yield f"loadrt streamer depth={','.join(['256'] * (streamer + 1))} cfg={','.join([pins] * (streamer + 1))}"
    joints, gates = {"mux2": dof, "limit3": dof}, {"xor2": interlocks + 1, "and2": 1 + interlocks + valves}
    yield from (f"loadrt {kind} count={count}" for kind, count in joints.items())
    yield "loadrt watchdog num_inputs=1"
    yield from (f"loadrt {kind} count={count}" for kind, count in gates.items())
    functions = [f"streamer.{streamer}"]
    functions += [f"{kind}.{index}" for kind, count in joints.items() for index in range(count)]
    functions += ["watchdog.set-timeouts", "watchdog.process"]
    functions += [f"{kind}.{index}" for kind, count in gates.items() for index in range(count)]
    yield from (f"addf {function} servo-thread" for function in functions)


def _joints(loaded: LoadedCell, streamer: int) -> Iterator[str]:
    """Each joint follows the stream, or goes home within half of its speed and acceleration."""
    homes = loaded.spec.home_deg_mm
    for index, (joint, home) in enumerate(zip(loaded.cell.robot.joints, homes, strict=True)):
        unit = joint.unit.per_si
        yield f"net wb-stream-{index} streamer.{streamer}.pin.{index} => mux2.{index}.in0"
        yield f"setp mux2.{index}.in1 {home:g}"
        yield f"net wb-home-request => mux2.{index}.sel"
        yield f"net wb-way-{index} mux2.{index}.out => limit3.{index}.in"
        yield f"setp limit3.{index}.maxv {0.5 * joint.speed * unit:g}"
        yield f"setp limit3.{index}.maxa {0.5 * joint.acceleration * unit:g}"
        yield f"net wb-joint-{index} limit3.{index}.out"


def _gates(loaded: LoadedCell, valves: list[str], streamer: int) -> Iterator[str]:
    """Chain the interlocks, then a gate for each valve; other outputs are those of the stream."""
    spec, io = loaded.spec.operate, loaded.spec.io
    assert spec is not None
    yield from (f"newsig wb-in-{number} bit" for number in sorted(each.number for each in io.inputs.values()))
    for index, condition in enumerate(spec.interlocks.values()):
        yield f"net wb-in-{io.inputs[condition.input].number} => xor2.{index}.in0"
        yield f"setp xor2.{index}.in1 {1 - condition.state}"
        yield f"net wb-met-{index} xor2.{index}.out => and2.{index + 1}.in0"
        yield f"net wb-gate-{index} and2.{index}.out => and2.{index + 1}.in1"
    gate = len(spec.interlocks)
    for index, (name, output) in enumerate(io.outputs.items()):
        pin = f"streamer.{streamer}.pin.{loaded.cell.robot.dof + index}"
        if name not in valves or output.kind != "digital":
            yield f"net wb-out-{name} {pin}"
            continue
        at = 1 + gate + valves.index(name)
        yield f"net wb-set-{name} {pin} => and2.{at}.in0"
        yield f"net wb-gate-{gate} and2.{gate}.out => and2.{at}.in1"
        yield f"net wb-out-{name} and2.{at}.out"
