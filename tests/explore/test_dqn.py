"""Inside the network: what is trained, what is kept of it, and that the pictures say what the networks say."""

import re
import time

import numpy as np
import pytest

from course_lib import Action, DQNAgent, Maze, value_iteration
from course_lib.explore.dqn import InsideTheNetwork, network
from course_lib.explore.drawing.sketch import shade
from course_lib.explore.training import EPISODES
from course_lib.maze import MOVES
from course_lib.plots.board import acting_states

from . import minus

MAZE = Maze(wall_reward=0.0)
EXACT = value_iteration(MAZE.mdp, 0.95)
NOBODY_ACTS_IN = (6, 10, 12, 15)


def panel(state, name):
    return next(panel for panel in state.view().panels if panel.name == name)


def texts(svg):
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


def points(shape):
    """The corners of an SVG line or shape, float64[N, 2]."""
    return np.array([pair.split(",") for pair in re.search('points="([^"]*)"', shape)[1].split()], float)


def trained(state, times):
    """The state after so many steps of its longer work."""
    work = state.press("train")
    for _ in range(times):
        next(work)
    state.press("stop")
    return state


def test_the_first_view_is_the_untrained_network_of_seed_0():
    state, agent = InsideTheNetwork(), DQNAgent(MAZE, seed=0)
    np.testing.assert_allclose(state.moment.q, agent.q_values(np.arange(16))[0], atol=1e-6)
    assert state.moment.tries.sum() == 0
    assert state.cell == 0
    assert state.message == (
        "Untrained: press train. Cell 0 (row 0, column 0) after 0 episodes: the best is DOWN, 0.27 (exact: 0.77)."
        " From the start its arrows bring a discounted return of 0.00; the best possible is 0.77."
    )
    assert (state.view().control("episode").at, state.view().progress) == (0, None)
    assert [panel.svg for panel in state.view().panels] == [panel.svg for panel in InsideTheNetwork().view().panels]
    assert network().still() == network().still()


def test_training_shows_a_bar_and_the_scrubber_goes_along():
    state = InsideTheNetwork()
    work = state.press("train")
    assert state.view().progress == 0
    assert "mask, seed 0 plays up to 500 episodes" in state.message
    next(work)
    next(work)
    view = state.view()
    assert view.progress == pytest.approx(20 / 500)
    assert view.control("episode").at == 2
    assert (view.control("train").idle, view.control("stop").idle) == (True, False)
    assert state.press("train") is None, "it is under way already"
    state.turn("episode", 1)
    next(work)
    assert state.view().control("episode").at == 1, "whoever looks back is left in peace"
    state.turn("episode", 50)
    assert state.view().control("episode").at == 3
    state.arrow(Action.RIGHT)
    assert state.message == "Training goes on. You look at cell 1 (row 0, column 1)."
    next(work)
    assert state.view().control("episode").at == 4


def test_stop_keeps_what_was_learned_and_train_goes_on():
    state = trained(InsideTheNetwork(), 3)
    assert state.message.startswith("Stopped; train goes on from here. Cell 0 (row 0, column 0) after 30 episodes")
    assert state.view().progress is None
    assert (state.view().control("train").idle, state.view().control("stop").idle) == (False, True)
    straight = trained(InsideTheNetwork(), 5)
    assert (trained(state, 2).moment.q == straight.moment.q).all()
    state.press("stop")
    assert state.run.episodes == 50


def test_work_that_was_stopped_is_over():
    state = InsideTheNetwork()
    work = state.press("train")
    next(work)
    state.press("stop")
    assert list(work) == []
    assert state.run.episodes == 10
    work = state.press("train")
    state.turn("seed", 1)
    assert list(work) == []
    assert state.view().progress is None


def test_training_ends(monkeypatch):
    assert EPISODES == 500
    monkeypatch.setattr("course_lib.explore.dqn.EPISODES", 40)
    state = trained(InsideTheNetwork(), 2)
    assert len(list(state.press("train"))) == 2
    found = sum(moment.earned > 0.7737 for moment in state.run.moments)
    assert state.message.startswith(
        f"Trained: mask, seed 0. It finds the best way at {found} of 5 moments. Cell 0 (row"
    )
    assert state.view().progress is None
    assert state.view().control("train").idle
    assert state.press("train") is None
    assert len(state.run.moments) == 5


def test_scrubbing_shows_an_earlier_moment():
    state = trained(InsideTheNetwork(), 3)
    moments = state.run.moments
    for at in (0, 2, 3, 1):
        state.turn("episode", at)
        assert state.moment is moments[at]
        assert texts(panel(state, "map").svg)[0] == f"max Q after {10 * at} episodes"
        assert f"after {10 * at} episodes" in state.message
    state.turn("episode", 7)
    assert state.moment is moments[3]
    assert state.message.startswith("It has been trained for 30 episodes only.")


