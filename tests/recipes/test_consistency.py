"""The parts of a recipe must fit each other."""

import math
import re

import pytest

from recipes.consistency import half_spread_deg
from recipes.errors import RecipeError
from recipes.load import load_recipe, parse_recipe
from recipes.nozzles import FlatFan, HollowCone, Wavefront

HEAD = "recipe: mine\nextends: smt-aqueous\n"


@pytest.mark.parametrize(
    ("text", "path", "message"),
    [
        (
            "sequence: [{function: rince, nozzle: ring60, paths: [sweep]}]",
            "sequence[0].function",
            "did you mean 'rinse'",
        ),
        (
            "templates: {coat: {path: slices, standoff_mm: 60, slices: 9, spacing_mm: 20}}",
            "templates.coat.spacing_mm",
            "states the spacing besides slices",
        ),
        (
            "templates: {coat: {path: slices, standoff_mm: 60, along: [0, 0, 0]}}",
            "templates.coat.along",
            "is no direction",
        ),
        (
            "templates: {coat: {path: slices, standoff_mm: 9, repair: true, film: {thickness_um: 4, tolerance_um: 1}}}",
            "templates.coat.repair",
            "a film is levelled; leave it out",
        ),
        (
            "templates: {coat: {path: slices, standoff_mm: 60, film: {thickness_um: 40, tolerance_um: 50}}}",
            "templates.coat.film.tolerance_um",
            "is more than the film (40 µm)",
        ),
        ("sequence: [{function: rinse, nozzle: ring, paths: [sweep]}]", "sequence[0].nozzle", "did you mean 'ring60'"),
        (
            "sequence: [{function: rinse, nozzle: ring60, paths: [sweep, swep]}]",
            "sequence[0].paths[1]",
            "did you mean 'sweep'",
        ),
        (
            "sequence: [{function: rinse, nozzle: ring60, paths: [sweep], enabled: false}]",
            "sequence",
            "no step is enabled",
        ),
        ("templates: {around: {passes: {smal: 2}}}", "templates.around.passes.smal", "did you mean 'small'"),
        (
            "templates: {around: {speed_mm_s: {small: 30}}}",
            "templates.around.speed_mm_s",
            "no value for bottom_terminated, fine_pitch, large",
        ),
        ("templates: {step: {delay_s: {larg: 1}}}", "templates.step.delay_s.larg", "did you mean 'large'"),
        ("templates: {around: {only: [huge]}}", "templates.around.only[0]", "no class 'huge'"),
        ("templates: {blow: {speed_mm_s: 90}}", "templates.blow.speed_mm_s", "maximum 80 mm/s: sequence[2]"),
        (
            "templates: {around: {speed_mm_s: {large: 130, default: 20}}}",
            "templates.around.speed_mm_s.large",
            "maximum 120 mm/s: sequence[0] uses it for clean",
        ),
        (
            "templates: {around: {near: {within_mm: 5, speed_mm_s: 121}}}",
            "templates.around.near.speed_mm_s",
            "maximum 120",
        ),
        ("templates: {edge: {height_mm: 5}}", "templates.edge.height_mm", "not above the clearance"),
        (
            "templates: {around: {height_mm: {small: 3, default: 40}}}",
            "templates.around.height_mm.small",
            "not above the clearance",
        ),
        ("limits: {park_height_mm: 5}", "limits.park_height_mm", "not above the clearance"),
        ("templates: {flush: {tilt_deg: 52}}", "templates.flush.tilt_deg", "spray not closed on board"),
        (
            "templates: {around: {near: {within_mm: 5, tilt_deg: 60}}}",
            "templates.around.near.tilt_deg",
            "spray not closed on board",
        ),
        (
            "templates: {spot: {path: straight_line, from: [1, 2], to: [1, 2], height_mm: 40, speed_mm_s: 9}}",
            "templates.spot.to",
            "needs two points",
        ),
        ("masks: [{ignore: ['TP*', ' ']}]", "masks[0].ignore[1]", "is blank"),
        ("classes: {default: {}}", "classes.default", "another name"),
        (
            "sequence: [{function: dry, nozzle: knife, paths: [flush], repeat: 2, "
            "until: {temperature_c: 60, max_repeats: 3}}]",
            "sequence[0]",
            "repeat or until, not both",
        ),
        *(
            (
                f"nozzles: {{ring60: {{wavefront: {{height_mm: 30, points: {points}}}}}}}",
                "nozzles.ring60.wavefront",
                message,
            )
            for points, message in (
                ("[[0, 1, 2], [0, 1, 2], [9, 1, 2]]", "azimuths must ascend"),
                ("[[-0.5, 1, 2], [0, 1, 2], [9, 1, 2]]", "0 <= azimuth < 360"),
                ("[[0, 1, 2], [9, 1, 2], [360, 1, 2]]", "0 <= azimuth < 360"),
                ("[[0, 1, 2], [9, 2, 2], [359, 1, 2]]", "each inner radius must be smaller"),
            )
        ),
        (
            "nozzles: {fan: {pattern: flat_fan, half_angle_deg: 3, flow_lpm: 1}}",
            "nozzles.fan",
            "must be smaller than half_angle_deg",
        ),
        (
            "nozzles: {gun: {pattern: radial, radius_mm: 40, at_mm: 100, flow_lpm: 1, profile: [[0, 1], [30, 0]]}}",
            "nozzles.gun",
            "begin at radius 0 and end at radius_mm",
        ),
        (
            "nozzles: {gun: {pattern: radial, radius_mm: 9, at_mm: 9, flow_lpm: 1, profile: [[0, 1], [9, 0], [9, 0]]}}",
            "nozzles.gun",
            "radii of the profile must ascend",
        ),
        (
            "nozzles: {gun: {pattern: radial, radius_mm: 40, at_mm: 100, flow_lpm: 1, profile: [[0, 0], [40, 0]]}}",
            "nozzles.gun",
            "some flux above 0",
        ),
        (
            "nozzles: {gun: {pattern: radial, radius_mm: 40, at_mm: 3, flow_lpm: 1}}",
            "nozzles.gun",
            "wider than 85 degrees",
        ),
        ("classes: {small: {pins: {min: 9, max: 3}}}", "classes.small.pins", "min 9 is above max 3"),
    ],
)
def test_parts_that_do_not_fit(text: str, path: str, message: str) -> None:
    with pytest.raises(RecipeError, match=re.escape(message)) as caught:
        parse_recipe(HEAD + text, file="mine.yaml")
    assert caught.value.path == path
    assert caught.value.line is not None


