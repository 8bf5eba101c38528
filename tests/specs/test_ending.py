"""What is undone when the process ends, and what is stated about it; ``abandon`` runs in a process of its own."""

import subprocess
import sys
from pathlib import Path

import pytest

from specs import ending

WRITE = """
import sys
from pathlib import Path
from threading import Thread
from specs.output_file import OutputFile
from specs import ending
from specs.temporary import temporary_file, temporary_folder
folder = Path(sys.argv[1])
OutputFile(folder / "first").write(b"1")
with temporary_file(folder), temporary_folder(folder) as made:
    (made / "half").write_bytes(b"x")
    print(len(list(folder.iterdir())), ending.abandon())
    writer = Thread(target=OutputFile(folder / "late").write, args=(b"2",), daemon=True)
    writer.start()
    writer.join(0.2)
    print(sorted(each.name for each in folder.iterdir()), flush=True)
    import os
    os._exit(0)
"""


@pytest.fixture(autouse=True)
def fresh() -> None:
    ending.begin()


def test_what_was_written_is_named_once_and_many_are_counted() -> None:
    assert ending.describe_written() == "nothing was written"
    for name in ("a.wash", "a.wash", "b\n.json"):
        ending.note_written(Path(name))
    assert ending.describe_written() == "written before, and complete: a.wash, b\\n.json"
    for number in range(5):
        ending.note_written(Path(f"{number}"))
    assert ending.describe_written() == "written before, and complete: a.wash, b\\n.json, 0 and 4 more"
    ending.begin()
    assert ending.describe_written() == "nothing was written"


def test_how_far_long_work_has_come_is_added_until_it_is_done() -> None:
    ending.note_reached(lambda: "12 of 40\nanalyses")
    assert ending.describe_written() == "nothing was written; 12 of 40\\nanalyses"
    ending.note_written(Path("a.yaml"))
    ending.note_reached(lambda: "13 of 40")
    assert ending.describe_written() == "written before, and complete: a.yaml; 13 of 40"
    ending.note_reached(None)
    assert ending.describe_written() == "written before, and complete: a.yaml"


@pytest.mark.slow
def test_at_the_end_temporaries_go_and_nothing_is_begun_any_more(tmp_path: Path) -> None:
    run = subprocess.run([sys.executable, "-c", WRITE, tmp_path], capture_output=True, text=True, check=True)
    first, second = run.stdout.splitlines()
    assert first == f"4 written before, and complete: {tmp_path / 'first'}"
    assert second == "['first']"


def test_a_command_that_stops_by_itself_takes_the_first_signal_and_those_right_after_it() -> None:
    assert not ending.stops_itself(2)
    with ending.stopped_by_signal() as stop:
        assert ending.stops_itself(15)
        assert ending.stops_itself(2)
        assert stop.wait() == 15
    assert not ending.stops_itself(2)


def test_who_does_not_stop_is_ended_after_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    with ending.stopped_by_signal():
        assert ending.stops_itself(2)
        monkeypatch.setattr(ending, "_STOPPING_S", 0.0)
        assert not ending.stops_itself(2)
