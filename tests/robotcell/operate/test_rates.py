"""Links and controllers that are too slow: refused before anything moves, or stopped with the jet shut."""

import pytest
from operated import job_of, perform, small_cell, table
from paced import Paced

from robotcell.operate.drive import Drive, planned_link, standing, terms_of
from robotcell.operate.handshake import OperateError
from robotcell.operate.log import Log
from robotcell.operate.states import Operation

NODES, STEP_S, WATCHDOG_S = 60, 0.02, 0.1
JOB = job_of(table(NODES, round(1e6 * STEP_S)))
"""The jet is on from node 3 to node 58."""


def driven(first: int = 1, **differences: float) -> tuple[Operation, Paced, Log]:
    terms = terms_of(small_cell(watchdog_s=WATCHDOG_S), JOB)
    paced = Paced(planned_link(JOB, terms), **{"step_s": STEP_S, "exchange_s": 0.001, **differences})
    log = Log("small", JOB.sha256, terms.rules)
    drive = Drive(JOB, terms, paced, log, clock=paced.clock, rest=paced.rest)
    return drive.perform(first), paced, log


def test_the_robot_stands_for_what_the_link_takes_longer_than_a_node() -> None:
    on = 58 - 3
    stood, jet, node = standing(JOB, 1, 0.05, 5)
    assert (stood, jet, node) == (pytest.approx(on * (0.05 - STEP_S)), pytest.approx(on * STEP_S), 4)
    assert standing(JOB, 40, 0.05, 5)[0] == pytest.approx((58 - 40) * (0.05 - STEP_S))
    assert standing(JOB, 1, STEP_S, 5)[0] == pytest.approx(0.0, abs=1e-9)


def test_short_nodes_come_from_the_queue_where_the_link_is_fast_enough_before_them() -> None:
    """Fifteen nodes of 100 ms, then ten of 5 ms: a queue of 20 holds them by then, one of 2 does not."""
    rows = table(25, 100_000).splitlines()
    head = next(at for at, row in enumerate(rows) if row.startswith("1,"))
    for at in range(15, 25):
        number, _, rest = rows[head + at].split(",", 2)
        rows[head + at] = f"{number},{1.4 + 0.005 * (at - 14):.6f},{rest}"
    job = job_of("\n".join(rows) + "\n")
    assert standing(job, 1, 0.02, 20)[0] == 0.0
    assert standing(job, 1, 0.02, 2)[0] > 0.05


@pytest.mark.parametrize("exchange_s", [0.025, 0.05, 0.09])
def test_a_link_that_is_too_slow_for_the_table_is_refused_before_anything_moves(exchange_s: float) -> None:
    reason = f"the link is too slow: an order takes {1e3 * exchange_s:.3g} ms .* from node 4 on more are needed"
    with pytest.raises(OperateError, match=reason):
        driven(exchange_s=exchange_s)


def test_a_link_that_is_fast_enough_ends_the_program() -> None:
    operation, _, _ = driven(exchange_s=0.01)
    assert operation.state == "end", operation.reason


@pytest.mark.parametrize(("step_s", "reason"), [(3 * STEP_S, "late with the jet on"), (1.0, "late with the jet on")])
def test_a_controller_that_is_slower_than_the_plan_sprays_no_longer_than_the_watchdog(
    step_s: float, reason: str
) -> None:
    operation, paced, _ = driven(step_s=step_s)
    assert operation.state == "faulted"
    assert reason in operation.reason
    opened_s = paced.began + 2 * step_s
    planned_s = STEP_S * (operation.node - 3)
    assert paced.now - opened_s < planned_s + step_s + WATCHDOG_S + 0.05


def test_a_pause_is_not_counted_as_late() -> None:
    events = iter([*[None] * 60, "pause", *[None] * 200, "resume"])
    terms = terms_of(small_cell(watchdog_s=WATCHDOG_S), JOB)
    paced = Paced(planned_link(JOB, terms), step_s=STEP_S, exchange_s=0.001)
    drive = Drive(JOB, terms, paced, Log("small", JOB.sha256, terms.rules), clock=paced.clock, rest=paced.rest)
    drive.controls = lambda: next(events, None)  # type: ignore[assignment,return-value]
    assert drive.perform().state == "end", drive.operation.reason


def test_what_io_waits_for_is_awaited_and_named() -> None:
    operation, paced, log = driven(waits_until=2.0)
    assert operation.state == "end", operation.reason
    assert paced.began > 2.0
    assert sum(",met,water,part present," in line for line in log.lines) == 1
    operation, paced, _ = driven(waits_until=60.0)
    assert (operation.state, operation.reason) == ("faulted", "water was not met in 5 s")
    assert paced.now == pytest.approx(5.0, abs=0.2)
    assert paced.began < 0.0


def test_a_run_whose_first_order_nobody_takes_is_refused() -> None:
    class Frozen(Paced):
        def exchange(self, order):  # type: ignore[no-untyped-def]
            return super().exchange(
                order.__class__(**{**{key: getattr(order, key) for key in order.__slots__}, "heartbeat": 9})
            )

    link = Frozen(planned_link(JOB, terms_of(small_cell(), JOB)))
    with pytest.raises(OperateError, match="its program took no order in 4 s"):
        perform(JOB, link)
