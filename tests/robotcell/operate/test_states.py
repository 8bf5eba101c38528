"""The state machine: the jet only while every interlock is met, and nothing goes on by itself."""

import random

import pytest

from robotcell.operate.states import Arm, Event, Fault, Operation, Reached, Rules, Sensed, advance

LAST = 4
INTERLOCKS = frozenset({"emergency_stop", "door_closed"})
SENSORS = frozenset({"part_present", "home", "homed", "end"})
RULES = Rules(INTERLOCKS, SENSORS, LAST)
NAMES = sorted(INTERLOCKS | SENSORS)
BY_THE_OPERATOR: tuple[Event, ...] = ("resume", "reset", "home")
PAUSE: tuple[Event, ...] = ("pause",)
SEQUENCES = 100_000


def after(*events: Event, rules: Rules = RULES) -> Operation:
    operation = Operation(rules)
    for event in events:
        operation = advance(operation, event)
    return operation


def met(*names: str) -> list[Event]:
    return [Sensed(name, met=True) for name in names]


RUNNING: tuple[Event, ...] = (
    *met("emergency_stop", "door_closed"),
    Arm(1),
    *met("part_present"),
    "home",
    *met("home", "homed"),
    "at home",
)


def test_the_operation_goes_through_its_states_in_order() -> None:
    states = ["idle"]
    operation = Operation(RULES)
    for event in (*RUNNING, *(Reached(node) for node in range(1, LAST + 1)), Sensed("end", met=True)):
        operation = advance(operation, event)
        if operation.state != states[-1]:
            states.append(operation.state)
    assert states == ["idle", "armed", "part present", "homing", "running", "end"]


def test_it_is_not_armed_while_an_interlock_is_not_met() -> None:
    operation = after(Sensed("door_closed", met=True), Arm(1))
    assert (operation.state, operation.reason) == ("idle", "emergency_stop is not met")


def test_it_does_not_leave_home_without_the_sensor_of_home() -> None:
    begun = RUNNING[: -len(("home", "homed", "at home"))]
    assert after(*begun, Sensed("homed", met=True), "at home").state == "homing"


@pytest.mark.parametrize("name", ["emergency_stop", "door_closed", "part_present", "homed"])
@pytest.mark.parametrize("paused", [False, True])
def test_a_condition_that_is_lost_on_the_way_is_a_fault(name: str, paused: bool) -> None:
    operation = after(*RUNNING, *PAUSE[:paused], Sensed(name, met=False))
    assert (operation.state, operation.reason) == ("faulted", f"{name} is not met")
    assert operation.command == "stop"
    assert not operation.jet_permitted


def test_a_condition_that_is_met_again_ends_no_fault() -> None:
    operation = after(*RUNNING, Sensed("door_closed", met=False), Sensed("door_closed", met=True), "resume", "at home")
    assert operation.state == "faulted"


def test_pause_holds_on_the_path_and_resume_goes_on_from_there() -> None:
    paused = after(*RUNNING, Reached(1), Reached(2), "pause")
    assert (paused.command, paused.jet_permitted, paused.node) == ("hold", False, 2)
    resumed = advance(paused, "resume")
    assert (resumed.command, resumed.jet_permitted, resumed.node) == ("run", True, 2)


def test_it_ends_after_a_pause_at_the_last_node() -> None:
    reached = [Reached(node) for node in range(1, LAST + 1)]
    assert after(*RUNNING, *reached, "pause", Sensed("end", met=True), "resume").state == "end"


def test_what_the_sensors_showed_of_an_earlier_operation_counts_for_none() -> None:
    operation = after(*RUNNING, Fault("the link is cut"), "reset", Arm(3))
    assert operation.state == "armed"
    assert operation.met == INTERLOCKS
    assert after(*RUNNING, Fault("the link is cut"), "reset", Arm(3), "home", "at home").state == "armed"


def random_event(draw: random.Random) -> Event:
    """Mostly what an operation needs, so that most sequences come to run; any event at any time besides."""
    name = draw.choice(NAMES)
    return draw.choice((
        Sensed(name, met=draw.random() < 0.9),
        Sensed(name, met=True),
        Arm(draw.randint(1, LAST)),
        "home",
        "at home",
        Reached(draw.randint(1, LAST)),
        "pause",
        "resume",
        "stop" if draw.random() < 0.2 else "reset",
        Fault("anything") if draw.random() < 0.2 else "shut",
    ))  # fmt: skip


@pytest.mark.slow
def test_no_sequence_of_events_turns_the_jet_on_without_its_conditions_or_resumes_by_itself() -> None:
    draw = random.Random(15)
    ran, faulted, running = 0, 0, after(*RUNNING)
    for _ in range(SEQUENCES):
        operation, shown = Operation(RULES), dict.fromkeys(NAMES, False)
        if draw.random() < 0.5:
            operation, shown = running, {name: name != "end" for name in NAMES}
        for _ in range(8):
            event = random_event(draw)
            before, operation = operation, advance(operation, event)
            if isinstance(event, Sensed):
                shown[event.name] = event.met
            if operation.jet_permitted:
                ran += 1
                assert operation.state == "running"
                assert all(shown[name] for name in INTERLOCKS | {"part_present"})
            if before.state == "faulted" and operation.state != "faulted":
                faulted += 1
                assert event == "reset"
                assert operation.state == "idle"
            if before.state in ("paused", "idle", "end") and operation.command in ("run", "home"):
                assert isinstance(event, Arm) or event in BY_THE_OPERATOR
    assert ran > SEQUENCES / 2
    assert faulted > SEQUENCES / 100


WAITING = Rules(INTERLOCKS, SENSORS, LAST, frozenset({"clamp", "water"}), frozenset({"clamp"}))


def test_the_robot_does_not_move_before_what_is_waited_for_and_what_is_watched_stops_it() -> None:
    begun = (*met("emergency_stop", "door_closed"), Arm(1))
    assert after(*begun, *met("part_present", "water"), rules=WAITING).state == "armed"
    assert after(*begun, *met("clamp", "water"), rules=WAITING).state == "armed"
    for last in ("part_present", "water", "clamp"):
        others = {"part_present", "water", "clamp"} - {last}
        assert after(*begun, *met(*sorted(others), last), rules=WAITING).state == "part present"
    running = after(
        *begun, *met("part_present", "clamp", "water"), "home", *met("home", "homed"), "at home", rules=WAITING
    )
    assert running.jet_permitted
    assert advance(running, Sensed("water", met=False)).state == "running"
    lost = advance(running, Sensed("clamp", met=False))
    assert (lost.state, lost.reason, lost.jet_permitted) == ("faulted", "clamp is not met", False)
