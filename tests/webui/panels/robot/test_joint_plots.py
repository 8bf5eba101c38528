import re

from shown_cell import shown_cell, sway
from tiny_session import tiny_session

from reports.pictures.joint_picture import QUANTITIES, joint_curves
from robotcell.motion.retime import rates_of
from webui.panels.robot.check import curves_html, plot_cursor_html


def test_a_real_program_is_drawn_with_few_points_and_every_joint():
    cell, program = shown_cell(), tiny_session().run.program
    rates = rates_of(program, sway(cell, program))
    for quantity in QUANTITIES:
        curves = joint_curves(cell.robot.joints, rates, quantity)
        html = curves_html(curves, program.totals.duration_s)
        assert [curve.name for curve in curves] == [joint.name for joint in cell.robot.joints]
        assert html.count("<polygon") == cell.robot.dof
        assert "nan" not in html
        assert "inf" not in html
        assert len(html) < 100_000


def test_the_cursor_spans_all_curves_and_stays_inside():
    at = [float(re.search(r"left:([\d.]+)%", plot_cursor_html(now_s, 8.0, 6))[1]) for now_s in (-1.0, 4.0, 99.0)]
    assert at == [0.0, 50.0, 100.0]
