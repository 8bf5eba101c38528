"""A program as its controller drives it, and as a log shows that it ran."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from installations import small_cell
from robot_programs import PROGRAMS

from programs.driven import drive_program
from programs.errors import ProgramError
from programs.export import export
from programs.native import parse, render
from programs.playback import playback
from programs.pose import Quaternion
from programs.posts.writing.angles import fixed_xyz, moving_zyx, rotation_vector
from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from programs.run_log import program_of_log, read_run_log
from programs.summary import jet_seconds
from specs.source import NO_SOURCE, Source


def driven(made: str) -> tuple[TimedProgram, TimedProgram]:
    program = PROGRAMS[made]()
    return program, export(program, small_cell("kuka"), "kuka").drive(program)


@pytest.mark.parametrize("made", ["three_speeds", "faces", "two_tools", "in_flight", "loop"])
def test_the_paths_are_the_same_and_the_file_is_sound(made: str) -> None:
    program, done = driven(made)
    assert done.totals.travel_mm == pytest.approx(program.totals.travel_mm, rel=1e-3)
    assert [item.spraying for item in done.instructions if isinstance(item, SetNozzle)] == [
        item.spraying for item in program.instructions if isinstance(item, SetNozzle)
    ]
    assert parse(render(done)).totals.moves == done.totals.moves


def test_a_program_at_its_own_times_is_as_it_was() -> None:
    program = PROGRAMS["three_speeds"]()
    end_s = program.instructions[-1].time_s
    jets = [(item.time_s, item.spraying) for item in program.instructions if isinstance(item, SetNozzle)]
    times = np.linspace(0.0, end_s, 200)
    again = playback(drive_program(program, ((0.0, 0.0), (end_s, end_s)), jets), times)
    np.testing.assert_allclose(again.tcp, playback(program, times).tcp, atol=1e-3)
    np.testing.assert_array_equal(again.spraying, playback(program, times).spraying)


def log_of(program: TimedProgram, file: Path, *, until: float = 1.0, shift_mm: float = 0.0) -> Path:
    times = np.arange(0.0, until * program.instructions[-1].time_s, 2e-3)
    states = playback(program, times)
    rows = (
        f"{t:.4f};{x + shift_mm:.4f};{y:.4f};{z:.4f};{int(on)}"
        for t, (x, y, z), on in zip(times, states.tcp.tolist(), states.spraying.tolist(), strict=True)
    )
    file.write_text("\n".join(("time_s;x_mm;y_mm;z_mm;jet", *rows, "")))
    return file


def test_a_log_of_what_was_driven_is_read_back_as_that(tmp_path: Path) -> None:
    program, done = driven("faces")
    found = program_of_log(read_run_log(log_of(done, tmp_path / "run.csv")), program)
    assert found.totals.spray_s == pytest.approx(done.totals.spray_s, abs=0.02)
    times = np.linspace(0.1, done.instructions[-1].time_s - 0.1, 100)
    np.testing.assert_allclose(playback(found, times).tcp, playback(done, times).tcp, atol=0.5)


@pytest.mark.parametrize(
    ("columns", "write"),
    [
        ("qw,qx,qy,qz", lambda q: tuple(2.0 * each for each in q)),
        ("rx_rad,ry_rad,rz_rad", rotation_vector),
        ("a_deg,b_deg,c_deg", moving_zyx),
        ("w_deg,p_deg,r_deg", fixed_xyz),
    ],
)
def test_a_log_states_how_the_tool_is_turned_as_its_controller_writes_it(
    tmp_path: Path, columns: str, write: Callable[[Quaternion], tuple[float, ...]]
) -> None:
    program, done = driven("faces")
    times = np.arange(0.0, done.instructions[-1].time_s, 0.01)
    states = playback(done, times)
    plain = log_of(done, tmp_path / "plain.csv").read_text().splitlines()[1::5]
    turned = (
        f"{row};{';'.join(f'{each:.9g}' for each in write((w, x, y, z)))}"
        for row, (w, x, y, z) in zip(plain, states.quaternion.tolist(), strict=False)
    )
    file = tmp_path / "turned.csv"
    file.write_text("\n".join((f"time_s;x_mm;y_mm;z_mm;jet;{columns.replace(',', ';')}", *turned)))
    log = read_run_log(file)
    assert log.quaternion is not None
    same = np.abs(np.einsum("ij,ij->i", log.quaternion, states.quaternion[: len(log.quaternion)]))
    np.testing.assert_allclose(same, 1.0, atol=1e-9)
    found = playback(program_of_log(log, program), times)
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", found.quaternion, states.quaternion)), 1.0, atol=1e-4)


def test_a_run_that_ended_early_is_judged_as_far_as_it_went(tmp_path: Path) -> None:
    program, done = driven("faces")
    found = program_of_log(read_run_log(log_of(done, tmp_path / "run.csv", until=0.5)), program)
    assert 0.0 < found.totals.spray_s < 0.8 * done.totals.spray_s


@pytest.mark.parametrize("number", [0, -1])
def test_a_valve_that_stays_open_between_two_jets_has_one_in_the_log(tmp_path: Path, number: int) -> None:
    """As it does where it cannot shut for so short a time: of the first jet, and of the last."""
    program, done = driven("faces")
    switches = [at for at, item in enumerate(program.instructions) if isinstance(item, SetNozzle)]
    on, off = (program.instructions[at] for at in list(zip(switches[::2], switches[1::2], strict=True))[number])
    middle_s = 0.5 * (on.time_s + off.time_s)
    gap = [SetNozzle(middle_s, False, on.made_by), SetNozzle(middle_s + 0.05, True, on.made_by)]
    items = sorted((*program.instructions, *gap), key=lambda item: item.time_s)
    shut = replace(program, instructions=tuple(items))
    found = program_of_log(read_run_log(log_of(done, tmp_path / "run.csv")), shut)
    assert found.totals.spray_s == pytest.approx(done.totals.spray_s, abs=0.02)
    assert found.instructions[-1].time_s == pytest.approx(done.instructions[-1].time_s, abs=0.02)


def along_x(*jets: tuple[float, float]) -> TimedProgram:
    """At 10 mm/s along x, with jets between these times."""
    moves = [MoveTo(float(at), (10.0 * at, 0.0, 50.0), (0.0, 1.0, 0.0, 0.0), 10.0, NO_SOURCE) for at in range(11)]
    switches = [
        SetNozzle(at, on, Source.parse(f"sequence[{jet[1]:.0f}]"))
        for jet in jets
        for at, on in zip(jet, (True, False), strict=True)
    ]
    items = sorted((*moves, *switches), key=lambda item: item.time_s)
    return replace(PROGRAMS["three_speeds"](), instructions=tuple(items))


def with_two_loops() -> TimedProgram:
    """Along x with two loops: jets at 1 to 2 and 3 to 4 s, 5 to 6 s, and after both one at 7 to 8 s."""
    program = along_x((1.0, 2.0), (3.0, 4.0), (5.0, 6.0), (7.0, 8.0))
    until = ("3", "UNTIL", "resistivity_mohm_cm", ">=", "1.000")
    marks = [
        Command(time_s, keyword, until if keyword == "REPEAT" else (), NO_SOURCE)
        for begin, end in ((0.5, 4.5), (4.5, 6.5))
        for keyword, time_s in (("REPEAT", begin), ("ENDREPEAT", end))
    ]
    items = sorted((*program.instructions, *marks), key=lambda item: item.time_s)
    return replace(program, instructions=tuple(items))


@pytest.mark.parametrize("first", [1, 2, 3])
@pytest.mark.parametrize("second", [1, 2, 3])
@pytest.mark.parametrize("until", [1.0, 0.75])
def test_loops_are_taken_as_often_as_the_log_has_them(tmp_path: Path, first: int, second: int, until: float) -> None:
    places = [0.0, 0.5]
    for way, rounds in (((0.5, 4.5), first), ((4.5, 6.5), second)):
        places += [each for _ in range(rounds) for each in way]
    places += [6.5, 10.0]
    rows, now = [], 0.0
    for begin, end in zip(places[::2], places[1::2], strict=True):
        at = np.arange(begin, end, 2e-3)
        rows += [(now + each - begin, 10.0 * each, any(on < each < on + 1.0 for on in (1, 3, 5, 7))) for each in at]
        now += end - begin + 0.3  # back to where it began
    text = [f"{time:.4f};{x:.4f};0;50;{jet:d}" for time, x, jet in rows[: round(until * len(rows))]]
    file = tmp_path / "run.csv"
    file.write_text("\n".join(("time_s;x_mm;y_mm;z_mm;jet", *text)))
    found = program_of_log(read_run_log(file), with_two_loops())
    expected = {1.5: first, 3.5: first, 5.5: second, 7.5: 1}
    middles = [0.5 * (begin + end) for begin, end in zip(*[iter(jets_of(found))] * 2, strict=True)]
    seen = [round(float(playback(found, np.array([each])).tcp[0, 0]) / 10.0 * 2) / 2 for each in middles]
    counts = {place: seen.count(place) for place in expected}
    if until == 1.0:
        assert counts == expected
        assert found.totals.spray_s == pytest.approx(2 * first + second + 1, abs=0.05)
    else:
        assert sum(counts.values()) <= sum(expected.values())
    sources = {str(source) for source in jet_seconds(found)}
    assert sources <= {"sequence[2]", "sequence[4]", "sequence[6]", "sequence[8]"}


def test_two_loops_that_may_run_often_are_taken_as_often_as_the_log_has_them(tmp_path: Path) -> None:
    """400 ways to run them: the first 13 times, the second 7 times."""
    program = with_two_loops()
    often = [
        replace(item, arguments=("20", *item.arguments[1:])) if getattr(item, "keyword", "") == "REPEAT" else item
        for item in program.instructions
    ]
    places = [0.0, 0.5, *(0.5, 4.5) * 13, *(4.5, 6.5) * 7, 6.5, 10.0]
    rows, now = [], 0.0
    for begin, end in zip(places[::2], places[1::2], strict=True):
        at = np.arange(begin, end, 0.01)
        rows += [(now + each - begin, 10.0 * each, any(on < each < on + 1.0 for on in (1, 3, 5, 7))) for each in at]
        now += end - begin + 0.3
    file = tmp_path / "run.csv"
    file.write_text("\n".join(("time_s;x_mm;y_mm;z_mm;jet", *(f"{t:.4f};{x:.4f};0;50;{on:d}" for t, x, on in rows))))
    found = program_of_log(read_run_log(file), replace(program, instructions=tuple(often)))
    assert len(jets_of(found)) == 2 * (2 * 13 + 7 + 1)
    assert found.totals.spray_s == pytest.approx(2 * 13 + 7 + 1, abs=0.5)


def jets_of(program: TimedProgram) -> list[float]:
    return [item.time_s for item in program.instructions if isinstance(item, SetNozzle)]


def test_a_valve_that_stays_open_is_no_jet_beside_which_the_next_begins(tmp_path: Path) -> None:
    planned = along_x((1.0, 2.0), (2.05, 2.4), (2.8, 5.0), (7.0, 9.0))
    ran = along_x((1.0, 2.4), (2.8, 5.0), (7.0, 9.0))
    found = program_of_log(read_run_log(log_of(ran, tmp_path / "run.csv")), planned)
    assert found.totals.spray_s == pytest.approx(5.6, abs=0.01)
    seconds = {str(source): each for source, each in jet_seconds(found).items()}
    assert seconds == pytest.approx({"sequence[2]": 1.4, "sequence[5]": 2.2, "sequence[9]": 2.0}, abs=0.01)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no column time_s"),
        ("time_s,x_mm,y_mm,jet\n", "no column z_mm"),
        ("time_s,x_mm,y_mm,z_mm,jet\n0,1,2,x,0\n", "no number in each column"),
        ("time_s,x_mm,y_mm,z_mm,jet\n0,1,2,inf,0\n", "not finite"),
        ("time_s x_mm y_mm z_mm jet\n1 1 2 3 0\n1 1 2 3 1\n", "each row is later"),
        (f"time_s,x_mm,y_mm,z_mm,jet\n{'9' * 140_000},1,2,3,0\n", "csv:2: this is no row of a table"),
        (f"time_s,{'x' * 140_000}\n", "csv:1: this is no row of a table"),
        ("time_ms\tx_mm\ty_mm\tz_mm\tjet\n1\t1\t2\t3\t0\n", "no jet is on"),
    ],
)
def test_a_bad_log_is_refused_with_what_is_wrong(tmp_path: Path, text: str, reason: str) -> None:
    file = tmp_path / "run.csv"
    file.write_text(text)
    with pytest.raises(ProgramError, match=reason):
        read_run_log(file)


def test_the_log_of_another_place_is_refused(tmp_path: Path) -> None:
    program, done = driven("faces")
    with pytest.raises(ProgramError, match="another program"):
        program_of_log(read_run_log(log_of(done, tmp_path / "run.csv", shift_mm=50.0)), program)