def test_other_switches_are_other_networks_and_none_is_forgotten():
    state = trained(InsideTheNetwork(), 4)
    first = state.run
    state.turn("episode", 3)
    state.turn("mask", 0)
    assert state.run.name == "no mask, seed 0"
    assert (state.run.episodes, state.view().control("episode").at) == (0, 0)
    assert "no mask, seed 0 is untrained: press train" in state.message
    trained(state, 3)
    assert "before: mask, seed 0" in texts(panel(state, "curve").svg)
    state.turn("mask", 1)
    assert state.run is first
    assert state.view().control("episode").at == 3
    assert "is trained for 40 episodes; train goes on" in state.message
    assert {"now: mask, seed 0", "before: no mask, seed 0"} <= set(texts(panel(state, "curve").svg))
    state.turn("mask", 1)
    assert "before: no mask, seed 0" in texts(panel(state, "curve").svg), "nothing was changed"


def test_an_untrained_network_is_no_earlier_one():
    state = InsideTheNetwork()
    state.turn("mask", 0)
    assert not any(text.startswith("before") for text in texts(panel(state, "curve").svg))


def test_double_and_the_target_network_go_together():
    state = InsideTheNetwork()
    state.turn("double", 1)
    assert state.view().control("target").at == 1
    assert state.message.startswith("Double asks a second network")
    assert state.run.name == "mask, target, double, seed 0"
    state.turn("target", 0)
    assert state.view().control("double").at == 0
    assert state.message.startswith("Without a target network")
    assert state.run.name == "mask, seed 0"
    state.turn("target", 1)
    assert state.message.startswith("The network with mask, target, seed 0")


def test_cells_are_chosen_by_click_and_by_keys_also_inside_walls():
    state = InsideTheNetwork()
    state.arrow(Action.UP)
    assert state.cell == 0
    for action, cell in ((Action.DOWN, 4), (Action.RIGHT, 5), (Action.RIGHT, 6), (Action.LEFT, 5), (Action.UP, 1)):
        state.arrow(action)
        assert state.cell == cell
    state.choose(4)
    state.arrow(Action.LEFT)
    assert state.cell == 4
    state.choose(15)
    assert (state.cell, type(state.cell)) == (15, int)
    assert "nobody ever acts at the cheese; a table would hold 0" in state.message
    state.arrow(Action.RIGHT)
    state.arrow(Action.DOWN)
    assert state.cell == 15
    state.choose(6)
    assert "nobody ever acts inside a wall" in state.message
    drawn = panel(state, "map").svg
    place = r'<rect x="([\d.]+)" y="([\d.]+)" [^>]*'
    framed, filled = re.search(place + 'stroke="#0072b2"', drawn), re.search(place + 'data-cell="6"', drawn)
    assert np.abs(np.subtract(*([float(x) for x in found.groups()] for found in (framed, filled)))).max() < 3


def test_the_map_says_what_the_network_and_the_equations_say():
    state = trained(InsideTheNetwork(), 6)
    shown, q = panel(state, "map"), state.moment.q
    written = texts(shown.svg)
    for s in range(16):
        value = f"{q[s].max():z.2f}"
        visits = state.moment.tries[s].sum()
        best = Action(q[s].argmax()).name
        assert value in written
        assert f"{visits:,}×" in written
        truth = "nobody acts here" if s in NOBODY_ACTS_IN else f"exact {EXACT.values[s]:.2f}"
        assert f"cell {s}: {value} by {best}, {truth}, {visits} actions taken" in shown.words
        if s not in NOBODY_ACTS_IN:
            assert truth in written
            colour = shade(q[s].max(), 0, 1)[0]
            assert re.search(rf'fill="{colour}" data-cell="{s}"', shown.svg)
    arrows = [points(found) for found in re.findall(r'<polygon [^>]*fill="#ffffff"[^>]*>', shown.svg)]
    acting = np.delete(np.arange(16), NOBODY_ACTS_IN)
    for arrow, s in zip(arrows, acting, strict=True):
        ahead = arrow[3] - arrow[[0, 6]].mean(axis=0)
        right, down = (ahead / abs(ahead).max()).round()
        assert [down, right] == MOVES[q[s].argmax()].tolist()
    assert shown.board


@pytest.mark.parametrize("rules", [{}, {"step_reward": -1.0}])
def test_the_map_says_what_its_colours_mean(rules):
    state = InsideTheNetwork(Maze(**{"wall_reward": 0.0} | rules))
    shown, exact = panel(state, "map").svg, value_iteration(state.maze.mdp, 0.95).q[acting_states(state.maze)]
    low, high = min(0.0, exact.min()), max(0.1, exact.max())
    assert {f"{minus(f'{low:.3g}')} or less", f"{minus(f'{high:.3g}')} or more"} <= set(texts(shown))
    key = re.findall(r'fill="(#\w+)"/>', shown.split(" or less")[1].split(" or more")[0])
    assert key == [shade(share, 0, 1)[0] for share in np.linspace(0, 1, 8)]


