import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from programs.posts.writing.forms import fill, pattern_of

FIELDS = {"point": r"P\d+", "output": ".*"}
MOVE = "L {point} V={speed:1}{stops: FINE}{ahead: TB {lead:-~2}sec,{output}}"


def read(form: str, text: str) -> dict[str, str | None] | None:
    match = re.fullmatch(pattern_of(form, FIELDS), text)
    return match and match.groupdict()


@pytest.mark.parametrize(
    ("form", "value", "text"),
    [
        ("{it:1}", 2.0, "2.0"),
        ("{it:1}", 0.25, "0.2"),
        ("{it:3}", 2.0005, "2.001"),
        ("{it:~3}", 2.0, "2"),
        ("{it:~3}", 2.5, "2.5"),
        ("{it:0}", 40.0, "40"),
        ("{it:~0}", 100.0, "100"),
        ("{it:-2}", -0.001, "0.00"),
        ("{it:-2}", -1.0, "-1.00"),
        ("{it}", "P7", "P7"),
        ("{it: FINE}", True, " FINE"),
        ("{it: FINE}", False, ""),
    ],
)
def test_a_field_is_written_as_its_words_state(form: str, value: object, text: str) -> None:
    assert fill(form, it=value) == text


def test_what_is_optional_is_there_or_not() -> None:
    words = {"point": "P1", "speed": 5.0, "lead": -0.5, "output": "DO[1]=ON"}
    assert fill(MOVE, **words) == "L P1 V=5.0"
    assert fill(MOVE, **words, stops=True) == "L P1 V=5.0 FINE"
    assert fill(MOVE, **words, ahead=True) == "L P1 V=5.0 TB -0.5sec,DO[1]=ON"


def test_what_is_optional_is_read_where_it_is_there() -> None:
    assert read(MOVE, "L P1 V=5.0") == dict.fromkeys(("stops", "ahead", "lead", "output")) | {
        "point": "P1",
        "speed": "5.0",
    }
    found = read(MOVE, "L P1 V=5.0 FINE TB -0.5sec,DO[1]=ON")
    assert found is not None
    assert (found["stops"], found["lead"], found["output"]) == (" FINE", "-0.5", "DO[1]=ON")


@pytest.mark.parametrize(
    "text",
    ["L P1 V=-5.0", "L Q1 V=5.0", "L P1 V=5.0 FIN", "L P1 V=5.0 TB .5sec,DO[1]=ON", "L P1 V=5.", " L P1 V=5.0", ""],
)
def test_another_text_is_not_read(text: str) -> None:
    assert read(MOVE, text) is None


@pytest.mark.parametrize(
    ("form", "text", "is_read"),
    [
        ("{it:0}", "7", True),
        ("{it:0}", "7.0", False),
        ("{it:0}", "-7", False),
        ("{it:-0}", "-7", True),
        ("{it:2}", "-7.00", False),
        ("{it:-~2}", "-7", True),
        ("{it:1},{it:1}", "2.0,2.0", True),
        ("{it:1},{it:1}", "2.0,3.0", False),
    ],
)
def test_a_number_is_read_with_the_sign_and_decimals_that_it_may_have(form: str, text: str, is_read: bool) -> None:
    assert (read(form, text) is not None) is is_read


@settings(max_examples=30)
@given(speed=st.floats(0.0, 1e5), lead=st.floats(-10.0, 10.0), stops=st.booleans(), ahead=st.booleans())
def test_what_is_written_is_read(speed: float, lead: float, stops: bool, ahead: bool) -> None:
    text = fill(MOVE, point="P12", speed=speed, lead=lead, output="x", stops=stops, ahead=ahead)
    found = read(MOVE, text)
    assert found is not None
    assert found["point"] == "P12"
    assert float(found["speed"] or "nan") == pytest.approx(speed, abs=0.051)
    assert (found["stops"] is not None, found["ahead"] is not None) == (stops, ahead)
    assert not ahead or float(found["lead"] or "nan") == pytest.approx(lead, abs=0.0051)
