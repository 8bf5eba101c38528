"""Zones and rates of turns are compared with the plan in every language that states them."""

import re
from collections.abc import Iterator

import pytest
from installations import for_language, small_cell
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare

ZONES = {
    "abb": (r",z\d,", ",z5,", ",z1,"),
    "denso": (r"@[1-9]\d* P", "@7 P", "@8 P"),
    "epson": (r" CP(?=\n)", "", ""),
    "fanuc": (r"CNT\d+", "CNT7", "CNT8"),
    "kuka": (r"\$APO\.CDIS=[\d.]+", "$APO.CDIS=7.125", "$APO.CDIS=7.5"),
    "melfa": (r"Cnt 1,[\d.]+,[\d.]+", "Cnt 1,7.5,7.5", "Cnt 1,8,8"),
    "ur": (r"r=0\.0*[1-9]\d*", "r=0.0075", "r=0.008"),
    "val3": (r'cartesian" leave="[\d.]+" reach="[\d.]+"', 'cartesian" leave="7.5" reach="7.5"'),
    "yaskawa": (r"(?<=\d )(?:PL=1|CR=[\d.]+)(?=\n)", "CR=7.5"),
}
RATES = {
    "abb": (r"speeddata (s100_r\w+):=\[100,[\d.]+", r"speeddata \1:=[100,7", r"speeddata \1:=[100,8"),
    "denso": (r"[\d.]+ \* PER_DEG_S", "7 * PER_DEG_S", "8 * PER_DEG_S"),
    "epson": (r"SpeedR [\d.]+(?=\n *Move)", "SpeedR 7", "SpeedR 8"),
    "fanuc": (r"\d+deg/sec", "7deg/sec", "8deg/sec"),
    "kuka": (r"\$VEL\.ORI1=[\d.]+(\n *)\$VEL\.ORI2=[\d.]+", r"$VEL.ORI1=7\1$VEL.ORI2=7", r"$VEL.ORI1=8\1$VEL.ORI2=8"),
    "linuxcnc": (r"(G1(?: [ABC]-?[\d.]+)+ F)[\d.]+", r"\g<1>7", r"\g<1>8"),
    "ur": (r" t=[\d.]+, r", " t=7, r", " t=8, r"),
    "val3": (r'tmax="9999" rmax="[\d.]+"', 'tmax="9999" rmax="7"', 'tmax="9999" rmax="8"'),
    "yaskawa": (r"VR=[\d.]+", "VR=7.0", "VR=8.0"),
}


def differences(dialect: str, pattern: str, *others: str) -> Iterator[list[str]]:
    """What is found where each of some places in the text states another value."""
    language, cell, program = DIALECTS[dialect], for_language(small_cell(), dialect), PROGRAMS["three_speeds"]()
    motion = make_motion(program, cell, joints_of(program))
    files = language.render(lower(motion, language.capability), cell)
    assert compare(language.read(files), motion, cell) == ()
    for name, text in files.items():
        for match in list(re.finditer(pattern, text))[:3]:
            other = next(each for each in map(match.expand, others) if each != match[0])
            changed = text[: match.start()] + other + text[match.end() :]
            try:
                read = language.read({**files, name: changed})
            except ProgramError as refused:
                yield [str(refused)]
            else:
                yield [each.message for each in compare(read, motion, cell)]


@pytest.mark.parametrize("dialect", ZONES)
def test_another_zone_is_found(dialect: str) -> None:
    found = list(differences(dialect, *ZONES[dialect]))
    assert found
    assert all(len(each) > 0 for each in found), found
    assert "passed at" in str(found) or "stop" in str(found)


@pytest.mark.parametrize("dialect", RATES)
def test_another_rate_of_a_turn_is_found(dialect: str) -> None:
    found = list(differences(dialect, *RATES[dialect]))
    assert found
    assert all(len(each) > 0 for each in found), found
    assert "tool turns at" in str(found) or "turn takes" in str(found)


def test_the_tolerance_of_a_controller_that_is_not_planned_for_is_refused() -> None:
    (message,) = next(differences("linuxcnc", r"G64 P0\.05", "G64 P0.5"))
    assert "unknown statement" in message
