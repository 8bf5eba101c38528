from dataclasses import replace
from types import SimpleNamespace

from shown_cell import shown_cell
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session

from robotcell.cell.load import cell_library
from webui.page.project import open_project
from webui.panels.robot.robot import RobotPanel, about_html


def opened(page):
    scene = SmallScene(page)
    RobotPanel(page, scene)
    page.open()
    return scene


def test_a_cell_of_the_library_or_of_the_folder_is_chosen_and_given_up_again(tmp_path):
    text = cell_library()["ur5e-bench"].read_text()
    (tmp_path / "mine.yaml").write_text(text.replace("cell: ur5e-bench", "cell: mine"))
    (tmp_path / "recipe.yaml").write_text("recipe: no-cell\n")
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        scene = opened(page)
        names = find(page, "Cell").options
        assert {"none", "ur5e-bench", "gantry", "mine.yaml"} <= set(names)
        assert "recipe.yaml" not in names
        press(page, "Cell", "mine.yaml")
        assert page.session.cell.cell.name == "mine"
        assert scene.robot.cell is page.session.cell.cell
        press(page, "Cell", "none")
        assert page.session.cell is None
        assert scene.robot.cell is None
        assert scene.looked == ["cell", "board"]


def test_a_cell_that_cannot_be_used_says_why_and_changes_nothing(tmp_path):
    (tmp_path / "broken.yaml").write_text("cell: broken\nrobot: ur5e\n")
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        opened(page)
        press(page, "Cell", "broken.yaml")
        assert page.session.cell is None
        assert find(page, "Cell").value == "none"
        assert "broken.yaml" in page.client.said[0]
        assert "home_deg_mm" in page.client.said[0]
        press(page, "Cell", "../../etc/passwd")
        assert "outside the project folder" in page.client.said[1]


def test_the_robot_is_hidden_and_stays_hidden_in_another_cell(tmp_path):
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        opened(page)
        press(page, "Cell", "ur5e-bench")
        press(page, "Show the robot", False)
        assert not page.client.scene._handle_from_node_name["/cell"].visible
        press(page, "Cell", "gantry")
        assert not page.client.scene._handle_from_node_name["/cell"].visible
        press(page, "Show the robot", True)
        assert page.client.scene._handle_from_node_name["/cell"].visible


def test_what_a_file_says_about_a_cell_is_only_text():
    named = SimpleNamespace(cell=replace(shown_cell(), fixtures=()), spec=SimpleNamespace(description="<script>"))
    html = about_html(named)
    assert "<script>" not in html
    assert "&lt;script&gt;" in html
    assert "1 lance, 2 knife" in html
