from dataclasses import replace

from installations import WASH, small_cell
from robot_steps import line, pose, program

from programs.motion.lower import lower
from programs.motion.steps import Call, Step, Switch
from programs.posts.robots.denso import DIALECT, PacScript
from programs.posts.writing.chapters import Chapter


def syntax(*steps: Step) -> PacScript:
    return PacScript(DIALECT, lower(program(*steps), DIALECT.capability), small_cell())


def test_a_comment_names_the_recipe_path_where_another_one_moves_the_robot() -> None:
    steps = [replace(line(pose(0), pose(1), 9.0), made_by=maker) for maker in ("a", "a", "b", "a")]
    chapter = Chapter(1, "clean", (Switch(WASH, 0.0, "z"), *steps), None, None)
    words = [text.split()[0] for text in syntax().chapter(chapter)]
    assert words == ["Reset", "'", "Move", "Move", "'", "Move", "'", "Move"]


def test_routines_have_names_that_fit_and_differ_from_the_integrators() -> None:
    name = "tiny__smt_aqueous_01"
    writer = syntax(Call(name, "s"))
    assert writer.call_name(name) == name
    assert writer.routine_name(Chapter(1, "clean", (), None, None)) == f"{name}_2"
    assert writer.routine_name(Chapter(7, "clean", (), None, None)) == "tiny__smt_aqueous_07"


def test_a_modal_word_is_written_where_its_value_changes() -> None:
    writer = syntax()
    assert [writer.set("speed", f"Spd {value}") for value in ("5", "5", "6")] == [["Spd 5"], [], ["Spd 6"]]
    writer.forget()
    assert writer.set("speed", "Spd 6") == ["Spd 6"]
