"""A cell states volts or mA; each language is given the number that means them to its controller."""

from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installations import ARM_LANGUAGES, PRESSURE, for_language, small_cell
from robot_programs import PROGRAMS, command, joints_of
from small_plans import LIMITS, plan_of, spray

from programs.export import export
from programs.motion.analog import IN_OWN_UNIT, Counting
from programs.motion.installation import Channel, Installation, Sensor, Setting
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.program import TimedProgram
from rulesengine.timing.time_plan import time_plan
from specs.finding import Finding

SHARE = Counting(full=1.0, least=0.0, zero_ma=4.0, reads_amperes=True)
WORDS = Counting(full=2000.0, step=1.0)
VOLTS, CURRENT = Channel("analog", "aoV", 1, 10.0, "V"), Channel("analog", "aoI", 2, 20.0, "mA")
NAMED = pytest.mark.parametrize("name", list(ARM_LANGUAGES))

SAYS = {
    "abb": "SetAO aoPressure,7.5;",
    "abb-paint": "SetAO aoPressure,7.5;",
    "fanuc": "AO[1]=1500 ;",
    "kuka": "$ANOUT[1]=0.75\n",
    "linuxcnc": "M68 E1 Q7.5\n",
    "ur": "set_out(2, 1, 0.75)\n",
    "yaskawa": "AOUT AO#(1) 7.5\n",
    "epson": "AIO_Out 1, 7.5\n",
    "denso": "IOW[1] = 7500\n",
    "melfa": "M_Outw(1)=7500\n",
    "val3": "aioSet(ao1,7.5)\n",
    "joint-table": "aoPressure = 7.5",
}
"""3.5 bar at 2 V for a bar and half a volt: 7.5 V of 10 V."""


def asking(bar: float) -> TimedProgram:
    items = [
        command("NOZZLE", "ring60", "TOOL", "1"),
        command("SET", "pressure_bar", f"{bar:.3f}"),
        spray([[0, 0, 50], [60, 0, 50]], 20.0),
    ]
    return time_plan(plan_of(*items), LIMITS)


def wired(channel: Channel, setting: tuple[float, float], sensor: Sensor | None = None) -> Installation:
    cell = small_cell()
    carried = {**cell.settings, "pressure_bar": Setting(channel, *setting)}
    shown = {"resistivity_mohm_cm": sensor} if sensor else cell.sensors
    return replace(cell, settings=carried, sensors=shown)


def found(name: str, program: TimedProgram, cell: Installation) -> list[Finding]:
    joints = joints_of(program) if DIALECTS[name].needs_joints else None
    findings = export(program, for_language(cell, name), name, joints).findings
    return [finding for finding in findings if finding.rule.id == "analog-out-of-range"]


@NAMED
def test_the_same_volts_are_said_in_each_language(name: str) -> None:
    program = PROGRAMS["loop"]()
    joints = joints_of(program) if DIALECTS[name].needs_joints else None
    text = "".join(export(program, for_language(small_cell(), name), name, joints).files.values())
    assert SAYS[name] in text.replace("\r\n", "\n")


def test_another_full_scale_is_another_share_of_it() -> None:
    cell = wired(replace(PRESSURE, full_scale=15.0), (2.0, 0.5))
    for name, said in (("kuka", "$ANOUT[1]=0.5\n"), ("fanuc", "AO[1]=1000 ;"), ("abb", "SetAO aoPressure,7.5;")):
        assert said in "".join(export(PROGRAMS["loop"](), for_language(cell, name), name).files.values())


def test_a_module_has_its_own_whole_numbers() -> None:
    cell = wired(replace(PRESSURE, counts=27648), (2.0, 0.5), Sensor("aiR", 1, 2.0, counts=20000))
    for name, said in (("fanuc", "AO[1]=20736 ;"), ("denso", "IOW[1] = 20736\n"), ("kuka", "$ANOUT[1]=0.75\n")):
        text = "".join(export(PROGRAMS["loop"](), for_language(cell, name), name).files.values())
        assert said in text.replace("\r\n", "\n")
    assert "0.001 * IOW[1] + 0 >= 1" in "".join(
        export(PROGRAMS["loop"](), for_language(cell, "denso"), "denso").files.values()
    )


def test_current_counts_from_four_milliamperes_where_the_controller_does() -> None:
    cell = wired(replace(PRESSURE, full_scale=20.0, unit="mA"), (2.0, 5.0))  # 12 mA
    for name, said in (("ur", "set_out(2, 1, 0.5)"), ("kuka", "$ANOUT[1]=0.6"), ("epson", "AIO_Out 1, 12")):
        assert said in "".join(export(PROGRAMS["loop"](), for_language(cell, name), name).files.values())


