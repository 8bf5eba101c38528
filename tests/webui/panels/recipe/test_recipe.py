"""Whatever stands in a recipe can be found, changed, copied, renamed and removed in the recipe's tab."""

import re
from xml.etree import ElementTree

import pytest
from small_page import find, inputs, press, small_page, windows
from tiny_session import tiny_session

from recipes.errors import RecipeError
from recipes.load import read_recipe, recipe_library
from recipes.recipe import Recipe
from specs.source import Source
from webui.forms.entries import (
    SECTIONS,
    Entry,
    added,
    copied,
    default_entry,
    entries,
    entry_at,
    kinds_of,
    moved,
    removed,
    renamed,
)
from webui.forms.spec_form import reason_of
from webui.page.document import open_document
from webui.page.project import Project, ProjectError
from webui.panels.recipe.recipe import RecipePanel, card_html, sketch_nozzle
from webui.panels.recipe.text import TextPanel, line_of, state_html
from webui.theme.html import remark_html

SESSION = tiny_session()
ADDED = [(section, kind) for section in SECTIONS[:6] for kind in kinds_of(section.lower()) or ("",)]


def entry(path, session=SESSION):
    return next(each for section in SECTIONS for each in entries(session.recipe, section) if each.path == path)


@pytest.mark.parametrize("name", recipe_library())
def test_every_part_of_a_recipe_is_an_entry(name):
    recipe = read_recipe(name).recipe
    paths = {each.path for section in SECTIONS for each in entries(recipe, section)}
    assert {path[0] for path in paths if path} == set(Recipe.model_fields) - {"recipe", "description", "extends"} - (
        {name for name in ("masks", "classes") if not getattr(recipe, name)}
    )
    for section in SECTIONS:
        labels = [each.label for each in entries(recipe, section)]
        assert len(labels) == len(set(labels)), "a choice tells them apart"


@pytest.mark.slow
@pytest.mark.parametrize(("section", "kind"), ADDED)
def test_a_new_entry_of_every_kind_is_taken(section, kind):
    value = default_entry(SESSION.recipe, SESSION.board, section.lower(), kind, "fresh")
    after, path = added(SESSION, section, "fresh", value)
    assert path in [each.path for each in entries(after.recipe, section)]
    assert after.document.undone().text == SESSION.document.text
    if section in ("Templates", "Nozzles"):
        spec = getattr(after.recipe, section.lower())["fresh"]
        assert kind in (getattr(spec, "path", None), getattr(spec, "pattern", None))


def test_a_new_class_stands_before_the_one_that_takes_the_rest():
    after, _ = added(SESSION, "Classes", "qfp", {"package": ["*QFP*"]})
    assert list(after.recipe.classes)[-2:] == ["qfp", "large"]


def test_a_new_template_begins_with_what_the_library_uses():
    value = default_entry(SESSION.recipe, SESSION.board, "templates", "component_perimeter", "x")
    assert value["tilt_deg"] == 35
    assert value["passes"] == 1, "classes differ between recipes"
    line = default_entry(SESSION.recipe, SESSION.board, "templates", "straight_line", "x")
    low_x, low_y, high_x, high_y = SESSION.board.outline.bounds
    assert [line["from"][0], line["to"][0]] == pytest.approx([low_x, high_x], abs=0.01)
    assert low_y < line["from"][1] == line["to"][1] < high_y


@pytest.mark.parametrize("name", ["", "edge", "1st", "två ord"])
def test_a_name_that_cannot_be_one_is_refused(name):
    value = default_entry(SESSION.recipe, SESSION.board, "templates", "raster", name)
    with pytest.raises(RecipeError):
        added(SESSION, "Templates", name, value)


@pytest.mark.slow
def test_a_copy_says_the_same_under_its_own_name():
    first, path = copied(SESSION, entry(("templates", "around")))
    assert path == ("templates", "around-2")
    assert first.recipe.templates["around-2"] == SESSION.recipe.templates["around"]
    second, path = copied(first, entry(path, first))
    assert path == ("templates", "around-3")
    after, path = copied(SESSION, entry(("sequence", 0)))
    assert path == ("sequence", 1)
    assert [step.function for step in after.recipe.sequence] == [
        "clean",
        "clean",
        "rinse",
        "dry",
        "clean",
        "rinse",
        "dry",
    ]
    assert second.recipe != first.recipe
    after, path = copied(SESSION, entry(("classes", "small")))
    assert list(after.recipe.classes)[2:4] == ["small", "small-2"]


