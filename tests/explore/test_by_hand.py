"""Bellman by hand: what the buttons do to values and policy, and the equation of a cell, against the planners."""

import re
from fractions import Fraction

import numpy as np
import pytest

from course_lib import Action, Maze, bellman_sweep, evaluate_policy, value_iteration
from course_lib.explore import BellmanByHand, Explorer, bellman
from course_lib.explore.drawing.board import acting_states

DRY = {"wall_reward": 0.0, "wall_ends_episode": False}


def panel(state, name):
    return next(panel for panel in state.view().panels if panel.name == name)


def turned(state, name, text):
    state.turn(name, state.view().control(name).texts.index(text))
    return state


def pressed(state, *names):
    for name in names:
        state.press(name)
    return state


def plain_text(html):
    return re.sub(r"<[^>]*>", " ", html)


def number(text):
    return float(text.replace("−", "-"))


def assert_solved(state):
    best = value_iteration(state.world.mdp, state.gamma, tolerance=1e-12)
    assert state.values == pytest.approx(best.values, abs=1e-9)
    assert evaluate_policy(state.world.mdp, state.policy, state.gamma) == pytest.approx(best.values, abs=1e-9)


# --- evaluate and improve


def test_it_begins_with_nothing_known():
    state = BellmanByHand()
    assert not state.values.any()
    assert (state.policy == 0.25).all()
    assert (state.cell, state.gamma, state.way) == (14, 0.9, [0])
    assert "polygon" in panel(state, "map").svg, "the cheese"
    assert panel(state, "map").svg.count('stroke-width="0.9"') == 0, "no arrow where all actions are alike"


def test_a_sweep_is_a_bellman_sweep_of_the_policy():
    state, values = BellmanByHand(), np.zeros(16)
    for sweep in range(1, 6):
        values = bellman_sweep(Maze(**DRY).mdp, values, 0.9, np.full((16, 4), 0.25))
        assert np.array_equal(pressed(state, "sweep").values, values)
        assert f"Sweep {sweep} of this policy" in state.message
    assert (state.policy == 0.25).all()
    assert pressed(BellmanByHand(), "sweep").message == (
        "Sweep 1 of this policy wrote 0.25 into cell 14 (before: 0). The largest change was 0.25, in cell 11."
    )
    assert "wrote 0.3625 into cell 14 (before: 0.25)" in pressed(BellmanByHand(), "sweep", "sweep").message


def test_fully_evaluated_is_exact():
    state = pressed(BellmanByHand(), "end")
    assert state.values == pytest.approx(evaluate_policy(Maze(**DRY).mdp, np.full((16, 4), 0.25), 0.9), abs=1e-12)
    assert state.message == "All equations of this policy hold now. The start is worth 0.0471."
    assert "No value changed: all equations of this policy hold." in pressed(state, "sweep").message


def test_improving_takes_every_best_action_and_leaves_the_values():
    state = pressed(BellmanByHand(), "end")
    values = state.values.copy()
    pressed(state, "improve")
    assert np.array_equal(state.values, values)
    q = Maze(**DRY).mdp.R + 0.9 * Maze(**DRY).mdp.T @ values
    for s in acting_states(state.world):
        assert (state.policy[s] > 0).tolist() == (q[s] >= q[s].max() - 1e-9).tolist()
        assert state.policy[s].sum() == pytest.approx(1)
    assert state.message == "12 cells changed what to do. From the start it is 6 steps to the cheese."


def test_improving_on_zeros_sees_only_what_pays_at_once():
    state = pressed(BellmanByHand(), "improve")
    assert np.flatnonzero((state.policy != 0.25).any(axis=1)).tolist() == [11, 14]
    assert "In the start all actions are alike" in state.message
    assert panel(state, "map").svg.count('stroke-width="0.9"') == 2


def test_where_nothing_is_known_and_where_all_is_equally_good():
    known = "In the start all actions are equally good."
    for blind in (turned(BellmanByHand(), "gamma", "0"), BellmanByHand(Maze(slip=1.0, **DRY))):
        assert pressed(blind, "solve").message.endswith(known)
    state = turned(BellmanByHand(), "gamma", "0")
    assert known in pressed(state, "end", "improve", "end", "begin", "end", "improve", "end", "solve").message
    assert "no way is known yet" in pressed(BellmanByHand(), "improve").message


def test_three_improvements_and_nothing_is_left_to_improve():
    """Exercise 2 of the lesson."""
    state = pressed(BellmanByHand(), "end", "improve", "end")
    assert "The start is worth 0.5905." in state.message
    assert "3 cells changed what to do." in pressed(state, "improve").message
    assert "the policy is optimal" in pressed(state, "end", "improve").message
    assert_solved(state)


def test_improving_before_every_sweep_is_value_iteration():
    """Exercise 3 of the lesson."""
    state, values = BellmanByHand(), np.zeros(16)
    for sweep in range(1, 8):
        values = bellman_sweep(Maze(**DRY).mdp, values, 0.9)
        pressed(state, "improve", "sweep")
        assert state.values == pytest.approx(values, abs=1e-12)
        assert (state.values[0] > 0) == (sweep >= 6)
    assert state.values[0] == pytest.approx(0.59049)