def test_a_channel_that_ends_below_four_milliamperes_counts_from_nothing() -> None:
    assert SHARE.count(replace(CURRENT, full_scale=4.0), 2.0) == pytest.approx(0.5)


def test_readings_are_turned_into_the_quantity() -> None:
    sensor = Sensor("aiR", 1, scale=1.25, offset=-5.0, full_scale=20.0, unit="mA")  # 0 to 20 on 4 to 20 mA
    for counting in (SHARE, WORDS, IN_OWN_UNIT, Counting(full=1.0)):
        scale, offset = counting.reading(sensor)
        for reading, quantity in ((4.0, 0.0), (12.0, 10.0), (20.0, 20.0)):
            assert scale * counting.count(sensor, reading) + offset == pytest.approx(quantity)
    assert SHARE.count(sensor, 12.0) == pytest.approx(0.012)  # amperes


@pytest.mark.parametrize("channel", [VOLTS, CURRENT], ids=["volts", "current"])
@pytest.mark.parametrize("counting", [SHARE, WORDS, IN_OWN_UNIT], ids=["share", "words", "own unit"])
@given(share=st.floats(0.2, 1.0))
def test_a_number_means_the_volts_it_was_made_of(counting: Counting, channel: Channel, share: float) -> None:
    value = share * channel.full_scale
    assert abs(counting.value(channel, counting.count(channel, value)) - value) <= counting.tolerance(channel)


@pytest.mark.slow
@NAMED
@settings(max_examples=5)
@given(share=st.floats(0.2, 1.0), full=st.sampled_from([5.0, 10.0, 20.0]), unit=st.sampled_from(["V", "mA"]))
def test_any_volts_are_read_back(name: str, share: float, full: float, unit: str) -> None:
    given_unit = "mA" if unit == "mA" else "V"
    sensor = Sensor("aiR", 1, 1.25, -0.25 * full, full, given_unit, 4096)
    cell = wired(replace(PRESSURE, full_scale=full, unit=given_unit, counts=27648), (share * full / 3.5, 0.0), sensor)
    dialect, program = DIALECTS[name], PROGRAMS["loop"]()
    motion = make_motion(program, cell, joints_of(program) if dialect.needs_joints else None)
    files = dialect.render(lower(motion, dialect.capability), cell)
    assert compare(dialect.read(files), motion, cell) == ()


@NAMED
def test_other_volts_are_a_difference(name: str) -> None:
    dialect, program = DIALECTS[name], PROGRAMS["loop"]()
    tell = partial(make_motion, program, tracking=joints_of(program) if dialect.needs_joints else None)
    cell, other = small_cell(), wired(PRESSURE, (2.0, 0.45))
    files = dialect.render(lower(tell(other), dialect.capability), other)
    assert "aoPressure" in "".join(map(str, compare(dialect.read(files), tell(cell), cell)))


@NAMED
def test_what_exceeds_the_full_scale_is_an_error(name: str) -> None:
    assert found(name, asking(4.75), small_cell()) == []  # 10 V
    (finding,) = found(name, asking(6.0), small_cell())
    assert finding.severity == "error"
    for what in ("pressure_bar = 6 ", "12.5 V", "aoPressure (analog output 1)", "to 10 V"):
        assert what in finding.message


def test_volts_below_nothing_are_an_error_where_the_language_has_none() -> None:
    cell = wired(PRESSURE, (-2.0, 0.0))
    assert found("kuka", asking(3.0), cell) == []
    (finding,) = found("ur", asking(3.0), cell)
    assert "pressure_bar = 3 is -6 V on aoPressure (analog output 1), which goes from 0 to 10 V" in finding.message
    weak = wired(replace(PRESSURE, full_scale=20.0, unit="mA"), (1.0, 0.0))
    assert found("kuka", asking(3.0), weak) == []
    assert "goes from 4 to 20 mA" in found("ur", asking(3.0), weak)[0].message


def test_a_limit_that_no_reading_shows_is_an_error() -> None:
    cell = wired(PRESSURE, (1.0, 0.0), Sensor("aiR", 1, scale=0.05))
    (finding,) = found("abb", PROGRAMS["loop"](), cell)
    assert "resistivity_mohm_cm >= 1 is 20 V on aiR (analog input 1), which goes from -10 to 10 V" in finding.message
    assert found("yaskawa", PROGRAMS["loop"](), cell) == []  # it only counts