def test_a_wavefront_may_begin_anywhere_and_end_just_before_a_turn() -> None:
    for first in (0.0, 0.5):
        points = [(first, 1.0, 2.0), (90.0, 1.0, 2.0), (359.9, 1.0, 2.0)]
        assert Wavefront(height_mm=30.0, points=points).points[0][0] == first


def test_classes_that_a_template_leaves_out_need_no_value() -> None:
    recipe = parse_recipe(HEAD + "templates: {around: {only: [small], passes: null, speed_mm_s: {small: 30}}}\n")
    assert recipe.templates["around"].model_dump()["speed_mm_s"] == {"small": 30}


def test_a_recipe_without_classes_is_refused() -> None:
    classes = ", ".join(f"{name}: null" for name in load_recipe("smt-aqueous").classes)
    with pytest.raises(RecipeError, match="at least one class"):
        parse_recipe(f"{HEAD}classes: {{{classes}}}\n")


def test_the_same_speed_is_fine_for_a_faster_function() -> None:
    text = "functions: {dry: {max_speed_mm_s: 100}}\ntemplates: {flush: {speed_mm_s: 90}}\n"
    assert parse_recipe(HEAD + text).templates["flush"].model_dump()["speed_mm_s"] == 90


def test_a_measured_ring_that_is_wider_than_the_half_angle_counts() -> None:
    ring = Wavefront(height_mm=50, points=[(0, 20, 30), (120, 20, 50), (240, 20, 30)])
    assert half_spread_deg(HollowCone(half_angle_deg=30, flow_lpm=2)) == 30
    assert math.isclose(half_spread_deg(HollowCone(half_angle_deg=30, flow_lpm=2, wavefront=ring)), 45)
    assert half_spread_deg(FlatFan(half_angle_deg=40, flow_lpm=2)) == 40
