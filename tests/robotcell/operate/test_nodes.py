"""Nodes are the rows of the joint table, to the last digit; loops end by their sensor."""

import csv
import itertools
import math

import pytest
from operated import job_of, looped, small_cell, table, write_whole

from programs.errors import ProgramError
from robotcell.operate.nodes import JOINT_DIGITS, TIME_DIGITS, Feed


def test_nodes_have_every_digit_of_the_table() -> None:
    text = table(50, step_us=12_345)
    rows = list(csv.reader(line for line in text.splitlines() if not line.startswith("#")))[1:]
    job = job_of(text)
    assert [[write_whole(value, JOINT_DIGITS) for value in node.joints] for node in job.nodes] == [
        row[2:8] for row in rows
    ]
    assert [write_whole(node.time_us, TIME_DIGITS) for node in job.nodes] == [row[1] for row in rows]
    assert sum(node.lasts_us for node in job.nodes) == job.nodes[-1].time_us


@pytest.mark.parametrize("text", ["0.00000", "-0.00001", "-16.00000", "21474.83647", "0.10000"])
def test_a_number_is_written_as_it_was_read(text: str) -> None:
    assert write_whole(int(text.replace(".", "")), 5) == text


def test_outputs_keep_their_values_until_they_are_set_again() -> None:
    job = job_of(table(9, events={2: "aoPressure = 3.5", 4: "goSolution = 2", 5: "call flip_to_bottom"}))
    values = {name: [node.outputs[index] for node in job.nodes] for index, name in enumerate(job.outputs)}
    assert values["doRing"] == [0, 0, 1, 1, 1, 1, 0, 0, 0]
    assert values["aoPressure"] == [0] + 8 * [3_500_000]
    assert values["goSolution"] == [0, 0, 0] + 6 * [2]
    assert [node.routine for node in job.nodes] == [0, 0, 0, 0, 101, 0, 0, 0, 0]
    assert job.starts == (3,)


LOOP = {2: "repeat 3 until resistivity_mohm_cm >= 1", 4: "end repeat"}


@pytest.mark.parametrize(
    ("shown", "order"),
    [([1.0], [1, 2, 3, 4, 5, 6]), ([0.5, 2.0], [1, 2, 3, 4, 3, 4, 5, 6]), ([0.0] * 3, [1, 2, 3, 4, 3, 4, 3, 4, 5, 6])],
)
def test_a_loop_is_done_until_its_sensor_shows_it_or_its_turns_are_over(shown: list[float], order: list[int]) -> None:
    feed, left, taken = Feed(job_of(looped())), iter(shown), []
    while not feed.is_done:
        if feed.question is not None:
            feed.decide(next(left))
        taken.append(feed.take().number)
    assert taken == order
    assert next(left, None) is None


def test_where_the_tool_has_turned_about_its_jet_the_last_joint_turns_back_before_the_next_turn() -> None:
    lines = looped(step_us=1_000_000).splitlines()
    row = lines[6].split(",")
    lines[6] = ",".join((*row[:7], f"{float(row[7]) + 40.0:.5f}", *row[8:]))
    job = job_of("\n".join(lines) + "\n")
    feed, taken = Feed(job), []
    while feed.question is None:
        taken.append(feed.take())
    feed.decide(0.0)
    begin, end = taken[1], taken[3]
    way = [end]
    while way[-1].joints != begin.joints:
        way.append(feed.take())
    assert {node.number for node in way[1:]} == {begin.number}
    assert not any(job.open_valves(node) for node in way[1:])
    assert {node.joints[:-1] for node in way} == {begin.joints[:-1]}
    joint = small_cell().cell.robot.joints[-1]
    speeds = [
        math.radians(abs(b.joints[-1] - a.joints[-1]) / 1e5) / (b.lasts_us / 1e6) for a, b in itertools.pairwise(way)
    ]
    assert 0.25 * joint.speed < max(speeds) <= 0.5 * joint.speed
    assert feed.take().number == 3


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (table(5).replace("small ", "other "), "the table is that of cell other, not of small"),
        (table(5).replace("elbow_deg", "knee_deg"), "it is no joint table of cell small"),
        (table(5).replace("\n3,", "\n4,"), "has node 4, not 3"),
        (table(5).replace("0.002000", "0.0020"), "has not 6 decimals"),
        (table(5).replace("0.002000", "0.000100"), "earlier than the row before"),
        (table(5, events={2: "doNothing = 1"}), "doNothing is not under io.outputs"),
        (table(5, events={2: f"doRing = {400 * '9'}"}), "doRing = inf is more than a link carries"),
        (table(5, events={2: "call home_again"}), "call home_again has no number; state it under operate.routines"),
        (table(5, events={2: "dance"}), "unknown event"),
        (table(6, events=LOOP), "the loop that ends at node 4 does not begin there"),
        (table(6, events={2: LOOP[2]}), "the loop that begins at node 2 does not end"),
        (looped().replace("0,0,0,1,0,0,0,end", "0,9,0,1,0,0,0,end"), "does not begin there"),
        (looped().replace("0,0,0,1,0,0,0,end", "0,0,0,0,1,0,0,end"), "does not begin there"),
        (table(5).rsplit("node", 1)[0], "it is no joint table"),
        (table(5).replace("-35.01386", "-500.00000"), "wrist_3_deg is -500, and its limits are -360 to 360"),
        (table(5).replace(",0.02742,", ",9.02742,"), "shoulder_pan_deg goes 9.01371 in 0.001 s, faster than its 180 a"),
        ("# Nodes  6\n" + table(5), "ends at node 5 of 6: it was cut off"),
        (table(5).rstrip() + ",more\n", "more or fewer cells than the header"),
        (table(5).rstrip() + "x" * 200_000, "field larger than field limit"),
        (table(5).replace("time_s", "x" * 200_000), "field larger than field limit"),
    ],
)
def test_a_table_that_cannot_be_fed_is_refused(text: str, reason: str) -> None:
    with pytest.raises(ProgramError, match=reason):
        job_of(text)


def test_a_row_that_is_cut_anywhere_is_refused_with_its_line() -> None:
    lines = table(5).splitlines()
    cells = lines[-1].split(",")
    for left in range(1, len(cells)):
        with pytest.raises(ProgramError, match=rf":{len(lines)}: the row cannot be read .it has more or fewer cells"):
            job_of("\n".join([*lines[:-1], ",".join(cells[:left])]))


@pytest.mark.parametrize("at", [-3, -1])
def test_a_quotation_that_is_left_open_ends_with_its_line(at: int) -> None:
    lines = table(5).splitlines()
    lines[at] = lines[at].replace(",", ',"', 1)
    line = len(lines) + at + 1
    with pytest.raises(ProgramError, match=rf":{line}: the row cannot be read \(unexpected end of data\)"):
        job_of("\n".join(lines))
