"""Faults of an operation by kind: what causes each on a model controller, and the reason that has to be reported."""

import csv
import threading
from collections.abc import Callable

from model_controller import Controller, ModelController
from operated import BOARD, DOOR, EMERGENCY, HOMED, WATCHDOG_S, Done, connect, model_of, perform

from robotcell.operate.nodes import Job


def cut(controller: Controller, _: ModelController) -> None:
    threading.Thread(target=controller.cut, daemon=True).start()


def restart(_: Controller, model: ModelController) -> None:
    model.restart()


def lose(number: int) -> Callable[[Controller, ModelController], None]:
    def change(_: Controller, model: ModelController) -> None:
        model.set_input(number, on=False)

    return change


def late(_: Controller, model: ModelController) -> None:
    model.acknowledge_after_s = 5.0


def never(_: Controller, model: ModelController) -> None:
    model.ignores_from = 0


def wrong(_: Controller, model: ModelController) -> None:
    model.spoil_at = model.accepted + 1


def halt(_: Controller, model: ModelController) -> None:
    model.halted = True


KINDS: dict[str, tuple[Callable[[Controller, ModelController], None], str]] = {
    "link cut": (cut, "the link is cut"),
    "acknowledgement late": (late, "queue ran dry with the jet on"),
    "acknowledgement missing": (never, "queue ran dry with the jet on"),
    "program halted": (halt, "its program has halted"),
    "acknowledgement wrong": (wrong, "is that of another content"),
    "part removed": (lose(BOARD), "part_present is not met"),
    "home lost": (lose(HOMED), "homed is not met"),
    "emergency stop": (lose(EMERGENCY), "emergency_stop is not met"),
    "door opened": (lose(DOOR), "door_closed is not met"),
    "server restarted": (restart, "the controller was started anew"),
}


def jet_off_after(done: Done, model: ModelController) -> float:
    """Seconds from the entry of the fault in the log to the last valve shutting; 0 where that came first."""
    index = next(at for at, row in enumerate(entries(done)) if row[3] == "faulted")
    detected = done.begun + done.log.seconds[index]
    return max(0.0, model.switched[-1][0] - detected) if model.switched else 0.0


def entries(done: Done) -> list[list[str]]:
    return list(csv.reader(line for line in done.log.lines if line[0].isdigit()))


def inject(
    job: Job, kind: str, at: int, controller: Controller, watchdog_s: float = WATCHDOG_S
) -> tuple[Done, ModelController]:
    """Operate, with a fault when a node is reached."""
    act, _ = KINDS[kind]
    model = controller.model = model_of(job, haste=1.0)

    def watch(sequence: int) -> None:
        if sequence == at:
            act(controller, model)

    model.at_node = watch
    return perform(job, connect(job, controller.link), run=at, watchdog_s=watchdog_s), model
