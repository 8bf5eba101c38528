"""Joint curves: values, limits, and the labels that state how near they are."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shown_cell import shown_cell

from programs.program import MoveTo
from reports.pictures.joint_picture import QUANTITIES, envelope, joint_curves
from robotcell.motion.retime import rates_of

JOINT = shown_cell().robot.joints[0]


def rates_at(times, joints):
    moves = [MoveTo(time_s, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0, "") for time_s in times]
    return rates_of(SimpleNamespace(instructions=moves), np.array(joints, dtype=float).reshape(len(times), -1))


def test_speed_and_acceleration_of_a_known_motion():
    times = np.linspace(0.0, 2.0, 401)
    rates = rates_at(times, np.radians(10.0) * np.sin(3.0 * times))
    position, speed, acceleration = (joint_curves([JOINT], rates, each)[0] for each in QUANTITIES)
    np.testing.assert_allclose(position.values, 10.0 * np.sin(3.0 * times), atol=1e-9)
    np.testing.assert_allclose(speed.values, 30.0 * np.cos(3.0 * speed.times), atol=0.01)
    inner = slice(1, -1)  # from rest and to rest at the ends
    np.testing.assert_allclose(acceleration.values[inner], -90.0 * np.sin(3.0 * acceleration.times[inner]), atol=0.7)
    assert (position.unit, speed.unit, acceleration.unit) == ("°", "°/s", "°/s²")
    assert speed.highest == pytest.approx(np.degrees(JOINT.speed))


def test_an_even_acceleration_is_exact_however_samples_are_spaced():
    times = np.array([0.0, 0.058, 0.1, 0.126, 0.146, 0.2, 0.21])
    curve = joint_curves([JOINT], rates_at(times, 0.5 * np.radians(200.0) * times**2), "acceleration")[0]
    np.testing.assert_allclose(curve.values[1:-1], 200.0, rtol=1e-6)


def test_a_linear_axis_is_in_millimetres():
    slide = replace(JOINT, kind="prismatic", speed=0.5)
    speed = joint_curves([slide], rates_at([0.0, 2.0], [0.0, 0.5]), "speed")[0]
    assert speed.values.tolist() == [250.0]
    assert speed.summary == "250 of 500 mm/s (50%)"


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), samples=st.integers(2, 300), columns=st.integers(1, 60))
def test_an_envelope_leaves_no_extreme_out_and_adds_none(seed, samples, columns):
    random = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.sort(random.uniform(0.0, 7.0, samples - 2)), [7.0]])
    values = random.normal(size=samples)
    low, high = envelope(times, values, 7.0, columns)
    assert low.shape == high.shape == (columns,)
    assert (low <= high).all()
    assert low.min() == pytest.approx(values.min())
    assert high.max() == pytest.approx(values.max())
    assert (high[:-1] >= low[1:] - 1e-9).all()  # neighbours touch: what is drawn has no gap
    assert (low[:-1] <= high[1:] + 1e-9).all()


def test_the_label_states_what_is_beyond_a_limit_and_what_has_none():
    joints = (replace(JOINT, speed=np.radians(20.0), highest=np.radians(25.0)), replace(JOINT, speed=np.inf))
    rates = rates_at([0.0, 1.0], np.radians([[0.0, 0.0], [30.0, 30.0]]))
    fast, free = joint_curves(joints, rates, "speed")
    assert [fast.use, free.use] == pytest.approx([1.5, 0.0])
    assert fast.summary == "30 of 20°/s (150%)"
    assert free.summary == "30°/s, no limit"
    assert joint_curves(joints, rates, "position")[0].summary == "0 to 30°, 5.0° beyond"
    assert fast.span[0] < -20.0
    assert fast.span[1] > 30.0
