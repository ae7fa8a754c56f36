"""Touch the transition function: the row that is shown is the world's, and the drawn moves are drawn from it."""

import re

import numpy as np
import pytest

from course_lib import Action, Maze
from course_lib.explore import Explorer, Transitions, transitions

ICE = {"slip": 0.2, "wall_reward": 0.0, "wall_ends_episode": False}


def panel(state, name):
    return next(panel for panel in state.view().panels if panel.name == name)


def turned(state, name, text):
    state.turn(name, state.view().control(name).texts.index(text))
    return state


def number_in(svg, words):
    """How often a text stands in a picture."""
    return svg.count(f">{words}</text>")


@pytest.mark.parametrize("slip", [0.0, 0.05, 0.2, 0.5, 1.0])
@pytest.mark.parametrize("rules", [{}, {"wall_reward": 0.0, "wall_ends_episode": False}])
def test_every_row_is_that_of_the_world(slip, rules):
    mdp = Maze(slip=slip, **rules).mdp
    state = turned(Transitions(Maze(**rules)), "slip", f"{slip:g}")
    for cell in (0, 1, 2, 3, 4, 5, 7, 8, 9, 11, 13, 14):
        state.choose(cell)
        for action in Action:
            state.turn("action", int(action))
            assert state.chances == pytest.approx(mdp.T[cell, action], abs=1e-15)
            assert state.reward == pytest.approx(mdp.R[cell, action])
            assert state.ends == pytest.approx(mdp.probability[cell, action][mdp.terminal[cell, action]].sum())


def test_words_and_picture_hold_the_row():
    state = Transitions()
    state.choose(5)
    assert state.message == (
        "From cell 5, right: the mouse stays in cell 5 with probability 0.8, gets to cell 1 with probability 0.1, gets"
        " to cell 9 with probability 0.1. The reward to expect is R(s, a) = 0; the move does not end the episode."
    )
    shown = panel(state, "map")
    assert shown.words.startswith("Cell 5 (row 1, column 1) is chosen. From cell 5, right: the mouse stays in cell 5")
    assert (number_in(shown.svg, "0.8"), number_in(shown.svg, "0.1")) == (1, 2)
    finer = panel(turned(state, "slip", "0.25"), "map").svg
    assert (number_in(finer, "0.75"), number_in(finer, "0.125")) == (1, 2)
    assert turned(state, "slip", "0").message.startswith(
        "From cell 5, right: the mouse stays in cell 5 with probability 1. "
    )
    bars = panel(turned(state, "slip", "0.2"), "bars")
    assert bars.words == "After 0 moves. cell 5: probability 0.8; cell 1: probability 0.1; cell 9: probability 0.1."
    assert [number_in(bars.svg, words) for words in ("cell 5 (stays)", "cell 1", "cell 9")] == [1, 1, 1]


def test_two_slips_to_one_place_add_up():
    """Exercise 3 of the lesson."""
    state = Transitions()
    state.choose(14)
    assert "gets to cell 15 with probability 0.8, stays in cell 14 with probability 0.2." in state.message
    assert "R(s, a) = 0.8; the move ends the episode with probability 0.8." in state.message
    assert "R(s, a) = 0;" in turned(state, "slip", "1").message
    assert turned(state, "slip", "0").message.endswith("R(s, a) = 1; the move ends the episode.")


def test_with_slip_one_half_a_mouse_at_a_wall_is_as_likely_to_stay():
    """Exercise 2 of the lesson."""
    state = Transitions()
    state.choose(5)
    assert turned(state, "slip", "0.5").chances[[5, 1, 9]].tolist() == [0.5, 0.25, 0.25]


def test_a_fatal_bump_is_told():
    state = Transitions(Maze(slip=0.2))
    state.choose(5)
    assert "R(s, a) = −0.8; the move ends the episode with probability 0.8." in state.message
    assert "−0.8" in panel(state, "table").html


def test_drawn_moves_add_up_and_come_near():
    state = Transitions()
    for moves, total in (("100 moves", 100), ("100 moves", 200), ("10,000 moves", 10_200), ("1 move", 10_201)):
        state.press(moves)
        assert state.tries == state.counts.sum() == total
        assert set(np.flatnonzero(state.counts)) == {0, 1, 4}
        assert state.gap == pytest.approx(np.abs(state.counts / total - state.chances).max())
        assert f"at most {state.gap:.4f} away from T; 1/√n is {total**-0.5:.4f}." in state.message
    assert state.gap < 2 * state.tries**-0.5
    bars, table = panel(state, "bars"), panel(state, "table")
    for cell in (1, 0, 4):
        share = state.counts[cell] / state.tries
        assert f"cell {cell}: probability {state.chances[cell]:.3g}, share {round(share, 3):g}" in bars.words
        assert number_in(bars.svg, f"{round(share, 3):g}") >= 1
        assert f"<td>{state.counts[cell]:,}</td><td>{share:.3f}</td>" in table.html
    assert f"Largest |share − T|: {state.gap:.4f}." in table.html
    assert re.findall(r'<th scope="col">([^<]*)</th>', table.html) == ["s&#x27;", "T", "moves", "share", "share − T"]
    assert re.findall(r'<th scope="row"[^>]*>([^<]*)</th>', table.html) == ["1", "0 (stays)", "4"]
    assert "10,201 moves" in bars.svg


