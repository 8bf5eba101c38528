import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from programs.motion.samples import SampledLine

PLACES = st.lists(st.floats(0.0, 1.0).map(lambda each: round(each, 2)), min_size=1, max_size=30)


@given(PLACES, st.floats(-0.5, 1.5), st.integers(0, 3))
def test_between_samples_the_motion_is_straight_and_beyond_them_it_stands(
    inner: list[float], place_at: float, dof: int
) -> None:
    shares = np.array([0.0, *sorted(inner), 1.0])  # several may be one
    joints = np.sin(np.arange(len(shares) * dof, dtype=np.float64)).reshape(len(shares), dof)
    line = SampledLine(np.cumsum(1.0 + shares), shares, joints)
    for place in (place_at, float(shares[len(inner) // 2])):
        row = [float(np.interp(place, shares, column)) for column in joints.T]
        assert line.second_at(place) == np.interp(place, shares, line.seconds)
        assert line.joints_at(place) == tuple(row)
        assert line.joints_at_each(np.array([place])).tolist() == [row]
    now = float(line.seconds[0]) + place_at * len(shares)
    assert line.share_at(now) == np.interp(now, line.seconds, shares)
    assert line.joints_when(np.array([now])).tolist() == [[np.interp(now, line.seconds, each) for each in joints.T]]