def test_the_message_says_what_following_the_arrows_earns():
    state = trained(InsideTheNetwork(), 2)
    assert (
        f"From the start its arrows bring a discounted return of {state.moment.earned:z.2f}; the best possible is 0.77."
        in state.message
    )
    best = Action(state.moment.q[0].argmax()).name
    assert f"the best is {best}, {state.moment.q[0].max():.2f} (exact: 0.77)" in state.message


@pytest.mark.parametrize("cell", [0, 6, 14])
def test_the_network_is_shown_node_by_node(cell):
    state = trained(InsideTheNetwork(), 4)
    state.choose(cell)
    (w1, b1), (w2, b2) = state.moment.layers
    arriving = w1[cell] + b1
    hidden = np.maximum(arriving, 0)
    shown = panel(state, "network")
    written = texts(shown.svg)
    assert written.count("1") - 1 == 1, "an input that is 1, and one of that number"
    assert written.count("silent") + written.count("dead") == (arriving <= 0).sum()
    for i, value in enumerate(hidden):
        if value > 0:
            assert f"{value:.2f}" in written
            assert f"{i + 1}: {value:.2f}" in shown.words
    q = hidden @ w2 + b2
    np.testing.assert_allclose(q, state.moment.q[cell])
    names = ("↑ UP", "↓ DOWN", "← LEFT", "→ RIGHT")
    assert f"hidden nodes: {(arriving > 0).sum()} of {len(arriving)} speak" in written
    assert [minus(f"{value:z.2f}") for value in q] == [written[written.index(name) + 1] for name in names]
    best = Action(q.argmax()).name
    assert shown.words.endswith(f"The best is {best}.")
    assert f"the thicker, the more. On the right only those to {'↑↓←→'[q.argmax()]} {best}." in written


def test_answers_stand_beside_the_truth():
    state = trained(InsideTheNetwork(), 4)
    state.choose(14)
    shown, q, tries = panel(state, "answers"), state.moment.q[14], state.moment.tries[14]
    written = texts(shown.svg)
    for a in Action:
        at = written.index(f"{'↑↓←→'[a]} {a.name}")
        assert written[at + 1 : at + 4] == [f"tried {tries[a]:,}×", minus(f"{q[a]:z.2f}"), f"{EXACT.q[14, a]:.2f}"]
        assert f"{a.name} {tries[a]} times" in shown.words
    assert "Exact: UP 0.00, DOWN 0.95, LEFT 0.90, RIGHT 1.00." in shown.words
    state.choose(6)
    assert "Nobody ever acts here." in texts(panel(state, "answers").svg)
    assert "Exact" not in panel(state, "answers").words


def test_the_page_is_heard_while_a_network_trains_in_a_thread():
    explorer = network()
    explorer.do("press", "train")
    waits = []
    for cell in range(5):
        started = time.perf_counter()
        explorer.do("choose", cell)
        waits.append(time.perf_counter() - started)
        assert explorer.state.cell == cell
    explorer.do("press", "stop")
    assert explorer.wait(30)
    assert explorer.progress is None
    assert explorer.state.run.episodes < EPISODES
    assert np.median(waits) < 2


def test_after_a_fault_train_can_be_pressed_again(monkeypatch):
    state = InsideTheNetwork()

    def fault(_):
        raise RuntimeError("no room")

    with monkeypatch.context() as broken:
        broken.setattr("course_lib.explore.training.Training.go_on", fault)
        with pytest.raises(RuntimeError, match="no room"):
            next(state.press("train"))
    assert (state.view().progress, state.view().control("train").idle) == (None, False)
    next(state.press("train"))
    assert state.run.episodes == 10


def test_other_mazes():
    state = InsideTheNetwork(Maze(((3, 0), (1, 4)), goal_reward=10.0, wall_reward=-1.0))
    assert len(state.moment.q) == 4
    trained(state, 2)
    assert "exact 10.00" in texts(panel(state, "map").svg)
    state.arrow(Action.DOWN)
    state.arrow(Action.DOWN)
    assert state.cell == 2


@pytest.mark.parametrize("maze", ["maze", Maze.random(6, 5, seed=0)])
def test_what_cannot_be_drawn_is_refused(maze):
    with pytest.raises(ValueError, match=r"a Maze is needed|at most 5"):
        InsideTheNetwork(maze)


@pytest.mark.parametrize(
    "do",
    [
        ("turn", "gamma", 0), ("turn", "episode", 51), ("turn", "seed", 10), ("turn", "mask", 2),
        ("turn", "mask", "on"), ("turn", "episode", -1), ("press", "forget"), ("choose", 16),
        ("choose", -1), ("choose", "0"),
    ],
)  # fmt: skip
def test_what_there_is_not_is_refused_before_anything_changes(do):
    state = trained(InsideTheNetwork(), 1)
    before = state.view().plain()
    with pytest.raises(ValueError, match=r"."):
        getattr(state, do[0])(*do[1:])
    assert state.view().plain() == before