def test_nothing_to_improve_is_not_yet_optimal():
    state = pressed(BellmanByHand(), "improve", "improve")
    assert state.message == "Nothing to improve: every cell does what is best by these values."


@pytest.mark.parametrize("slip", [0.0, 0.2, 0.6])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("rules", [{}, DRY])
def test_solve_finds_the_best_whatever_was_before(slip, seed, rules):
    state = BellmanByHand(Maze.random(6, 5, seed=seed, slip=slip, **rules))
    for gamma in ("0.5", "0.9", "0.99", "0", "0.95"):
        turned(state, "gamma", gamma)
        assert_solved(pressed(state, "solve"))
    assert "the policy is optimal" in pressed(state, "improve").message


def test_begin_forgets_values_and_policy_but_not_the_maze():
    state = pressed(turned(BellmanByHand(), "slip", "0.2"), "wall", "solve", "begin")
    assert not state.values.any()
    assert (state.policy == 0.25).all()
    assert state.world.slip == 0.2


# --- the equation of a cell


@pytest.mark.parametrize("world", [Maze(**DRY), Maze(slip=0.2), Maze.random(5, 5, seed=1, slip=0.35)])
def test_the_equation_says_what_the_next_sweep_writes(world):
    state = BellmanByHand(world)
    for step in ("sweep", "improve", "sweep", "sweep", "improve", "end", "improve", "sweep", "solve"):
        told = {}
        for s in acting_states(world):
            state.choose(s)
            told[s] = state.equation.result
            assert re.search(rf"<p>V\({s}\) ← [^<]* = <b>{_four(told[s])}</b><br>", panel(state, "equation").html)
        swept = bellman_sweep(world.mdp, state.values, state.gamma, state.policy)
        assert told == {s: swept[s] for s in acting_states(world)}
        pressed(state, step)


@pytest.mark.parametrize("world", [Maze(**DRY), Maze(slip=0.2), Maze(slip=0.6, step_reward=-0.1, **DRY)])
def test_the_numbers_put_in_give_the_result(world):
    state = pressed(BellmanByHand(world), "sweep", "sweep", "improve", "sweep")
    for s in acting_states(world):
        state.choose(s)
        equation = state.equation
        for a in Action:
            assert sum(chance for chance, _, _ in equation.terms(a)) == pytest.approx(1)
            assert "·−" not in equation.numbers(a), "a negative factor stands in brackets"
            formula = equation.numbers(a).replace("·", "*").replace("−", "-")
            assert eval(formula) == pytest.approx(equation.q[a], abs=2e-4)
            names = re.findall(r"V\((\w+)\)", equation.symbols(a))
            lands = world.mdp.next_state[s, a][~world.mdp.terminal[s, a]].tolist()
            assert {name for name in names if name != "end"} == {str(s) for s in lands}
            assert ("end" in names) == world.mdp.terminal[s, a].any()
            assert f"= {equation.numbers(a)}" in panel(state, "equation").html


def test_the_first_equation_is_that_of_the_lesson():
    """Exercise 1 of the lesson."""
    shown = panel(BellmanByHand(), "equation")
    text = " ".join(plain_text(shown.html).split())
    assert "V(14) ← 1/4·(0 + 0 + 0 + 1) = 0.25 Cell 14 is worth 0; the next sweep will write 0.25." in text
    assert re.findall(r'<th scope="col">([^<]*)</th>', shown.html) == ["action a", "π(a | s)", "Q(s, a)"]
    assert re.findall(r'<th scope="row"[^>]*>([^<]*)</th>', shown.html) == ["↑ up", "↓ down", "← left", "→ right"]
    assert "↑ up 1/4 0 R + γ V(14) = 0 + 0.9·0 ↓ down 1/4 0" in text
    assert "→ right 1/4 1 ★ R + γ V(end) = 1 + 0.9·0" in text
    state = pressed(BellmanByHand(), "sweep")
    assert "V(14) ← 1/4·(0.225 + 0.225 + 0 + 1) = <b>0.3625</b>" in panel(state, "equation").html


def test_what_differs_by_rounding_alone_looks_alike():
    state = pressed(BellmanByHand(), "sweep", "sweep")
    assert state.values[11] != state.values[14], "one was added up in another order"
    assert panel(state, "map").svg.count(">0.362</text>") == 2


def test_the_star_is_what_improve_takes():
    state = pressed(BellmanByHand(Maze(slip=0.2)), "end")
    starred = {}
    for s in acting_states(state.world):
        state.choose(s)
        rows = re.findall(
            r"<th [^>]*>. (\w+)</th><td[^>]*>([\d/]+)</td><td[^>]*>(.*?)</td>", panel(state, "equation").html
        )
        assert [Fraction(share) for _, share, _ in rows] == [Fraction(1, 4)] * 4
        starred[s] = [name for name, _, value in rows if "★" in value]
    pressed(state, "improve")
    for s, names in starred.items():
        assert names == [a.name.lower() for a in Action if state.policy[s, a]]
        state.choose(s)
        rows = re.findall(
            r"<th [^>]*>. (\w+)</th><td[^>]*>([\d/]+)</td><td[^>]*>(.*?)</td>", panel(state, "equation").html
        )
        assert [float(Fraction(share)) for _, share, _ in rows] == pytest.approx(state.policy[s].tolist())


