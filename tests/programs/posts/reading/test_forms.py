import pytest

from programs.errors import ProgramError
from programs.posts.gcode.fanuc_cnc import FanucCncReader
from programs.posts.gcode.heidenhain import HeidenhainReader
from programs.posts.gcode.linuxcnc import GCodeReader
from programs.posts.gcode.sinumerik import SinumerikReader
from programs.posts.reading.driver import Reader
from programs.posts.reading.execution import StatementBlock
from programs.posts.rebuilt import ReadEndRepeat, ReadRepeat
from programs.posts.robots.denso import PacScriptReader
from programs.posts.robots.fanuc import TpReader
from programs.posts.robots.kuka.read import KrlReader
from programs.posts.robots.melfa import MelfaBasicReader
from programs.posts.robots.ur import UrScriptReader
from programs.posts.robots.val3.read import Val3Reader
from programs.posts.robots.yaskawa import InformReader

FIELDS = {"number": r"\d+", "height": r"-?\d+", "label": r"\d+", "routine": r"\w+"}
SEVERAL = ("IF z<{height}", "  z={height}", "GOTO {label}")


def values_of(forms: tuple[str, ...], *statements: str) -> object:
    return StatementBlock(forms, FIELDS, lambda values: None).follow(statements)


def test_a_form_reads_what_it_writes() -> None:
    form = "Call {routine}[{number}] (*.+?)"
    assert values_of((form,), form.format(routine="clean", number=7)) == {"routine": "clean", "number": "7"}


@pytest.mark.parametrize("statement", ["Call clean[-7]", "Call clean[7]!", "call clean[7]", "Call  clean[7]", ""])
def test_another_statement_is_not_read(statement: str) -> None:
    assert values_of(("Call {routine}[{number}]",), statement) is None


def test_a_field_that_comes_twice_in_a_statement_is_the_same() -> None:
    assert values_of(("{number}, {number}",), "12, 12") == {"number": "12"}
    assert values_of(("{number}, {number}",), "12, 13") is None


def test_a_text_for_the_operator_may_be_any_other() -> None:
    assert values_of(('Halt "not 100 percent"',), 'Halt "Override!"') == {}


def test_statements_that_belong_together_have_the_same_values() -> None:
    assert values_of(SEVERAL, "IF z<-5", "z=-5", "GOTO 3") == {"height": "-5", "label": "3"}
    assert "compared with one height" in str(values_of(SEVERAL, "IF z<-5", "z=5", "GOTO 3"))


@pytest.mark.parametrize("statements", [("IF z<5", "z=5"), ("IF z<5", "z=5", "GOTO x"), ("IF z<5", "GOTO 3", "z=5")])
def test_what_does_not_belong_to_the_first_statement_is_refused(statements: tuple[str, ...]) -> None:
    assert "is not what belongs to the statement before it" in str(values_of(SEVERAL, *statements))


