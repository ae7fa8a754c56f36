"""What an agent's training and one walk are remembered by."""

import numpy as np
import pytest

from course_lib import History, Rollout


def history(returns):
    returns = np.array(returns, float)
    return History(
        returns, np.ones(returns.shape, np.int64), np.ones(returns.shape, bool), np.zeros(returns.shape, bool)
    )


@pytest.mark.parametrize("window", [1, 2, 7, 50, 200])
def test_the_curve_is_the_mean_of_the_latest_returns(window):
    returns = np.random.default_rng(0).normal(size=100)
    expected = [returns[max(0, i + 1 - window) : i + 1].mean() for i in range(100)]
    np.testing.assert_allclose(history(returns).curve(window), expected, atol=1e-12)


def test_the_curve_of_an_ensemble_is_each_agents_own():
    returns = np.random.default_rng(0).normal(size=(3, 40))
    expected = [history(agents_own).curve(5) for agents_own in returns]
    np.testing.assert_allclose(history(returns).curve(5), expected, atol=1e-12)


def test_the_curve_of_an_agent_with_fewer_episodes_ends_where_they_end():
    returns = np.array([[1.0, 2.0, 3.0, 4.0], [1.0, 3.0, np.nan, np.nan]])
    curve = history(returns).curve(2)
    assert curve[0].tolist() == [1.0, 1.5, 2.5, 3.5]
    assert curve[1, :2].tolist() == [1.0, 2.0]
    assert np.isnan(curve[1, 2:]).all()


def test_the_curve_leaves_the_history_as_it_was():
    record = history([1, 2, 3])
    record.curve(2)
    assert record.episode_return.tolist() == [1, 2, 3]


def test_whole_rewards_give_a_curve_in_fractions():
    record = History(np.array([1, 2]), np.ones(2), np.ones(2), np.zeros(2))
    assert record.curve(2).tolist() == [1.0, 1.5]


def test_a_history_is_as_long_as_it_has_episodes():
    assert len(history([1, 2, 3])) == 3
    assert len(history(np.zeros((4, 7)))) == 7


def test_an_empty_history_has_an_empty_curve():
    assert history([]).curve().tolist() == []


def test_a_rollout_is_as_long_as_it_has_steps_and_discounts_its_rewards():
    walk = Rollout(np.array([0, 1, 2, 3]), np.array([3, 3, 1]), np.array([1.0, 2.0, 4.0]), True, False)
    assert len(walk) == 3
    assert walk.discounted_return(0.5) == 1 + 0.5 * 2 + 0.25 * 4
    assert walk.discounted_return(0) == 1.0
    assert walk.discounted_return(1) == 7.0


def test_a_walk_of_no_steps_is_worth_nothing():
    assert Rollout(np.array([0]), np.array([], int), np.array([]), False, True).discounted_return(0.9) == 0.0
