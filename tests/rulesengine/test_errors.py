"""A command that cannot do its job says so in one line and leaves with the right code."""

import pytest
import typer

from boards.errors import BoardError
from rulesengine.errors import job_errors


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (BoardError("no board", file="x.tri", line=3), 2, "error: x.tri:3: no board\n"),
        (FileNotFoundError(2, "No such file", "y.wash"), 2, "error: y.wash: No such file\n"),
        (KeyboardInterrupt(), 130, "error: interrupted; nothing was left half written\n"),
        (BrokenPipeError(), 1, ""),
    ],
)
def test_exit_codes(error: BaseException, code: int, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(typer.Exit) as caught, job_errors():
        raise error
    assert caught.value.exit_code == code
    assert capsys.readouterr().err == said


def test_other_errors_are_ours_to_mend_and_pass_through() -> None:
    with pytest.raises(ZeroDivisionError), job_errors():
        raise ZeroDivisionError
