"""A log replays to the same states; one that was changed does not."""

import pytest
from operated import dry_run, job_of, table

from robotcell.operate.handshake import OperateError
from robotcell.operate.log import replay


def test_a_log_replays_to_its_states() -> None:
    done = dry_run(job_of(table(40)))
    states = replay(done.log.render(), "run.csv")
    assert states[-1] == done.operation
    assert len(states) == len(done.log.seconds)


def test_the_same_operation_gives_the_same_bytes() -> None:
    job = job_of(table(40))
    assert dry_run(job).log.render() == dry_run(job).log.render()


def test_the_log_shows_which_valve_is_open_where() -> None:
    rows = [line.split(",") for line in dry_run(job_of(table(9))).log.lines if ",reached," in line]
    assert [row[5] for row in rows] == ["", "", "doRing", "doRing", "doRing", "doRing", "", "", ""]


def test_from_a_node_on_the_jet_is_on_again() -> None:
    rows = [line.split(",") for line in dry_run(job_of(table(9)), first=5).log.lines if ",reached," in line]
    assert [row[5] for row in rows] == ["", "", "", "", "doRing", "doRing", "", "", ""]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("reached,4,running,4", "reached,4,paused,4", "the event reached leads to running at node 4"),
        (",met,door_closed,idle,0,", ",not met,door_closed,idle,0,", "the event arm leads to idle"),
        ("homing,0,\n", "homing,0,doRing\n", "doRing is open, which is not permitted there"),
        (",at home,", ",at work,", "there is no event 'at work'"),
        ("# Washboard operation", "# Other", "it is no log"),
        (",at home,", f",{9999 * '['},", r"run\.csv:\d+: the log cannot be read .{1,1000}$"),
        (
            "reached,4,running,4",
            'reached,4,"running,4',
            r"run\.csv:\d+: the log cannot be read \(unexpected end of data\)\.$",
        ),
        ("reached,4,running,4", "reached,4,running,\u202e", r"the log has running at node \\u202e\.$"),
    ],
)
def test_a_log_that_was_changed_is_found(old: str, new: str, reason: str) -> None:
    text = dry_run(job_of(table(9))).log.render()
    assert old in text
    with pytest.raises(OperateError, match=reason):
        replay(text.replace(old, new, 1), "run.csv")
