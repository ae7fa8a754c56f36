"""How good a table is: against ways that are walked cell by cell, and against a policy's exact value."""

import itertools

import numpy as np
import pytest

from course_lib import Action, Maze, evaluate_policy, value_iteration
from course_lib.explore.how_good import greedy_way, leads_straight, returns_of

FREE = {"wall_ends_episode": False}


def straight_by_walking(world, q):
    """Every way along best actions, walked: the slow and sure answer."""
    shortest = dict.fromkeys(world.goals, 0)
    for steps in range(1, world.grid.size):
        for s, a in itertools.product(range(world.grid.size), range(4)):
            if shortest.get(int(world.mdp.next_state[s, a, 0])) == steps - 1 and world.grid.flat[s] in (0, 3):
                shortest.setdefault(s, steps)
    at, steps = {world.start}, shortest[world.start]
    for _ in range(steps):
        at = {
            int(world.mdp.next_state[s, a, 0])
            for s in at - set(world.goals)
            for a in np.flatnonzero(np.isclose(q[s], q[s].max(), rtol=0, atol=1e-9))
        }
    return at <= set(world.goals)


@pytest.mark.parametrize(
    "world", [Maze(**FREE), Maze(), Maze.random(5, 6, seed=8, **FREE)], ids=["course", "strict", "random"]
)
def test_which_tables_lead_straight(world):
    rng = np.random.default_rng(1)
    exact = value_iteration(world.mdp, 0.9).q
    tables = exact + rng.choice([0.0, 1e-12, 0.3], size=(200, 1, 1)) * rng.normal(size=(200, *exact.shape))
    tables[:3] = 0.0
    tables[3:40] = np.where(rng.random((37, *exact.shape)) < 0.05, 1.0, exact)
    found = leads_straight(world, tables)
    assert found.tolist() == [straight_by_walking(world, q) for q in tables]
    assert 40 < found.sum() < 190
    assert not found[:3].any()


def test_a_bump_that_ends_the_walk_is_no_way_to_the_cheese():
    world = Maze([[3, 1], [0, 4]])
    q = np.zeros((1, 4, 4))
    q[0, 0, Action.RIGHT] = 1.0
    assert not leads_straight(world, q)[0]


@pytest.mark.parametrize("slip", [0.1, 0.5])
@pytest.mark.parametrize("gamma", [0.5, 0.95])
@pytest.mark.parametrize("rules", [FREE, {}], ids=["free", "strict"])
def test_what_tables_earn_is_their_policys_value(slip, gamma, rules):
    world, rng = Maze(**rules, slip=slip), np.random.default_rng(2)
    tables = np.round(value_iteration(world.mdp, gamma).q + rng.normal(scale=0.2, size=(30, 16, 4)), 1)
    best = tables >= tables.max(axis=2, keepdims=True)
    expected = [evaluate_policy(world.mdp, b / b.sum(axis=1, keepdims=True), gamma)[0] for b in best]
    assert returns_of(world, tables, gamma) == pytest.approx(expected, abs=1e-4)


def test_ways_that_lead_nowhere_are_told():
    world, q = Maze(**FREE), np.zeros((16, 4))
    assert greedy_way(world, q) == ([], "in cell 0 all actions are alike to it")
    q[0, Action.UP] = 1
    assert greedy_way(world, q) == ([(0, 0)], "it runs in a circle through cell 0")
    q[0], q[1] = (0, 0, 0, 1), (0, 0, 1, 0)
    assert greedy_way(world, q) == ([(0, 3), (1, 2)], "it runs in a circle through cell 0")
    q[1] = (0, 0, 0, 1)
    q[2] = (0, 1, 0, 0)
    assert greedy_way(Maze(), q)[1] == "a bump in cell 2 ends it"
    assert greedy_way(world, q) == ([(0, 3), (1, 3), (2, 1)], "it runs in a circle through cell 2")
