"""In every language: the first run of a program, the signals of a line, what tools weigh."""

import re
from dataclasses import replace
from functools import cache

import pytest
from installations import ARM_LANGUAGES, BUSY, DONE, FAULT, HEAVY, LAMP, LINE, WASH, full_cell
from robot_programs import PROGRAMS, joints_of, machine_joints_of

from programs.export import Exported, Variant, export
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadAwait, ReadHold, ReadLine, ReadReach, ReadSwitch
from specs.source import Source

NAMED = pytest.mark.parametrize("name", list(DIALECTS))
WITH_LINE = pytest.mark.parametrize("name", [name for name in DIALECTS if name != "joint-table"])


@cache
def exported(name: str, first_run: bool, made: str = "two_tools") -> Exported:
    """A nozzle, a knife and the nozzle again, as three steps of a sequence; or another program, as one."""
    program, cell, step = PROGRAMS[made](), full_cell(name), 0
    items = list(program.instructions)
    for at, item in enumerate(items):
        step += at > 0 and getattr(item, "keyword", "") == "FUNCTION"
        items[at] = replace(item, made_by=Source(step)) if made == "two_tools" else item
    program = replace(program, instructions=tuple(items))
    joints = joints_of(program) if name in ARM_LANGUAGES else machine_joints_of(program, cell)
    return export(program, cell, name, joints, Variant(first_run=first_run))


def switched(done: Exported) -> list[str]:
    signals = [s.channel for step in done.rebuilt.steps if isinstance(step, ReadLine) for s in step.signals]
    return [*signals, *(step.channel for step in done.rebuilt.steps if isinstance(step, ReadSwitch))]


@NAMED
def test_a_first_run_opens_no_valve_is_slow_and_stops_before_each_step(name: str) -> None:
    first, own = exported(name, True), exported(name, False)
    assert not any(WASH.is_called(label) for label in switched(first))
    assert any(LAMP.is_called(label) for label in switched(first))
    assert any(WASH.is_called(label) for label in switched(own))
    assert not any(LAMP.is_called(label) for label in switched(own))
    acts = [step for step in first.rebuilt.steps if isinstance(step, ReadHold | ReadLine | ReadReach)]
    held = [acts[at + 1] for at, step in enumerate(acts) if isinstance(step, ReadHold)]
    assert len(held) == 3
    assert isinstance(acts[0], ReadHold)
    assert not any(isinstance(step, ReadHold) for step in own.rebuilt.steps)
    speeds = [
        max(step.speed_mm_s or 0.0 for step in each.rebuilt.steps if isinstance(step, ReadLine))
        for each in (first, own)
    ]
    assert speeds[0] <= 0.3 * speeds[1]
    assert first.motion.duration_s > 3.0 * own.motion.duration_s


@NAMED
@pytest.mark.parametrize("made", ["panel", "odd_names"])
def test_first_run_and_handshake_of_a_panel_and_of_odd_names_are_read_back(name: str, made: str) -> None:
    """As every export is, before anything comes of it."""
    first, own = exported(name, True, made), exported(name, False, made)
    assert not any(WASH.is_called(label) for label in switched(first))
    assert any(LAMP.is_called(label) for label in switched(first))
    assert any(isinstance(step, ReadHold) for step in first.rebuilt.steps)
    assert any(DONE.is_called(label) for label in switched(own)) is (name != "joint-table")
    assert not any(DONE.is_called(label) for label in switched(first))


@NAMED
def test_a_first_run_has_another_name_no_guard_and_says_so(name: str) -> None:
    first, own = exported(name, True), exported(name, False)
    shared = {file for file in first.files if first.files[file] == own.files.get(file)}
    names = [{file for file in each.files if file not in shared} for each in (first, own)]
    assert first.rebuilt.frame is None or not first.rebuilt.frame.guards_override
    if not DIALECTS[name].form.is_project:  # the files of a project are in a folder of its own
        assert not names[0] & names[1]
    assert next(iter(first.files)) != next(iter(own.files))
    for words in ("no valve opens", "at 25 (%|pct) of their speeds", "loops once", "which has another name"):
        assert any(re.search(f"FIRST RUN: .*{words}", text) for text in first.files.values())
    assert not any("FIRST RUN" in text for text in own.files.values())
    assert "dose-differs" not in {finding.rule.id for finding in first.findings}


