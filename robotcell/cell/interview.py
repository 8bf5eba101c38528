"""What a cell does not state that a program in a robot's language could have of it."""

from collections.abc import Iterator
from dataclasses import dataclass

from programs.posts.dialect import Dialect
from robotcell.cell.spec import CellSpec


@dataclass(frozen=True, slots=True)
class Question:
    """A key that is left out, with what depends on it."""

    path: str
    """As ``washboard cell edit`` takes it."""
    why: str
    example: str
    """A value, as YAML on one line."""
    otherwise: str
    """What programs do while it is left out."""


def find_questions(spec: CellSpec, language: Dialect) -> tuple[Question, ...]:
    """Give what is left out, in the order in which programs use it.

    Args:
        spec: The cell.
        language: Of the programs; of what it cannot express there is no question.
    """
    is_arm, has_logic = language.maker is not None, bool(language.most_steps)
    questions = [*_of_tools(spec, is_arm=is_arm, mounts=not language.capability.changes_tools), *_of_nozzles(spec)]
    if has_logic:
        questions += [*_of_waits(spec), *_of_line(spec)]
    if spec.io.first_run_lamp is None:
        instead = "a first run shows nothing where a jet would be on"
        lamp = "Which output shows in a first run that a jet would be on? No valve opens then."
        questions.append(Question("io.first_run_lamp", lamp, "doLamp", instead))
    if language.controller is not None and not spec.controller.model_fields_set:
        why = "How fast does this controller accelerate? Times, and doses as they are driven, are predicted with it."
        assumed = "the acceleration that is assumed of all controllers of this language"
        questions.append(Question("controller", why, "{acceleration_mm_s2: 1200, source: stopwatch}", assumed))
    return tuple(questions)


def _of_tools(spec: CellSpec, *, is_arm: bool, mounts: bool) -> Iterator[Question]:
    for number, tool in spec.tools.items() if is_arm else ():
        path, stated = f"tools.{number}", tool.model_fields_set
        if "mass_kg" not in stated:
            why = f"What does tool {number} ({tool.name}) weigh, with hose and cables? Arms detect collisions by it."
            yield Question(f"{path}.mass_kg", why, "1.2", "1 kg, or the load that the controller has")
        if "centre_mm" not in stated:
            why = f"Where is the centre of gravity of tool {number} ({tool.name}) on the flange?"
            yield Question(f"{path}.centre_mm", why, "[0, 10, 75]", "half way to the orifice along the flange's z")
    several = len(spec.tools) > 1
    if several and mounts and "at_tool_change" not in spec.model_fields_set:
        why = "Who changes tools? stop: a person, for whom the program stops; or a routine of the controller."
        yield Question("at_tool_change", why, "{routine: mount}", "the program stops with a message for a person")
    if several and spec.tool_change_deg_mm is None:
        joints = str([round(value, 3) for value in spec.home_deg_mm])
        yield Question("tool_change_deg_mm", "Where are tools changed, beside the board?", joints, "at home")


def _of_nozzles(spec: CellSpec) -> Iterator[Question]:
    for name, nozzle in spec.nozzles.items():
        for key, what, example in (
            ("open_lag_s", "from its signal to the full jet", "0.035"),
            ("close_lag_s", "from its signal to no jet", "0.02"),
        ):
            if key not in nozzle.model_fields_set:
                why = f"How long does the valve of {name} take {what}? At 100 mm/s 10 ms are 1 mm."
                yield Question(f"nozzles.{name}.{key}", why, example, f"{getattr(nozzle, key):g} s, assumed")


def _of_waits(spec: CellSpec) -> Iterator[Question]:
    usual = {
        "part_present": ("Which input shows that the part is there?", "an empty holder is washed"),
        "door_closed": ("Which input shows that the door is closed?", "the robot starts with the door open"),
    }
    inputs = next(iter(spec.io.inputs), "diPart")
    for name, (why, otherwise) in usual.items():
        if name not in spec.io.waits:
            name_input = "" if spec.io.inputs else " Inputs are named under io.inputs first."
            yield Question(f"io.waits.{name}", f"{why}{name_input}", f"{{input: {inputs}}}", otherwise)


def _of_line(spec: CellSpec) -> Iterator[Question]:
    line = spec.io.handshake
    for key, why, example, otherwise in (
        ("start", "Which input starts a cycle?", "diStart", "a program begins when it is started"),
        ("busy", "Which output shows the line that the robot works?", "doBusy", "the line cannot know"),
        ("done", "Which output shows the line that the part is washed?", "doDone", "the line cannot know"),
        ("fault", "Which output shows the line that the program stopped itself?", "doFault", "the line waits"),
    ):
        if getattr(line, key) is None:
            yield Question(f"io.handshake.{key}", why, example, otherwise)
