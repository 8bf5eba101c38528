"""Streams nodes into LinuxCNC's HAL in every servo cycle: run by the Python that has LinuxCNC's module ``hal``.

It uses nothing of Washboard: orders come as lines of JSON, and each is answered by a line with the status. When the
lines end, as where the process that writes them was killed, it stops on the path; valves are shut by HAL's own
watchdog, whose heartbeat is one change of a pin with each order.
"""

import collections
import importlib
import json
import os
import select
import struct
import sys
import time
import zlib
from typing import Any

CYCLE_US = 1000.0
AHEAD = 100
"""Samples in the FIFO, of its 256: the motion follows an order after so many cycles; valves follow at once."""
RAMP_S = 0.2
"""In which a motion along the path stops and starts."""
BACK_S = 0.02
"""In which HAL's thread, of 1 ms, has run."""
NEAR = 1e-4
"""Degrees or mm from home that count as there."""
STOP, HOLD, HOME, RUN = range(4)
STOPPED, HELD, HOMING, AT_HOME, RUNNING = range(5)


def check_of(order: dict[str, Any]) -> int:
    """Give the checksum of a node as it was received."""
    words = (order["Run"], order["Sequence"], order["Node"], order["DurationUs"], order["Routine"])
    values = (*order["Outputs"], *order["Joints"])
    return zlib.crc32(struct.pack(f">5I{len(values)}i", *words, *values))