@WITH_LINE
def test_the_line_is_told_and_a_part_is_washed_once(name: str) -> None:
    steps = exported(name, False).rebuilt.steps
    moves = [at for at, step in enumerate(steps) if isinstance(step, ReadLine | ReadReach)]
    labels = {"busy": BUSY, "done": DONE, "fault": FAULT}

    def told(part: tuple[object, ...]) -> list[str]:
        found: list[str] = []
        for step in part:
            if isinstance(step, ReadAwait):
                found.append(f"await {step.channel} {int(step.state)}")
            elif isinstance(step, ReadSwitch):
                found += [f"{key} {step.value:g}" for key, channel in labels.items() if channel.is_called(step.channel)]
        return [
            re.sub("diStart|diPart", lambda match: {"diStart": "11", "diPart": "3"}[match[0]], each) for each in found
        ]

    assert told(steps[: moves[0]]) == ["busy 0", "done 0", "fault 0", "await 11 1", "busy 1"]
    assert told(steps[moves[-1] :]) == ["busy 0", "done 1", "await 3 0", "done 0"]


@WITH_LINE
def test_a_signal_that_is_lost_is_noticed(name: str) -> None:
    done, cell = exported(name, False), full_cell(name)
    for changed in (
        replace(LINE, fault=replace(FAULT, number=30, name="doOther")),
        replace(LINE, start=None),
        replace(LINE, state=False),
        None,
    ):
        assert compare(done.rebuilt, done.commanded, replace(cell, handshake=changed))


@pytest.mark.parametrize("name", ["ur", "fanuc", "epson"])
def test_another_load_than_the_cells_is_noticed(name: str) -> None:
    done, cell = exported(name, False), full_cell(name)
    heavier = replace(cell, tools={n: replace(t, payload=replace(HEAVY, mass_kg=1.5)) for n, t in cell.tools.items()})
    assert compare(done.rebuilt, done.commanded, cell) == ()
    assert any("weighs" in str(each) for each in compare(done.rebuilt, done.commanded, heavier))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("abb", "[1.25,[-1.5,2,80.5],[1,0,0,0],0.001,0.002,0]"),
        ("abb-paint", "[1.25,[-1.5,2,80.5],[1,0,0,0],0.001,0.002,0]"),
        ("kuka", "{M 1.250,CM {X -1.5,Y 2.0,Z 80.5,A 0.0,B 0.0,C 0.0},J {X 0.001,Y 0.002,Z 0.0}}"),
        ("ur", "set_payload(1.25, [-0.0015,0.002,0.0805])"),
        ("fanuc", "$PLST_GRP1[2].$PAYLOAD_Z=8.05"),
        ("epson", "Weight 1.25"),
        ("melfa", "LoadSet 2,0"),
        *((name, "1.25 kg, centre of gravity -1.5, 2, 80.5 mm") for name in ("melfa", "yaskawa", "denso", "val3")),
    ],
)
def test_the_load_of_each_tool_is_stated(name: str, words: str) -> None:
    assert any(words in text for text in exported(name, False).files.values())


@WITH_LINE
def test_files_are_loaded_once_however_many_parts_a_program_may_start_at(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    done, loaded = exported(name, False), list[object]()
    reader = getattr(DIALECTS[name].rebuild, "__self__")  # noqa: B009
    load = reader.load
    monkeypatch.setattr(reader, "load", lambda self, files: (loaded.append(files), load(self, files))[1])
    again = DIALECTS[name].read(done.files)
    assert again.frame == done.rebuilt.frame
    assert again.frame is not None
    assert len(again.frame.parts) > 2
    assert len(loaded) == 1