SENSED: dict[type[Reader], str] = {
    PacScriptReader: "Dim nLoop1 As Integer|For nLoop1 = 1 To 4|If -2 * IOW[5] + 0.5 >= 3 Then Exit For|Next nLoop1",
    KrlReader: "nLoop1=0|REPEAT|nLoop1=nLoop1+1|UNTIL (nLoop1>=4) OR ((-2)*$ANIN[5]+0.5>=3)",
    TpReader: "R[91]=0|LBL[1]|R[91]=R[91]+1|R[90]=AI[5]*(-2)|R[90]=R[90]+.5|IF R[91]<4 AND R[90]<3,JMP LBL[1]",
    MelfaBasicReader: "M1=0|*LOOP1|M1=M1+1|If M1<4 And (-2*M_Inw(5)+0.5)<3 Then GoTo *LOOP1",
    UrScriptReader: "n_loop_1 = 0|while n_loop_1 < 4 and (n_loop_1 == 0 or -2*get_standard_analog_in(5)+0.5 < 3):|"
    "n_loop_1 = n_loop_1 + 1|end",
    Val3Reader: "nLoop1=0|do|nLoop1=nLoop1+1|until nLoop1>=4 or -2*aioGet(ai5)+0.5>=3",
    GCodeReader: "#<loop101> = 0|o101 do|#<loop101> = [#<loop101> + 1]|M66 E5 L0|"
    "o101 while [[#<loop101> LT 4] AND [[-2 * #5399 + 0.5] LT 3]]",
    HeidenhainReader: "Q71 = +0|LBL 501|Q71 = Q71 + 1|FN 20: WAIT FOR SYNC|FN 18: SYSREAD Q61 = ID2000 NR70 IDX5|"
    "Q61 = -2 * Q61 + +0.5|FN 9: IF +Q61 EQU +3 GOTO LBL 601|FN 11: IF +Q61 GT +3 GOTO LBL 601|"
    "FN 12: IF +Q71 LT +4 GOTO LBL 501|LBL 601",
    SinumerikReader: "R111=0|REPEAT|R111=R111+1|STOPRE|UNTIL (R111>=4) OR ((-2)*$A_INA[6]+0.5>=3)",
    FanucCncReader: "#111=0|N501|#111=#111+1|IF[[#111LT4]AND[[[[-2]*#605]+0.5]LT3]]GOTO501",
}
"""A loop that is done four times at most, until -2 times input 5 and 0.5 more are 3."""
COUNTED: dict[type[Reader], str] = {
    PacScriptReader: "Dim nLoop1 As Integer|For nLoop1 = 1 To 4|Next nLoop1",
    TpReader: "R[91]=0|LBL[1]|R[91]=R[91]+1|IF R[91]<4,JMP LBL[1]",
    MelfaBasicReader: "M1=0|*LOOP1|M1=M1+1|If M1<4 Then GoTo *LOOP1",
    UrScriptReader: "n_loop_1 = 0|while n_loop_1 < 4:|n_loop_1 = n_loop_1 + 1|end",
    Val3Reader: "nLoop1=0|do|nLoop1=nLoop1+1|until nLoop1>=4",
    HeidenhainReader: "Q71 = +0|LBL 501|Q71 = Q71 + 1|FN 12: IF +Q71 LT +4 GOTO LBL 501",
    FanucCncReader: "#111=0|N501|#111=#111+1|IF[#111LT4]GOTO501",
    InformReader: "SET I090 0|*LOOP1|INC I090|JUMP *LOOP1 IF I090<4",
    GCodeReader: "o101 repeat [4]|o101 endrepeat",
    KrlReader: "nLoop1=0|REPEAT|nLoop1=nLoop1+1|UNTIL nLoop1>=4",
    SinumerikReader: "R111=0|REPEAT|R111=R111+1|STOPRE|UNTIL R111>=4",
}


class Declaring(KrlReader):
    """KRL without its declarations."""

    def use_variable(self, name: str) -> None:
        """Nothing is declared."""


def executed(reader_class: type[Reader], text: str) -> Reader:
    reader = (Declaring if reader_class is KrlReader else reader_class)()
    reader.routines["all"] = text.split("|")
    reader.use_blocks()
    reader.run("all")
    return reader


@pytest.mark.parametrize("reader_class", SENSED)
def test_a_loop_reads_its_count_and_its_input(reader_class: type[Reader]) -> None:
    begin, end = executed(reader_class, SENSED[reader_class]).steps
    assert begin == ReadRepeat(4, 3.0, (-2.0, 0.5), "5")
    assert end == ReadEndRepeat()


@pytest.mark.parametrize("reader_class", COUNTED)
def test_a_loop_that_only_counts_reads_its_count(reader_class: type[Reader]) -> None:
    assert executed(reader_class, COUNTED[reader_class]).steps == [ReadRepeat(4, None), ReadEndRepeat()]


@pytest.mark.parametrize("forms", [SENSED, COUNTED])
def test_a_loop_without_one_of_its_statements_is_refused(forms: dict[type[Reader], str]) -> None:
    for reader_class, text in forms.items():
        statements = text.split("|")
        for at in range(1 if "Dim" in text else 0, len(statements) - 1):
            if statements[at].endswith("Exit For"):  # without it the loop counts
                continue
            with pytest.raises(ProgramError):
                executed(reader_class, "|".join([*statements[:at], *statements[at + 1 :]]))


@pytest.mark.parametrize("reader_class", [InformReader, KrlReader, GCodeReader, SinumerikReader])
def test_the_end_of_another_loop_than_the_innermost_is_refused(reader_class: type[Reader]) -> None:
    text = COUNTED[reader_class]
    other = text.replace("LOOP1", "LOOP2").replace("Loop1", "Loop2").replace("I090", "I091").replace("o101", "o102")
    statements, others = text.split("|"), other.replace("R111", "R112").split("|")
    cut = 1 if reader_class is GCodeReader else 3
    crossed = [*statements[:cut], *others[:cut], *statements[cut:], *others[cut:]]
    with pytest.raises(ProgramError, match="ends no loop, or not the innermost"):
        executed(reader_class, "|".join(crossed))
