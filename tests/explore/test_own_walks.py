"""One's own walks of lesson 0 beside the hundred agents of lesson 3."""

import re
from html import unescape

import numpy as np
import pytest

from course_lib import Maze, explore
from course_lib.explore.hundred_agents import NUM_EPISODES, QLearning
from course_lib.explore.mouse import KEPT_IN, keep_walks

from .test_hundred_agents import curve

WALKS = ([-3.0, -1.0, 1.0], [31, 14, 6])


def test_ones_own_walks_stand_beside_the_agents():
    explored = QLearning(walks=WALKS)
    drawn = curve(explored)
    assert "you, in lesson 0<" in drawn.svg
    assert drawn.words.endswith("You, in lesson 0: 31, 14, 6.")
    assert len(re.findall(r'<rect [^>]*stroke="#ffffff" stroke-width="0.8"', drawn.svg)) == 3 + 1, "walks, legend"
    explored.turn("curve", 1)
    assert curve(explored).words.endswith("You, in lesson 0: −3, −1, 1.")
    explored.press("walks")
    assert "you" not in unescape(curve(explored).svg)
    assert explored.view().control("walks").label == "show my walks from lesson 0"
    explored.press("walks")
    assert "you, in lesson 0" in curve(explored).svg
    assert explored.view().control("walks").label == "hide my walks"
    assert "3 of them. The last one took 6 moves and had a reward of +1" in explored.message
    quick = QLearning(walks=([1.0], [1]))
    quick.press("walks")
    quick.press("walks")
    assert "The last one took 1 move and" in quick.message
    assert QLearning(Maze([[3, 4]])).message.startswith("Episode 10: 1 move in the median; episode 100: 1 move (5")


def test_very_long_walks_have_room():
    explored = QLearning(walks=([-900.0], [4000]))
    for stop in (0, 1):
        explored.turn("curve", stop)
        square = re.findall(r'<rect x="[\d.]+" y="([\d.]+)" width="8" height="8"', curve(explored).svg)[0]
        assert 46 < float(square) < 46 + 230


def test_the_walks_kept_in_lesson_0_are_read_when_asked_for_and_not_before(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    without = explore.q_learning().still()
    explored = QLearning()
    explored.press("walks")
    assert explored.message.startswith("There are no walks of yours yet: play lesson 0")
    assert "you" not in curve(explored).svg
    for damaged in ("{", '{"returns": [1], "lengths": []}', '{"returns": "a"}'):
        (tmp_path / KEPT_IN).write_text(damaged, encoding="utf-8")
        explored.press("walks")
        assert explored.message.startswith("my_mouse.json cannot be read as walks")
        assert "you" not in curve(explored).svg
    keep_walks(KEPT_IN, *WALKS)
    assert explore.q_learning().still() == without
    explored.press("walks")
    assert curve(explored).words.endswith("You, in lesson 0: 31, 14, 6.")


@pytest.mark.parametrize(("walks", "last"), [(3, 30), (25, 30), (28, 33), (97, 100), (130, 130)])
@pytest.mark.parametrize("stop", [0, 1])
def test_ones_own_walks_have_room_beside_the_agents(walks, last, stop):
    explored = QLearning(walks=([1.0] * walks, [6] * walks))
    explored.turn("curve", stop)
    svg = curve(explored).svg
    squares = [float(x) + 4 for x in re.findall(r'<rect x="([\d.]+)" y="[\d.]+" width="8" height="8"', svg)[:walks]]
    left, right = 46, 352
    assert np.diff(squares) == pytest.approx((right - left) / (1.03 * last), abs=0.02)
    assert max(squares) < right
    assert (f">episode, up to {last} of 100<" in svg) == (last < NUM_EPISODES)
    agents = next(m for m in re.findall(r'<polyline points="([^"]*)"[^>]*stroke="#0072b2"', svg) if m.count(" ") > 5)
    assert len(agents.split()) == min(last, NUM_EPISODES)
    assert ("episode 50:" in curve(explored).words) == (last >= 50), "the words are those of the picture"
    explored.press("walks")
    assert ">episode<" in curve(explored).svg
    assert "episode 100:" in curve(explored).words
    explored.press("walks")
    assert explored.message.endswith(f"While they are shown, the curve ends at episode {last}.")
