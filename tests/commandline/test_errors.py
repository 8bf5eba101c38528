"""A command that cannot do its job says so in one line and leaves with the right code."""

import pytest
import typer

from boards.errors import BoardError
from commandline.errors import DEBUG_VARIABLE, job_errors
from specs import ending
from specs.errors import JobError


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (BoardError("no board", file="x.tri", line=3), 2, "error: x.tri:3: no board\n"),
        (FileNotFoundError(2, "No such file", "y.wash"), 2, "error: y.wash: No such file\n"),
        (KeyboardInterrupt(), 130, "error: interrupted; nothing was written\n"),
        (BrokenPipeError(), 1, ""),
        (MemoryError(), 2, "error: not enough memory for this job; close other programs or use a smaller board\n"),
        (JobError("first\n  and more"), 2, "error: first\n  and more\n"),
        (JobError("b" * 600 + "c" * 600 + " mend it"), 2, f"error: {'b' * 493} … {'c' * 492} mend it\n"),
    ],
)
def test_exit_codes(error: BaseException, code: int, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    ending.begin()
    with pytest.raises(typer.Exit) as caught, job_errors():
        raise error
    assert caught.value.exit_code == code
    assert capsys.readouterr().err == said


def test_a_defect_of_ours_is_one_line_that_asks_for_a_report(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(DEBUG_VARIABLE, raising=False)
    with pytest.raises(typer.Exit) as caught, job_errors():
        raise ZeroDivisionError("a\nb")
    said = capsys.readouterr().err
    assert caught.value.exit_code == 70
    assert said.startswith("internal error: ZeroDivisionError: a b. ")
    assert "please report it with the command `washboard" in said
    assert said.count("\n") == 1


def test_who_asks_for_it_sees_the_traceback(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(DEBUG_VARIABLE, "1")
    with pytest.raises(typer.Exit), job_errors():
        raise ZeroDivisionError
    said = capsys.readouterr().err
    assert said.startswith("Traceback ")
    assert "internal error: ZeroDivisionError" in said


def test_an_exit_that_is_meant_stays_what_it_is(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as caught, job_errors():
        raise typer.Exit(5)
    assert caught.value.exit_code == 5
    assert capsys.readouterr().err == ""
