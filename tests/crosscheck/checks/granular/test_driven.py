"""How the checks of driven soft scenes reduce their runs, on data whose outcome is known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosscheck.checks.granular.driven import hard_limit, profile
from crosscheck.scene import Floats
from crosscheck.statistics import Mean


@given(
    value=st.floats(-10, 10),
    slope=st.floats(-100, 100),
    errors=st.lists(st.floats(0.1, 10), min_size=2, max_size=5),
)
def test_hard_limit_of_a_line_is_its_start(value: float, slope: float, errors: list[float]) -> None:
    durations = [0.01 * 2**part for part in range(len(errors))]
    means = [Mean(value + slope * t, u, 100.0, 20.0) for t, u in zip(durations, errors, strict=True)]
    assert hard_limit(durations, means).value == pytest.approx(value, abs=1e-9)


def test_hard_limit_of_two_means_is_twice_the_nearer_less_the_other() -> None:
    limit = hard_limit([0.02, 0.01], [Mean(5.0, 0.3, 50.0, 10.0), Mean(4.0, 0.4, 20.0, 4.0)])
    assert limit.value == pytest.approx(3.0)
    assert limit.error == pytest.approx(math.hypot(0.3, 0.8))
    assert limit.independent == 20.0


def test_hard_limit_has_the_error_that_it_says() -> None:
    rng = np.random.default_rng(3)
    durations, errors = [0.04, 0.02, 0.01], np.array([0.1, 0.2, 0.1])
    limits = [
        hard_limit(durations, [Mean(v, u, 50.0, 10.0) for v, u in zip(rng.normal(0, errors), errors, strict=True)])
        for _ in range(2000)
    ]
    values = np.array([limit.value for limit in limits])
    # the standard deviation of 2000 normal numbers is known to 1/sqrt(4000): four of these
    assert values.std() == pytest.approx(limits[0].error, rel=4 / math.sqrt(4000))


@pytest.mark.parametrize(("durations", "error"), [([0.01, 0.01], 1.0), ([0.02, 0.01], 0.0)])
def test_hard_limit_needs_two_durations_and_errors(durations: list[float], error: float) -> None:
    with pytest.raises(ValueError, match="two durations and positive errors"):
        hard_limit(durations, [Mean(1.0, error, 10.0, 2.0), Mean(2.0, 1.0, 10.0, 2.0)])


def _uniform(samples: int) -> Floats:
    return np.random.default_rng(1).uniform(0, 4, size=(samples, 50))


def test_profile_gives_the_mean_of_each_bin() -> None:
    x = _uniform(401)
    found = profile(x, np.floor(x) ** 2, np.arange(7.0), blocks=4)
    assert found.share.shape == found.mean.shape == (4, 6)
    assert found.mean[:, :4] == pytest.approx(np.tile([0.0, 1.0, 4.0, 9.0], (4, 1)))
    assert np.isnan(found.mean[:, 4:]).all()
    assert found.share.sum(axis=1) == pytest.approx(np.ones(4))


def test_profile_keeps_stretches_apart() -> None:
    x = np.full((40, 3), 0.5)
    found = profile(x, np.repeat(np.arange(40.0)[:, None], 3, axis=1), [0.0, 1.0], blocks=4)
    assert found.mean[:, 0] == pytest.approx([4.5, 14.5, 24.5, 34.5])
    mean = found.means(found.mean)[0]
    assert mean.value == pytest.approx(19.5)
    assert mean.error == pytest.approx(np.std([4.5, 14.5, 24.5, 34.5], ddof=1) / 2)
    assert mean.independent == 4