class Agent:
    """The controller's side of the handshake, on HAL."""

    def __init__(self, config: dict[str, Any]) -> None:
        """Make the pins, and connect them to the signals of the HAL file."""
        self.hal: Any = importlib.import_module("hal")
        self.config = config
        self.digits = [10.0**power for power in config["powers"]]
        self.pins: Any = self.hal.component("washboard")
        bit, whole, read, write = self.hal.HAL_BIT, self.hal.HAL_S32, self.hal.HAL_IN, self.hal.HAL_OUT
        pins = [(name, bit, write) for name in ("permit", "beat", "watch", "home-request", "follow")]
        pins += [("routine", whole, write), ("routine-done", whole, read), ("beat-back", bit, read)]
        pins += [(f"in-{number}", bit, read) for number in config["inputs"]]
        pins += [(f"ai-{number}", self.hal.HAL_FLOAT, read) for number in config["sensors"]]
        for pin in pins:
            self.pins.newpin(*pin)
        self.pins.ready()
        for name, *_ in pins:
            self.hal.connect(f"washboard.{name}", f"wb-{name}")
        key = self.hal.streamer_base + config["streamer"]
        self.stream: Any = self.hal.stream(self.pins, key, config["format"])
        self.joints = [float(value) for value in self._standing()]
        self.outputs = [0] * len(config["powers"])
        self.queue: collections.deque[dict[str, Any]] = collections.deque()
        self.marks: collections.deque[tuple[int, int]] = collections.deque()
        self.pushed = self.accepted = self.check = self.reached = self.run = 0
        self.command, self.mode, self.heartbeat, self.rate = STOP, STOPPED, -1, 0.0
        self.taken, self.beat_at = 0, 0.0
        self.into_us = 0.0
        self.routine: tuple[int, int] | None = None
        self._push(0)

    def _standing(self) -> list[float]:
        """Joints as HAL has them now."""
        return [self.hal.get_value(f"wb-joint-{index}") for index in range(self.config["dof"])]

    def order(self, order: dict[str, Any]) -> None:
        """Take an order."""
        if order["Heartbeat"] != self.heartbeat:
            self.heartbeat = order["Heartbeat"]
            if self.pins["beat-back"] == self.pins["beat"]:
                self.pins["beat"], self.beat_at = not self.pins["beat"], time.monotonic()
        if order["Run"] != self.run:
            self.run, self.accepted, self.check, self.reached = order["Run"], 0, 0, 0
            self._drop()
            self.pins["watch"] = False
        elif not self.pins["watch"]:
            self.pins["watch"] = True
        if order["Command"] == HOME and self.command != HOME:
            self._drop()
            self.pins["follow"], self.pins["home-request"] = False, True
        if order["Command"] == RUN and self.command == HOME:
            # The place where the robot stands is streamed before HAL follows the stream.
            self.joints = [float(value) for value in self.config["home"]]
            self._push(0)
            while self.stream.depth:
                time.sleep(0.001)
            self.pins["follow"], self.pins["home-request"] = True, False
            self.rate = 1.0  # a program begins at rest
        self.command = order["Command"]
        self.pins["permit"] = bool(order["JetPermitted"]) and self.command == RUN
        if self.command == RUN and order["Sequence"] == self.accepted + 1:
            self.accepted, self.check = order["Sequence"], check_of(order)
            self.queue.append(order)

    def _drop(self) -> None:
        self.queue.clear()
        self.marks.clear()
        self.routine, self.into_us = None, 0.0

    def pump(self) -> None:
        """Fill the FIFO, and note what HAL has taken from it."""
        goal = 1.0 if self.command == RUN else 0.0
        while self.stream.depth < AHEAD and self.stream.writable:
            step = CYCLE_US / 1e6 / RAMP_S
            self.rate = min(self.rate + step, goal) if self.rate < goal else max(self.rate - step, goal)
            if not self._sample(CYCLE_US * self.rate):
                break
        played = self.pushed - self.stream.depth
        while self.marks and self.marks[0][0] <= played:
            self.reached = self.marks.popleft()[1]
        if self.routine is not None and self.routine[0] <= played:
            self.pins["routine"] = self.routine[1]
            if self.pins["routine-done"] == self.routine[1]:
                self.pins["routine"], self.routine = 0, None
        if self.command == STOP and self.rate == 0.0 and self.queue:
            self._drop()

    def _sample(self, by_us: float) -> bool:
        """Go on along the path by so much of its time, and write where that is; ``False`` where nothing moves."""
        if self.routine is not None or not self.queue or by_us == 0.0:
            self.rate = 0.0 if not self.queue or self.routine is not None else self.rate
            return False
        self.into_us += by_us
        sequence = 0
        while self.queue and self.queue[0]["DurationUs"] <= self.into_us + 1e-6 and self.routine is None:
            node = self.queue.popleft()
            self.into_us -= node["DurationUs"]
            self.joints = [value / 1e5 for value in node["Joints"]]
            self.outputs, sequence = node["Outputs"], node["Sequence"]
            if node["Routine"]:
                self.routine = (self.pushed + 1, node["Routine"])
        if not self.queue or self.routine is not None:
            self.into_us = 0.0
        self._push(sequence)
        return True

    def _push(self, sequence: int) -> None:
        """Write a sample: joints on the way to the next node, outputs, and the last node's sequence number."""
        place = self.joints
        if self.queue and self.into_us:
            share = self.into_us / self.queue[0]["DurationUs"]
            place = [a + share * (b / 1e5 - a) for a, b in zip(self.joints, self.queue[0]["Joints"])]  # noqa: B905
        values = [
            bool(value) if kind == "b" else value if kind == "s" else value / scale
            for value, scale, kind in zip(self.outputs, self.digits, self.config["kinds"])  # noqa: B905
        ]
        self.last = sequence or getattr(self, "last", 0)
        self.stream.write((*place, *values, self.last))
        self.pushed += 1
        if sequence:
            self.marks.append((self.pushed, sequence))

    def status(self) -> dict[str, Any]:
        """Give the status after an order."""
        # The beat comes back by way of HAL's thread: it does not where that has halted.
        if self.pins["beat-back"] == self.pins["beat"] or time.monotonic() - self.beat_at < BACK_S:
            self.taken = self.heartbeat
        near = all(abs(a - b) <= NEAR for a, b in zip(self._standing(), self.config["home"]))  # noqa: B905
        guarded = bool(self.hal.get_value("wb-watchdog-ok"))
        mode = {STOP: STOPPED, HOLD: HELD, HOME: AT_HOME if near and guarded else HOMING, RUN: RUNNING}[self.command]
        if self.command == RUN and not guarded:
            mode = STOPPED
        return {
            "Epoch": os.getpid() % 0x10000,
            "Mode": mode,
            "JetOn": any(self.hal.get_value(f"wb-out-{name}") for name in self.config["valves"]),
            "HeartbeatTaken": self.taken,
            "Accepted": self.accepted,
            "AcceptedCheck": self.check,
            "Reached": self.reached,
            "Inputs": sum(1 << number for number in self.config["inputs"] if self.pins[f"in-{number}"]),
            "Readings": [round(1e6 * self.pins[f"ai-{number}"]) for number in self.config["sensors"]],
        }

    def stop(self) -> None:
        """Shut the valves, and come to rest on the path."""
        self.pins["permit"] = False
        self.command = HOLD
        end = time.monotonic() + 2.0 * RAMP_S
        while self.rate > 0.0 and time.monotonic() < end:
            self.pump()
            time.sleep(0.001)


def main() -> None:
    """Serve orders from the standard input until it ends."""
    pending, agent = b"", None
    while True:
        if select.select([0], [], [], 0.001)[0]:
            data = os.read(0, 65536)
            if not data:
                break
            *lines, pending = (pending + data).split(b"\n")
            for line in lines:
                words = json.loads(line)
                if agent is None:
                    agent = Agent(words)
                    answer: dict[str, Any] = {}
                else:
                    agent.order(words)
                    agent.pump()
                    answer = agent.status()
                sys.stdout.write(json.dumps(answer) + "\n")
                sys.stdout.flush()
        if agent is not None:
            agent.pump()
    if agent is not None:
        agent.stop()


if __name__ == "__main__":
    main()
