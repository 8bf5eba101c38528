"""Settings of tuning, its proposal, and that a proposal is one edit that can be undone."""

import base64
import math
import re
from dataclasses import replace

import pytest
from tiny_session import tiny_session
from tuned_recipe import UNMET, proposal, slower

from cleaning.verdicts.rules import PLUGGED_GAP
from recipes.load import read_recipe_text
from rulesengine.tuning.trial.request import ProgramLimits
from rulesengine.tuning.variables import CHANGE_KINDS
from specs.errors import JobError
from webui.page.evaluations import KIND_WORDS, TuningError, TuningSettings
from webui.page.project import open_project
from webui.tuning.proposal_html import (
    apply_proposal,
    changes_html,
    diff_html,
    front_html,
    front_labels,
    headline_of,
    reasons_html,
    save_proposal,
    totals_html,
)


def test_every_group_of_numbers_can_be_ticked():
    assert tuple(KIND_WORDS) == CHANGE_KINDS
    assert TuningSettings().kinds == frozenset(CHANGE_KINDS) - {"pressure", "temperature"}


def test_nought_is_no_limit_and_numbers_are_kept():
    free = TuningSettings().request()
    assert free.limits == ProgramLimits(None, None)
    bound = TuningSettings(frozenset({"speeds"}), "clean-and-dry", 600.0, 20.0, 12.0).request()
    assert bound.limits == ProgramLimits(600.0, 20.0)
    assert (bound.goal, bound.allowed.kinds, bound.max_analyses) == ("clean-and-dry", {"speeds"}, 12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"kinds": frozenset()}, "tick at least one"),
        ({"seconds": -1.0}, "Time at most"),
        ({"litres": math.nan}, "Liquid at most"),
        ({"seconds": math.inf}, "Time at most"),
        ({"analyses": 1.0}, "at least 2"),
        ({"analyses": math.nan}, "at least 2"),
        ({"saving": 100.0}, "Worth an analysis"),
        ({"saving": math.nan}, "Worth an analysis"),
    ],
)
def test_impossible_settings_are_refused(wrong, message):
    with pytest.raises(TuningError, match=message):
        replace(TuningSettings(), **wrong).request()


def test_a_proposal_is_one_edit_and_comments_stay():
    session = tiny_session()
    proposed = replace(session, proposal=proposal(session))
    applied = apply_proposal(proposed)
    assert applied.document.text == slower(session.document.text)
    assert applied.proposal is None
    assert applied.recipe != session.recipe
    assert applied.document.undone().text == session.document.text
    assert len(applied.document.past) == len(session.document.past) + 1
    assert apply_proposal(session) is session


def test_edits_made_meanwhile_are_not_lost():
    session = tiny_session()
    proposed = replace(session, proposal=proposal(session))
    edited = proposed.edited(session.document.text + "# mine\n")
    with pytest.raises(JobError, match="not the one that was tuned"):
        apply_proposal(edited)
    assert apply_proposal(edited.with_document(edited.document.undone())).document.text == slower(session.document.text)


def test_a_proposal_becomes_a_new_file_and_the_old_one_stays(tmp_path):
    session = tiny_session()
    project = open_project(tmp_path)
    saved = save_proposal(project, "tuned")(replace(session, proposal=proposal(session)))
    file = tmp_path / "tuned.yaml"
    assert saved.document.file == file
    assert not saved.document.dirty
    assert saved.proposal is None
    assert "# What is sprayed" in file.read_text()
    read = read_recipe_text(file.read_text(), file=file).recipe
    assert read.recipe == "tuned"
    assert read.templates != session.recipe.templates
    assert session.document.file.read_text() == session.document.text
    with pytest.raises(JobError, match="there already"):
        save_proposal(project, "tuned.yaml")(replace(session, proposal=proposal(session)))
    with pytest.raises(JobError):
        save_proposal(project, "../outside")(replace(session, proposal=proposal(session)))


def test_another_board_has_no_proposal():
    session = tiny_session()
    assert replace(session, proposal=proposal(session)).with_workpiece("other", session.board).proposal is None