@pytest.mark.slow
def test_a_new_name_holds_wherever_it_is_used():
    renames = {
        ("classes", "bottom_terminated"): "qfn",
        ("templates", "around"): "rings",
        ("functions", "clean"): "function",
        ("nozzles", "ring60"): "nozzle",
    }
    after = SESSION
    for path, name in renames.items():
        after = renamed(after, entry(path, after), name)
    assert after.recipe.templates["rings"].passes == {"qfn": 3, "default": 1}
    assert after.recipe.sequence[0].paths == ["sweep", "edge", "rings", "step", "soak"]
    assert [step.function for step in after.recipe.sequence] == ["function", "rinse", "dry"] * 2
    assert [step.nozzle for step in after.recipe.sequence] == ["nozzle", "nozzle", "knife"] * 2
    back = renamed(after, entry(("functions", "function"), after), "clean")
    back = renamed(back, entry(("nozzles", "nozzle"), back), "ring60")
    back = renamed(back, entry(("templates", "rings"), back), "around")
    assert renamed(back, entry(("classes", "qfn"), back), "bottom_terminated").document.text == SESSION.document.text


def test_a_name_that_is_taken_or_inherited_stays(tmp_path):
    with pytest.raises(RecipeError, match="there already"):
        renamed(SESSION, entry(("templates", "around")), "sweep")
    file = tmp_path / "heir.yaml"
    file.write_text("recipe: heir\nextends: smt-aqueous\ntemplates:\n  sweep: {overlap: 0.4}\n")
    heir = SESSION.with_document(open_document(str(file)))
    for name in ("sweep", "around"):
        with pytest.raises(RecipeError, match="inherited"):
            renamed(heir, entry(("templates", name), heir), "mine")


@pytest.mark.parametrize(
    ("path", "place"),
    [
        (("templates", "sweep"), "step 1 (clean), step 2 (rinse)"),
        (("nozzles", "knife"), "step 3 (dry)"),
        (("functions", "rinse"), "step 2 (rinse)"),
        (("classes", "bottom_terminated"), "templates.around.passes"),
    ],
)
def test_what_is_used_is_not_removed_and_the_place_is_told(path, place):
    with pytest.raises(RecipeError, match=re.escape(place)):
        removed(SESSION, entry(path))


def test_what_is_not_used_is_removed():
    after, path = copied(SESSION, entry(("templates", "around")))
    assert removed(after, entry(path, after)).recipe == SESSION.recipe


def test_entries_move_as_far_as_there_are_neighbours():
    after, path = moved(SESSION, entry(("classes", "small")), -1)
    assert (list(after.recipe.classes)[1], path) == ("small", ("classes", "small"))
    after, path = moved(SESSION, entry(("sequence", 0)), 1)
    assert (after.recipe.sequence[1].function, path) == ("clean", ("sequence", 1))
    assert moved(SESSION, entry(("sequence", 0)), -1) == (SESSION, ("sequence", 0))


@pytest.mark.parametrize(
    ("made_by", "path"),
    [
        ("sequence[0]/around/U12", ("templates", "around")),
        ("sequence[1]/park", ("sequence", 1)),
        ("sequence[2]", ("sequence", 2)),
        ("templates.around.near", ("templates", "around")),
        ("classes.small", ("classes", "small")),
        ("limits", ("limits",)),
        ("board", None),
        ("", None),
    ],
)
def test_a_stroke_or_finding_leads_to_its_entry(made_by, path):
    assert entry_at(SESSION.recipe, Source.parse(made_by)) == path


def test_the_card_of_a_class_counts_its_members():
    card = card_html(SESSION, entry(("classes", "small")), "Classes")
    counts = [int(count) for count in re.findall(r'top">(?:<span[^>]*>)?(\d+)<', card)]
    assert sum(counts) == len(SESSION.board.components)
    assert len(counts) == len(SESSION.recipe.classes)


def test_the_card_says_where_a_template_is_used_and_what_it_is():
    card = card_html(SESSION, entry(("templates", "sweep")), "Templates")
    assert "Raster: Moves back and forth" in card
    assert "step 1 (clean), 2 (rinse)" in card
    assert "No masks yet" in card_html(SESSION, None, "Masks")


