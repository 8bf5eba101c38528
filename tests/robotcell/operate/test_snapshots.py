"""What is shown of an operation at any moment: joints between nodes, quantities, and how old they are."""

import pytest
from operated import job_of, small_cell, table
from paced import EXCHANGE_S, STEP_S, Paced

from robotcell.operate.drive import Drive, Snapshot, planned_link, terms_of
from robotcell.operate.log import Log


def watched(breaks_at: float = float("inf")) -> tuple[Drive, Paced, list[tuple[float, Snapshot]]]:
    """A drive of nine nodes, and what it shows at each look of the operator."""
    job = job_of(table(9, round(1e6 * STEP_S)))
    terms = terms_of(small_cell(), job)
    paced = Paced(planned_link(job, terms), breaks_at=breaks_at)
    seen: list[tuple[float, Snapshot]] = []
    log = Log("small", job.sha256, terms.rules)
    drive = Drive(job, terms, paced, log, clock=paced.clock, rest=paced.rest)
    drive.controls = lambda: seen.append((paced.now, drive.snapshot()))
    drive.perform()
    return drive, paced, seen


def test_joints_are_those_on_the_straight_way_between_nodes() -> None:
    drive, paced, seen = watched()
    assert drive.operation.state == "end"
    between = [(now, each) for now, each in seen if each.state == "running" and each.joints]
    assert len(between) > 50
    for now, each in between:
        at = min(1.0 + (now - paced.began) / STEP_S, 9.0)
        # The first joint of the table goes by 0.01371 degrees a node; what is shown lags by one exchange and a rest.
        assert each.joints[0] / 0.01371 == pytest.approx(at, abs=0.12)
        assert each.node is not None
        assert each.node.number <= at + 1e-9


def test_what_is_shown_is_as_old_as_the_last_exchange() -> None:
    _, _, seen = watched()
    assert {each.age_s for _, each in seen if each.state == "running"}
    assert all(EXCHANGE_S - 1e-9 <= each.age_s < 3 * EXCHANGE_S + 0.01 for _, each in seen)
    scale, offset = 2.0, 0.0
    assert [each.quantities for _, each in seen][-1] == {"resistivity_mohm_cm": scale * 0.5 + offset}
    assert all(seen[-1][1].conditions.values())


def test_after_the_link_is_cut_the_age_grows() -> None:
    drive, paced, _ = watched(breaks_at=0.3)
    assert drive.operation.state == "faulted"
    before = drive.snapshot().age_s
    paced.now += 7.0
    assert drive.snapshot().age_s == pytest.approx(before + 7.0)