def test_the_headline_says_what_was_reached():
    session = tiny_session()
    assert headline_of(proposal(session).tuned) == "Predicted clean."
    assert "not clean yet" in headline_of(proposal(session, unmet=[UNMET]).tuned)
    assert "limits cannot be kept" in headline_of(proposal(session, limits=ProgramLimits(seconds=100.0)).tuned)
    same = replace(proposal(session, unmet=[UNMET]).tuned, changes=())
    assert "Nothing was found" in headline_of(same)


def test_totals_and_changes_tell_effect_and_cost():
    proposed = proposal(tiny_session())
    tuned, totals = proposed.tuned, totals_html(proposed)
    for expected in (
        "4 of 5",
        "5 of 5",
        "31.0 %",
        "1.0 %",
        "2.50 l",
        "3.00 l",
        "7 analyses",
        "no proof of cleanliness",
        "All that a recipe can meet is met. Nothing saves 1 %.",
    ):
        assert expected in totals
    changes = changes_html(tuned.changes)
    for expected in ("templates.sweep.speed_mm_s: 60 -&gt; 45", "+20.0 s", "+0.50 l", "2 \N{RIGHTWARDS ARROW} 0"):
        assert expected in changes
    assert changes_html(()) == ""


def test_a_recipe_of_the_front_can_be_chosen_and_is_what_is_applied_then():
    session = tiny_session()
    proposed = proposal(session)
    labels = front_labels(proposed.tuned)
    assert list(labels) == [
        "2: 5 of 5 clean, margin 1.02, 1 min 50 s, 3.00 l",
        "1: 4 of 5 clean, 1 min 30 s, 2.50 l",
    ]
    assert list(labels.values()) == [proposed.text, session.document.text]
    chosen = replace(proposed, chosen=proposed.tuned.trials[0].text)
    assert not chosen.changes
    assert "Chosen of the Pareto front." in totals_html(chosen)
    assert totals_html(chosen).count("uncalibrated") == 1
    fitted = replace(chosen, tuned=replace(chosen.tuned, calibrated=True))
    assert "uncalibrated" not in totals_html(fitted)
    assert "1 min 50 s" not in totals_html(chosen)
    assert apply_proposal(replace(session, proposal=chosen)).document.text == session.document.text


def test_an_interrupted_tuning_states_that_it_was():
    assert "Cancelled; the best until then, found by 7 analyses." in totals_html(
        replace(proposal(tiny_session()), interrupted=True)
    )


def test_the_picture_is_drawn_into_the_page():
    html = front_html(proposal(tiny_session()))
    assert base64.b64decode(re.search(r'base64,([^"]+)', html)[1]).startswith(b"<?xml")


def test_the_diff_shows_changed_lines_and_few_others():
    before = "".join(f"line{number}: <b>\n" for number in range(1, 31))
    after = before.replace("line15: <b>", "line15: <i>")
    html = diff_html(before, after)
    assert "-line15: &lt;b&gt;" in html
    assert "+line15: &lt;i&gt;" in html
    assert "line12" in html
    assert "line11" not in html
    assert "line 12" in html
    assert "<b>" not in html
    assert diff_html(before, before) == ""


def test_open_requirements_have_a_reason():
    session = tiny_session()
    html = reasons_html(proposal(session, unmet=[UNMET]).tuned)
    assert "31 % is left &lt;here&gt;." in html
    assert "R7 residue" in html
    many = [replace(UNMET, component=f"U{number}") for number in range(50)]
    assert "and 10 more" in reasons_html(proposal(session, unmet=many).tuned)
    spent = reasons_html(proposal(session, unmet=[UNMET], used=40).tuned)
    assert "The 40 analyses were spent." in spent
    assert "Analyses at most" in spent
    assert "--" not in re.sub(r'style="[^"]*"', "", spent)  # options are of the command line
    assert "Analyses at most" not in html
    plugged = replace(UNMET, judgement=replace(UNMET.judgement, rule=PLUGGED_GAP))
    assert "Analyses at most" not in reasons_html(proposal(session, unmet=[plugged], used=40).tuned)
    assert reasons_html(proposal(session).tuned) == ""