@pytest.mark.parametrize("kind", kinds_of("nozzles"))
def test_the_spray_is_drawn_inside_its_picture(kind):
    value = default_entry(SESSION.recipe, SESSION.board, "nozzles", kind, "x")
    nozzle = added(SESSION, "Nozzles", "x", value)[0].recipe.nozzles["x"]
    svg = ElementTree.fromstring(sketch_nozzle(nozzle).partition("<div")[0])
    spots = [
        [float(number) for number in pair.split(",")]
        for shape in svg.iter("polygon")
        for pair in shape.attrib["points"].split()
    ]
    size = float(svg.attrib["width"])
    assert len(spots) > 90
    assert all(0 <= x <= size and 0 <= y <= size for x, y in spots)
    assert max(x for x, _ in spots) + min(x for x, _ in spots) == pytest.approx(size, abs=1)


def test_a_measured_ring_is_drawn_as_measured():
    ring = SESSION.recipe.nozzles["ring60"]
    assert "50 mm below, measured" in sketch_nozzle(ring)
    assert "from the half angle" in sketch_nozzle(ring.model_copy(update={"wavefront": None}))


def test_a_reason_names_neither_the_file_nor_the_input_beside_it():
    error = RecipeError("is <bad>\nand 1 more:\n  a.yaml:9: limits: no", path="templates.x", file="a.yaml", line=3)
    assert reason_of(error, "templates.x") == "is <bad>\nand 1 more:\n  limits: no"
    assert reason_of(error) == "templates.x: is <bad>\nand 1 more:\n  limits: no"
    assert "is &lt;bad&gt;<br>" in remark_html(reason_of(error))
    assert line_of(error).startswith("Line 3: templates.x: is")


@pytest.fixture
def page(tmp_path):
    with small_page(SESSION, Project(tmp_path)) as page:
        RecipePanel(page, None)
        TextPanel(page, None)
        page.open()
        yield page


def choose(page, section, name=""):
    press(page, "Section", section)
    if name:
        press(page, "Entry", name)


def test_a_value_is_applied_and_shown_as_it_was_understood(page):
    choose(page, "Templates", "around")
    find(page, "Speed (mm/s)", 0).value = " 35 mm/s"
    press(page, "Apply")
    assert page.session.recipe.templates["around"].speed_mm_s == 35
    assert find(page, "Speed (mm/s)", 0).value == "35"
    assert "speed_mm_s: 35" in find(page, "YAML").value


def test_a_refused_value_stays_in_its_input_and_nowhere_else(page):
    choose(page, "Templates", "around")
    find(page, "Speed (mm/s)", 0).value = "500"
    press(page, "Apply")
    assert page.session is not None
    assert page.session.document.text == SESSION.document.text
    assert find(page, "Speed (mm/s)", 0).value == "500"
    assert page.client.said == [], "the reason stands at the input"
    choose(page, "Templates", "sweep")
    choose(page, "Templates", "around")
    assert find(page, "Speed (mm/s)", 0).value == "40"


def test_undo_shows_the_old_value_in_the_form(page):
    choose(page, "Limits")
    find(page, "Clearance (mm)").value = "6"
    press(page, "Apply")
    press(page, "Edit", "Undo")
    assert find(page, "Clearance (mm)").value == "5"
    press(page, "Edit", "Redo")
    assert find(page, "Clearance (mm)").value == "6"


def test_each_section_has_its_own_inputs_and_leaves_none_behind(page):
    choose(page, "Templates", "around")
    before = len(inputs(page))
    for section in SECTIONS:
        choose(page, section)
    choose(page, "Templates", "around")
    assert len(inputs(page)) == before


def test_a_selected_stroke_opens_its_template(page):
    choose(page, "Limits")
    page.select(made_by=Source.parse("sequence[0]/sweep/1"))
    assert find(page, "Section").value == "Templates"
    assert find(page, "Entry").value == "sweep"
    assert find(page, "Overlap").value == "0.3"


def test_a_template_is_added_in_a_window_that_stays_until_it_can_be(page):
    press(page, "Edit", "Add", at=0)
    find(page, "Path class").value = "straight_line"
    press(page, "Add")
    assert len(windows(page)) == 1, "it has no name yet"
    find(page, "Name").value = "pads"
    press(page, "Add")
    assert windows(page) == []
    assert page.session.recipe.templates["pads"].path == "straight_line"
    assert find(page, "Entry").value == "pads"
    assert find(page, "From (mm)").value.count(",") == 1


def test_a_step_is_copied_and_removed_here_and_moved_in_the_job_alone(page):
    choose(page, "Sequence")
    press(page, "Edit", "Copy", at=0)
    assert [step.function for step in page.session.recipe.sequence][:3] == ["clean", "clean", "rinse"]
    assert not find(page, "Order").visible
    press(page, "Edit", "Remove", at=0)
    assert page.session.recipe == SESSION.recipe


