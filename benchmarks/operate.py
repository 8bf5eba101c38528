"""Nodes a second over each link, the latency of an acknowledgement, and how fast a fault shuts the jet.

Run: ``OMP_NUM_THREADS=1 python benchmarks/operate.py [NODES]``

The servers are real and run in this process, which does the controller's work too. The reference is the same operation
without a link: what the state machine, the log and the checksums take.
"""

import gc
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

import numpy as np
from injected_faults import KINDS, inject, jet_off_after
from model_controller import Controller, ModbusController, ModelController, OpcuaController
from operated import Done, connect, dry_run, job_of, model_of, perform, table

from robotcell.operate.handshake import Found, Link, Order, Status

WATCHDOG_S = 0.06
CYCLE_S = 0.02
"""Longest time between two cycles of a controller with which a fault counts as measured."""
BINS_MS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 1e9)


@dataclass(slots=True)
class Timed:
    """A link whose exchanges are timed."""

    link: Link
    seconds: list[float] = field(default_factory=list[float])

    def exchange(self, order: Order) -> Status:
        """Exchange, and note how long it took."""
        begun = time.perf_counter()
        status = self.link.exchange(order)
        self.seconds.append(time.perf_counter() - begun)
        return status

    def look(self) -> Found | None:
        """Look at the controller."""
        return self.link.look()

    def close(self) -> None:
        """End the connection."""
        self.link.close()


def measure(name: str, nodes: int, controller: Controller, link: str) -> None:
    job = job_of(table(nodes))
    controller.model = model = model_of(job)
    timed = Timed(connect(job, link))
    begun, used = time.perf_counter(), time.process_time()
    done = perform(job, timed)
    wall, cpu = time.perf_counter() - begun, time.process_time() - used
    begun = time.process_time()
    dry_run(job)
    alone = time.process_time() - begun
    in_order = [each.sequence for each in model.received] == list(range(1, nodes + 1))
    print(f"{name}: {done.operation.state}, {len(model.received)} of {nodes} received, in order: {in_order}")
    print(f"  {nodes / wall:.0f} nodes/s, {nodes / cpu:.0f} per second of CPU, {cpu / alone:.1f} x without a link")
    counts, _ = np.histogram(1e3 * np.array(timed.seconds), BINS_MS)
    median, late, worst = 1e3 * np.percentile(timed.seconds, (50, 99, 100))
    print(f"  an exchange takes {median:.2f} ms at the median, {late:.2f} at 99 %, {worst:.1f} at most")
    for low, high, count in zip(BINS_MS, BINS_MS[1:], counts, strict=False):
        print(f"  {f'{low:g} to {high:g} ms' if high < 1e9 else f'from {low:g} ms':>16} {count:6d}")


def measure_faults(controller: Controller, each: int) -> None:
    job = job_of(table(40, 2000))
    print(f"\nfaults, {each} of each kind: seconds from the log's entry until every valve is shut")
    for kind in KINDS:
        shut: list[float] = []
        for at in range(each):
            done, model = inject(job, kind, 5 + 2 * at, controller, WATCHDOG_S)
            time.sleep(2.0 * WATCHDOG_S)
            assert done.operation.state == "faulted"
            if kind == "link cut":
                controller.serve_again()
            if not is_starved(done, model):
                assert not model.open
                shut.append(jet_off_after(done, model))
        if not shut:
            print(f"  {kind:<24} not measured: the machine is starved")
            continue
        print(
            f"  {kind:<24} at most {1e3 * max(shut):6.1f} ms, at the median {1e3 * float(np.median(shut)):6.1f} ms, "
            f"{len(shut)} of {each} measured"
        )


def is_starved(done: Done, model: ModelController) -> bool:
    """Whether this process waited for a core longer than a controller's cycle, or than its watchdog.

    The controller is a thread of ours, and cannot shut a valve while it waits; then nothing is measured. An operation
    whose watchdog expired for that ends as faulted, by another fault than the one that was to be injected.
    """
    return model.longest_cycle_s > CYCLE_S or "watchdog" in done.operation.reason


def main(words: list[str]) -> None:
    nodes = int(words[0]) if words else 10_000
    served = ModbusController(model_of(job_of(table(5))))
    measure("Modbus TCP", nodes, served, served.link)
    measure_faults(served, 12)
    served.close()
    begun = time.perf_counter()
    server = OpcuaController(model_of(job_of(table(5))))
    print(f"\nan OPC UA server begins in {time.perf_counter() - begun:.1f} s")
    gc.collect()
    gc.freeze()  # as the command does; a collection of the server's half a million objects is not the controller's
    measure("OPC UA", nodes, server, server.link)
    measure_faults(server, 12)
    server.close()


if __name__ == "__main__":
    main(sys.argv[1:])
