"""The rules of the interface: the reference controller keeps all, and one that breaks a rule is found by that one."""

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from model_controller import HOLD, HOME, RUN, STOP, Received
from operated import ALL_MET, DOOR, connect, job_of, small_cell, table

from robotcell.operate.handshake import Link
from robotcell.operate.interface import link_of
from robotcell.operate.reference.conformance import RULES, check_rules
from robotcell.operate.reference.program import HOMING, STOPPED, ControllerProgram, program_for
from robotcell.operate.reference.servers import serve

_AT_ONCE = 6
PAGE = Path(__file__).parents[3] / "docs" / "operating.md"


class Deaf(ControllerProgram):
    @property
    def taken(self) -> int:
        return 5


class Secret(ControllerProgram):
    def _command(self, command: int, *, permitted: bool) -> None:
        super()._command(command, permitted=permitted)
        self.mode = STOPPED if command == RUN else self.mode


class NeverHome(ControllerProgram):
    def _command(self, command: int, *, permitted: bool) -> None:
        super()._command(command, permitted=permitted)
        self.mode = HOMING if command == HOME else self.mode


class WrongSum(ControllerProgram):
    def _receive(self, node: Received, check: int) -> None:
        super()._receive(node, check)
        self.check ^= 1


class Skips(ControllerProgram):
    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        if node is not None and beat[1] == RUN and node.sequence > self.accepted + 1 and self.run == beat[4]:
            self.accepted = node.sequence - 1
        super().order(beat, node, check)


class Again(ControllerProgram):
    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        if node is not None and beat[1] == RUN and node.sequence < self.accepted and self.run == beat[4]:
            self.accepted = node.sequence - 1
        super().order(beat, node, check)


class Credulous(ControllerProgram):
    def _receive(self, node: Received, check: int) -> None:
        before = self.accepted
        super()._receive(node, check)
        if self.accepted == before:
            self.accepted, self.check = node.sequence, check
            self.queue.append(node)


class Keeps(ControllerProgram):
    def _begin(self, run: int) -> None:
        left = [*self.queue]
        super()._begin(run)
        self.queue.extend(left)


class Early(ControllerProgram):
    def tick(self, now: float) -> None:
        self.haste = 0.0 if self.queue and self.queue[0].lasts_us < 1_000_000 and not self._opens() else 1.0
        super().tick(now)

    def _opens(self) -> bool:
        return any(each.outputs[index] for each in self.queue for index in self.valves)


class OpensEarly(ControllerProgram):
    def _switch(self) -> None:
        super()._switch()
        opens = any(each.outputs[index] for each in self.queue for index in self.valves)
        self.open = self.open or (opens and self.permitted and self.command == RUN)


class Unpermitted(ControllerProgram):
    def _switch(self) -> None:
        permitted, self.permitted = self.permitted, True
        super()._switch()
        self.permitted = permitted


class SpraysOn(ControllerProgram):
    def _switch(self) -> None:
        before = self.open
        super()._switch()
        self.open = self.open or (before and self.command == HOLD)


class Remembers(ControllerProgram):
    def _command(self, command: int, *, permitted: bool) -> None:
        left = [*self.queue]
        super()._command(command, permitted=permitted)
        self.queue[:] = left


class StuckDry(ControllerProgram):
    def _command(self, command: int, *, permitted: bool) -> None:
        if command == STOP and self.command == RUN and not self.queue and self.at is not None:
            return
        super()._command(command, permitted=permitted)


class Unwatched(ControllerProgram):
    def _expire(self) -> None:
        """It goes on."""


class Forgives(ControllerProgram):
    def order(self, beat: tuple[int, int, int, int, int], node: Received | None, check: int) -> None:
        self._expired = False
        super().order(beat, node, check)


BROKEN: dict[str, type[ControllerProgram]] = {
    "heartbeat": Deaf, "second start": Secret, "home": NeverHome, "checksum": WrongSum, "next node": Skips,
    "node once": Again, "bad node": Credulous, "new run": Keeps, "time": Early, "outputs": OpensEarly,
    "interlock lost": Unpermitted, "hold": SpraysOn, "stop": Remembers, "queue ran dry": StuckDry,
    "watchdog": Unwatched, "watchdog stays": Forgives,
}  # fmt: skip
"""A controller that breaks a rule, by the rule."""


def broken(kind: type[ControllerProgram], **differs: int) -> ControllerProgram:
    program = program_for(small_cell())
    return kind(program.valves, differs.get("inputs", ALL_MET), program.readings)


def verdicts(link: Link) -> dict[str, str]:
    try:
        return {each.rule: each.verdict for each in check_rules(small_cell(watchdog_s=0.1), link)}
    finally:
        link.close()


def checked(program: ControllerProgram, kind: str = "modbus") -> dict[str, str]:
    controller = serve(program, small_cell(), link_of(small_cell(), kind), "127.0.0.1", 0)
    try:
        return verdicts(connect(job_of(table(5)), controller.link))
    finally:
        controller.close()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["modbus", "opcua"])
def test_the_reference_controller_keeps_every_rule_that_is_tested(kind: str) -> None:
    found = checked(broken(ControllerProgram), kind)
    assert {rule for rule, verdict in found.items() if verdict != "pass"} == {"inputs", "epoch"}
    assert {*found} == {*RULES}


def test_every_rule_that_is_tested_has_a_controller_that_breaks_it() -> None:
    assert {*BROKEN} == {rule for rule, check in RULES.items() if not isinstance(check, str)}


@pytest.mark.slow
def test_a_controller_that_breaks_one_rule_fails_that_one_alone() -> None:
    """Side by side: a check waits for nearly all of its time."""
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        found = dict(zip(BROKEN, pool.map(lambda kind: checked(broken(kind)), BROKEN.values()), strict=True))
    failed = {rule: [each for each, verdict in seen.items() if verdict == "fail"] for rule, seen in found.items()}
    assert failed == {rule: [rule] for rule in BROKEN}


@pytest.mark.slow
def test_rules_of_valves_are_not_tested_where_an_interlock_is_not_met() -> None:
    found = checked(broken(ControllerProgram, inputs=ALL_MET & ~(1 << DOOR)))
    skipped = {rule for rule, verdict in found.items() if verdict == "not testable"}
    assert skipped >= {"outputs", "interlock lost", "hold", "stop", "queue ran dry", "watchdog", "watchdog stays"}
    assert "fail" not in found.values()


def test_the_document_names_every_rule() -> None:
    section = PAGE.read_text("utf-8").partition("## Checking a controller")[2].partition("\n## ")[0]
    assert re.findall(r"^\| ([a-z ]+) \| [A-Z`]", section, re.MULTILINE) == [*RULES]