def test_a_class_is_moved_among_the_others(page):
    choose(page, "Classes")
    before = list(page.session.recipe.classes)
    assert find(page, "Order").visible
    press(page, "Order", "Down")
    assert list(page.session.recipe.classes) == [before[1], before[0], *before[2:]]


def test_only_what_can_be_done_is_offered(page):
    choose(page, "Masks")
    assert find(page, "Edit", 0).options == ("Add",)
    press(page, "Edit", "Add", at=0)
    press(page, "Add")
    assert find(page, "Entry").value == "1  avoid " + SESSION.board.components[0].name
    assert find(page, "Edit", 0).options == ("Add", "Copy", "Remove")
    choose(page, "Templates")
    assert "Rename" in find(page, "Edit", 0).options


def test_a_folder_is_open_where_something_is_stated(page):
    def opened(name):
        containers = page.client.gui._container_handle_from_uuid.values()
        return next(each.expand_by_default for each in containers if getattr(each, "label", "") == name)

    choose(page, "Sequence")
    assert not opened("Until")
    press(page, "Entry", entry(("sequence", 1)).label)
    assert opened("Until")


def test_what_was_typed_is_gone_once_another_entry_is_shown(page):
    choose(page, "Templates", "around")
    press(page, "Edit", "Copy", at=0)
    find(page, "Tilt (°)", 0).value = "12"
    press(page, "Edit", "Undo")
    assert find(page, "Entry").value == "edge"
    choose(page, "Templates", "around")
    assert find(page, "Tilt (°)", 0).value == "35"


def test_what_is_in_use_is_refused_with_the_reason(page):
    choose(page, "Templates", "edge")
    press(page, "Edit", "Remove", at=0)
    assert page.session.recipe == SESSION.recipe
    assert "step 1 (clean)" in page.client.said[-1]


def test_a_text_that_is_no_recipe_is_refused_and_stays(page):
    broken = SESSION.document.text.replace("tilt_deg: 35", "tilt_deg: steep")
    find(page, "YAML").value = broken
    press(page, "Text", "Apply text")
    assert page.session.document.text == SESSION.document.text
    assert find(page, "YAML").value == broken
    choose(page, "Limits")
    find(page, "Clearance (mm)").value = "6"
    press(page, "Apply")
    assert find(page, "YAML").value == broken, "what was typed is not lost"
    press(page, "Text", "Revert")
    assert find(page, "YAML").value == page.session.document.text


def test_a_recipe_of_the_library_is_saved_under_a_name_of_its_own(page, tmp_path):
    press(page, "File", "Save")
    find(page, "File").value = "../outside.yaml"
    press(page, "Save")
    assert len(windows(page)) == 1, "outside the project"
    find(page, "File").value = "house"
    press(page, "Save")
    assert windows(page) == []
    assert (tmp_path / "house.yaml").read_text() == page.session.document.text
    assert "saved" in state_html(page.session.document)


@pytest.mark.parametrize(("answer", "solution"), [("Overwrite it", "mine"), ("Load the file", "theirs")])
def test_a_file_that_somebody_changed_is_asked_about(page, tmp_path, answer, solution):
    file = page.project.recipe_file("house")
    page.attempt(lambda session: session.with_document(session.document.save_as(file)))
    file = tmp_path / "house.yaml"
    theirs = file.read_text().replace("saponifier-15", "theirs")
    page.attempt(lambda session: session.set_value(("functions", "clean", "solution"), "mine"))
    file.write_text(theirs)
    press(page, "File", "Save")
    assert file.read_text() == theirs
    press(page, answer)
    assert page.session.recipe.functions["clean"].solution == solution
    assert page.session.document.undone().dirty
    assert not page.session.document.dirty
    assert solution in file.read_text()


def test_another_recipe_is_opened(page):
    press(page, "File", "Open…")
    find(page, "Recipe").value = "dry-only"
    press(page, "Open")
    assert page.session.recipe.recipe == "dry-only"
    assert find(page, "Entry").value in page.session.recipe.templates
    with pytest.raises(ProjectError):
        page.project.open_recipe("../secret.yaml")


def test_an_entry_knows_what_can_be_done_to_it():
    assert entry(("limits",)).many is False
    assert entry(("sequence", 1)).ordered
    assert not entry(("templates", "edge")).ordered
    assert Entry((), "Recipe").section == "General"