def test_bars_are_as_high_as_their_numbers():
    state = Transitions()
    state.press("100 moves")
    heights = [
        float(h)
        for h in re.findall(
            r'<rect [^>]*?height="([\d.]+)" fill="(?:#0072b2|url\(#dotted\))"', panel(state, "bars").svg
        )
    ]
    told = [number for s in state.landings for number in (state.chances[s], state.counts[s] / 100)]
    assert np.array(heights[:6]) / heights[0] == pytest.approx(np.array(told) / told[0], abs=1e-3)


def test_a_single_move_is_shown_where_it_landed():
    state, seen = Transitions(), set()
    assert panel(state, "map").svg.count("<circle") == panel(Transitions(seed=3), "map").svg.count("<circle")
    dots = panel(state, "map").svg.count("<circle")
    for i in range(60):
        before = state.counts.copy()
        state.press("1 move")
        assert np.flatnonzero(state.counts - before).tolist() == [state.landed]
        assert f"Move {i + 1} landed in cell {state.landed}." in state.message
        assert f"The last move landed in cell {state.landed}." in panel(state, "map").words
        assert panel(state, "map").svg.count("<circle") == dots + 1
        seen.add(state.landed)
    assert seen == {0, 1, 4}
    state.press("100 moves")
    assert state.landed is None
    assert panel(state, "map").svg.count("<circle") == dots


@pytest.mark.parametrize(
    "change",
    [
        lambda state: state.choose(1),
        lambda state: state.arrow(Action.DOWN),
        lambda state: state.turn("action", 0),
        lambda state: state.turn("slip", 3),
        lambda state: state.press("forget"),
    ],
)
def test_another_row_forgets_what_was_drawn(change):
    state = Transitions()
    state.press("1 move")
    assert not state.view().control("forget").idle
    change(state)
    assert (state.tries, state.gap, state.landed) == (0, None, None)
    assert state.view().control("forget").idle


def test_the_chosen_cell_chosen_again_keeps_the_moves():
    state = Transitions()
    state.press("100 moves")
    before = state.view()
    state.choose(0)
    assert state.view() == before


def test_in_small_cells_the_chances_can_be_read():
    state = Transitions(Maze.random(8, 8, seed=0, slip=0.2, wall_ends_episode=False))
    sizes = [float(size) for size in re.findall(r'font-size="([^"]+)"', panel(state, "map").svg)]
    assert min(sizes) >= 11


def test_the_same_seed_draws_the_same_and_another_does_not():
    one, same, other = Transitions(seed=1), Transitions(seed=1), Transitions(seed=2)
    for state in (one, same, other):
        state.press("10,000 moves")
    assert one.view() == same.view()
    assert one.counts.tolist() != other.counts.tolist()
    one.press("forget")
    one.press("10,000 moves")
    assert one.counts.tolist() != same.counts.tolist(), "after forgetting, chance goes on"


def test_arrow_keys_skip_walls_and_cheese():
    state = Transitions()
    for action, cell in (
        (Action.DOWN, 4), (Action.RIGHT, 5), (Action.RIGHT, 7), (Action.DOWN, 11), (Action.DOWN, 11),
        (Action.LEFT, 9), (Action.LEFT, 8), (Action.DOWN, 8), (Action.UP, 4), (Action.LEFT, 4),
    ):  # fmt: skip
        state.arrow(action)
        assert state.cell == cell
    assert state.message == "There is no cell to choose left from cell 4."


def test_in_walls_and_cheese_nothing_can_be_done():
    state = Transitions()
    state.press("100 moves")
    state.choose(6)
    assert "Cell 6 is a wall" in state.message
    state.choose(15)
    assert "Cell 15 holds a cheese" in state.message
    assert (state.cell, state.tries) == (0, 100)


@pytest.mark.parametrize(
    ("method", "bad"),
    [
        ("turn", ("gamma", 0)), ("turn", ("slip", 21)), ("turn", ("slip", -1)), ("turn", ("action", 4)),
        ("turn", ("action", 1.0)), ("press", ("2 moves",)), ("press", ("right",)), ("choose", (16,)), ("choose", (-1,)),
        ("choose", ("5",)),
    ],
)  # fmt: skip
def test_bad_input_changes_nothing(method, bad):
    state = Transitions()
    state.press("1 move")
    before = state.view()
    with pytest.raises(ValueError, match=r"control|slip|action|buttons|cell"):
        getattr(state, method)(*bad)
    assert state.view() == before


@pytest.mark.parametrize("bad", ["maze", 3, Maze().mdp, Maze.random(9, 3)])
def test_only_small_mazes_are_shown(bad):
    with pytest.raises(ValueError, match=r"a Maze is needed|at most 8 rows"):
        Transitions(bad)


def test_any_small_maze_and_slip_will_do():
    state = Transitions(Maze.random(8, 5, seed=3, slip=0.33))
    assert state.dials.slip == 0.33
    assert state.view().control("slip").texts[:8] == ("0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.33")
    assert state.chances.sum() == pytest.approx(1)
    assert Maze(**ICE).mdp.T[0, 3].tolist() == Transitions().chances.tolist()


def test_first_view_is_always_the_same():
    explorer = transitions()
    assert isinstance(explorer, Explorer)
    assert explorer.still() == transitions().still()
    assert Transitions().view() == Transitions().view()
    assert "slip: 0.2 · action a: → right" in explorer.still()
