"""Homes and the speeds of joint motions are compared with the plan in every language that states them."""

import re
from dataclasses import replace

import pytest
from joint_journey import cell_of, journey

from programs.motion.lower import lower
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import Rebuilt

LANGUAGES = [name for name, each in DIALECTS.items() if each.maker is not None]
GO_HOME = [name for name in LANGUAGES if name != "yaskawa"]
PACES = {
    "abb": r"\\T:=([\d.]+)",
    "abb-paint": r"\\T:=([\d.]+)",
    "denso": r"Speed = (\d+)\n",
    "epson": r"Speed (\d+)\n",
    "fanuc": r"(\d+)% FINE",
    "kuka": r"#VEL_PTP,(\d+)",
    "melfa": r"JOvrd (\d+)",
    "ur": r" t=([\d.]+)\)",
    "yaskawa": r"VJ=([\d.]+)",
}


def read_journey(language: str) -> Rebuilt:
    motion, cell = journey(language)
    return DIALECTS[language].read(DIALECTS[language].render(lower(motion, DIALECTS[language].capability), cell))


@pytest.mark.parametrize("language", GO_HOME)
def test_a_home_that_is_another_is_found(language: str) -> None:
    (motion, cell), read = journey(language), read_journey(language)
    assert compare(read, motion, cell) == ()
    other = replace(cell, home=(*cell.home[:5], cell.home[5] + 0.0001))
    found = compare(read, motion, other)
    assert [each.message.partition(" (")[0] for each in found] == ["the joints go to"] * 2


@pytest.mark.parametrize("language", GO_HOME)
def test_a_home_that_is_not_gone_to_is_found(language: str) -> None:
    (motion, cell), read = journey(language), read_journey(language)
    assert read.homes is not None
    (found,) = compare(replace(read, homes=read.homes[:1]), motion, cell)
    assert found.message == "the program goes home 1 times, planned 2, first and last"
    late = (read.homes[0], replace(read.homes[1], after=read.homes[1].after - 1))
    assert len(compare(replace(read, homes=late), motion, cell)) == 1
    assert len(compare(read, motion, replace(cell, home=()))) == 1


@pytest.mark.parametrize("language", PACES)
def test_another_speed_of_a_joint_motion_is_found(language: str) -> None:
    motion, cell = journey(language)
    files = DIALECTS[language].render(lower(motion, DIALECTS[language].capability), cell)
    count = 0
    for name, text in files.items():
        for match in re.finditer(PACES[language], text):
            value = re.sub(r"[2-9]", lambda digit: str(int(digit[0]) - 1), match[1], count=1)
            if value == match[1]:
                continue
            changed = text[: match.start(1)] + value + text[match.end(1) :]
            found = compare(DIALECTS[language].read({**files, name: changed}), motion, cell)
            assert found, (match[0], value)
            count += "joint motion states" in found[0].message
    assert count >= 1  # modal in some languages


def test_joint_motions_without_a_time_are_found_where_others_have_one() -> None:
    motion, cell = journey("ur")
    ((name, text),) = DIALECTS["ur"].render(lower(motion, DIALECTS["ur"].capability), cell).items()
    slow = re.sub(r" t=[\d.]+\)", " a=0.5, v=0.25)", text, count=1)
    (found,) = compare(DIALECTS["ur"].read({name: slow}), motion, cell)
    assert "states no speed, planned" in found.message
    assert cell_of("ur").home == cell.home