def test_an_action_stands_together_with_its_formula():
    state = BellmanByHand(Maze(slip=0.2))
    rows = re.findall(r"<tr>.*?</tr>", panel(state, "equation").html)[1:]
    assert len(rows) == 8
    for action, formula in zip(rows[::2], rows[1::2], strict=True):
        cells = re.findall(r"<t[hd][^>]*>", action)
        assert len(cells) == 3
        assert all("border-bottom:0" in cell for cell in cells), "no line between them"
        assert "border-bottom" not in formula, "and one below"
        assert re.search(r">R \+ γ .*</span> <span style='display:inline-block'>= ", formula)


def test_where_all_actions_are_alike_none_has_a_star():
    state = BellmanByHand()
    state.choose(0)
    assert "All four are alike" in panel(state, "equation").html
    assert "★" not in panel(state, "equation").html


def test_an_equation_that_holds_is_said_to_hold():
    state = pressed(BellmanByHand(), "solve")
    state.choose(5)
    assert state.message == "Cell 5 is worth 0.729: its equation holds."
    assert "<p>V(5) ← Q(5, down) = <b>0.729</b><br>" in panel(state, "equation").html
    state.choose(6)
    assert "Cell 6 is a wall" in panel(state, "equation").html
    state.choose(15)
    assert "its value is 0" in panel(state, "equation").html


# --- what is to be seen


def test_the_map_holds_values_policy_and_the_way():
    state = pressed(BellmanByHand(), "solve")
    shown = panel(state, "map")
    assert "cell 0: 0.59, down or right; cell 1: 0.656, down or right; cell 2: 0.729, right;" in shown.words
    assert "Walls: 6, 10, 12. Start: 0. Cheese: 15." in shown.words
    assert [shown.svg.count(f">{text}</text>") for text in ("0.59", "0.656", "0.729", "0.9")] == [1, 2, 3, 2]
    assert state.way == [0, 4, 8, 9, 13, 14, 15]
    arrows = re.findall(r'<polygon points="[^"]*" fill="(#\w+)" stroke="#22262b" stroke-width="0.9"/>', shown.svg)
    assert (arrows.count("#d55e00"), arrows.count("#ffffff")) == (6, 9)


def test_errors_stay_below_their_bound_and_begin_anew_with_a_policy():
    state = BellmanByHand(Maze(slip=0.2))
    exact = evaluate_policy(Maze(slip=0.2).mdp, np.full((16, 4), 0.25), 0.9)
    errors = [np.abs(exact).max()]
    for _ in range(15):
        errors.append(np.abs(pressed(state, "sweep").values - exact).max())
    assert np.all(np.array(errors) <= errors[0] * 0.9 ** np.arange(16) + 1e-12)
    shown = panel(state, "errors")
    told = "; ".join(f"{k} sweeps: {errors[k]:.2g}" for k in (0, 10, 15))
    assert f"after {told}. At most" in shown.words, "the first, every tenth and the last"
    assert f">{errors[-1]:.2g}</text>" in shown.svg
    assert shown.svg.count("<circle") - 1 == 16 + 1, "a mark for each, one in the legend, one in the pattern of dots"
    line = re.search(r'<polyline points="([^"]*)"[^>]*stroke="#d55e00"', shown.svg).group(1)
    heights = [float(point.split(",")[1]) for point in line.split()]
    assert np.diff(heights) == pytest.approx(170 * np.log(1 / 0.9) / np.log(1e4), abs=0.11), "γ to the power k"
    gap = np.abs(state.values - evaluate_policy(state.world.mdp, pressed(state, "improve").policy, 0.9)).max()
    assert f"after 0 sweeps: {gap:.2g}. " in panel(state, "errors").words
    assert "No error is left." in panel(pressed(state, "end"), "errors").svg


def test_the_words_about_many_sweeps_stay_few():
    state = pressed(BellmanByHand(), "sweep")
    assert re.search(r"after 0 sweeps: [\d.]+; 1 sweep: [\d.]+\. At most", panel(state, "errors").words)
    assert len(panel(pressed(state, *["sweep"] * 299), "errors").words) < 1000


def test_the_way_is_told_apart_by_more_than_its_colour():
    board = panel(BellmanByHand(), "map").board
    assert "Orange, filled arrows: the way from the start" in board


def test_first_view_is_always_the_same():
    explorer = bellman()
    assert isinstance(explorer, Explorer)
    assert explorer.still() == bellman().still()
    assert "discount γ: 0.9 · slip: 0 · reward, cell 14: 0 · solve at once: off" in explorer.still()


def _four(value):
    return f"{round(round(float(value), 12), 4) + 0.0:g}".replace("-", "−")
