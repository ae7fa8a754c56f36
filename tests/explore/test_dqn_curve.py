"""Inside the network, its last picture: what it says of a cell, through training, beside what is exact."""

import re

import numpy as np
import pytest

from course_lib import Maze, value_iteration
from course_lib.explore.dqn import InsideTheNetwork

from . import minus
from .test_dqn import panel, points, texts, trained


def test_the_curve_is_the_cell_through_training():
    state = InsideTheNetwork()
    state.turn("replay", 1)
    trained(state, 14)
    state.choose(7)
    state.turn("episode", 11)
    worth = [moment.q[7].max() for moment in state.run.moments]
    shown = panel(state, "curve")
    assert f"Now (mask, replay, seed 0): {worth[0]:z.2f} after 0, {worth[10]:z.2f} after 100 episodes" in shown.words
    assert f"Looked at: after 110 episodes, {worth[11]:z.2f}." in shown.words
    assert {"exact 0.95", f"{worth[11]:z.2f}"} <= set(texts(shown.svg))
    line = points(re.search(r'<polyline [^>]*stroke="#0072b2"[^>]*>', shown.svg)[0])
    assert np.corrcoef(line[:, 1], worth)[0, 1] < -0.9999
    mark = re.search(r'<circle cx="([\d.]+)" cy="([\d.]+)" r="5"', shown.svg)
    assert [float(x) for x in mark.groups()] == pytest.approx(line[11], abs=0.1)
    best = np.array([moment.earned > 0.7737 for moment in state.run.moments])
    assert f"at {best.sum()} of 15 moments and lose it again {(best[:-1] & ~best[1:]).sum()} times" in shown.words
    assert f"at the top: best way, “now” at {best.sum()} of 15 moments" in texts(shown.svg)
    assert shown.svg.count('width="5"') == best.sum() > 0
    state.choose(6)
    assert not any(text.startswith("exact") for text in texts(panel(state, "curve").svg))


@pytest.mark.parametrize("rules", [{"goal_reward": 10.0}, {"step_reward": -1.0, "wall_reward": -5.0}])
def test_the_exact_line_stands_at_its_height(rules):
    state = trained(InsideTheNetwork(Maze(**{"wall_reward": 0.0} | rules)), 2)
    exact = value_iteration(state.maze.mdp, 0.95).values
    for cell in (0, 11):
        state.choose(cell)
        shown, worth = panel(state, "curve").svg, [moment.q[cell].max() for moment in state.run.moments]
        line = points(re.search(r'<polyline [^>]*stroke="#0072b2"[^>]*>', shown)[0])
        slope, middle = np.polyfit(worth, line[:, 1], 1)
        height = points(re.search(r'<polyline [^>]*stroke-dasharray="1 3"[^>]*>', shown)[0])[0, 1]
        assert height == pytest.approx(slope * exact[cell] + middle, abs=4), "as the other line goes on"
        assert minus(f"exact {exact[cell]:z.2f}") in texts(shown)
