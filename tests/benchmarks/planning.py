"""Planning in large mazes: value iteration against a breadth-first search in C, and against QuantEcon.

    python tests/benchmarks/planning.py

Where every move has one outcome, only the goal pays and gamma < 1, planning is finding the way: the value of a cell is
gamma^(distance - 1). The search (breadth_first.c) knows that it is in a grid and finds distances, nothing else; value
iteration is handed a general MDP and returns values, action values, a policy and an error bound.
"""

import ctypes

import numpy as np
from measure import address, compile_c, compiler, medians, seconds, show

from course_lib import Maze, value_iteration

GAMMAS = (0.9, 0.999)
QUANTECON_GAMMAS = (0.9, 0.99)
QUANTECON_METHODS = ("value_iteration", "modified_policy_iteration")
SLIPPERY_GAMMAS = (0.9, 0.99)
SEARCH, QUANTECON_AT_LEAST = "breadth-first search in C", 20


class Search:
    """The breadth-first search of one maze, and room for what it finds."""

    def __init__(self, searcher, maze):
        self.searcher, self.maze = searcher, maze

    def run(self):
        """Fill `distance`, int32[S], with the moves from each cell to the goal (-1: no way); the seconds it took."""
        maze, whole = self.maze, ctypes.c_int64
        self.distance, queue = np.empty(maze.grid.size, np.int32), np.empty(maze.grid.size, np.int32)
        shape_and_goal = whole(maze.rows), whole(maze.columns), whole(maze.goals[0])
        found = address(self.distance), address(queue)
        return seconds(lambda: self.searcher.breadth_first(address(maze.grid), *shape_and_goal, *found))


def check_search(search, gamma):
    """`ValueError` unless value == gamma^(distance - 1), to 1e-12 of it, wherever a path leads to the goal."""
    search.run()
    values = value_iteration(search.maze.mdp, gamma).values
    on_the_way = search.distance > 0
    expected = gamma ** (search.distance[on_the_way] - 1.0)
    off = np.abs(values[on_the_way] / expected - 1).max()
    if not off <= 1e-12:
        raise ValueError(f"value iteration and the search differ by {off:.1e} of the value at gamma = {gamma}")


def race_search(side, repeats):
    maze = Maze.random(side, side, walls=0.2, seed=0)
    search = Search(compile_c("breadth_first.c"), maze)
    runs = {SEARCH: search.run}
    for gamma in GAMMAS:
        check_search(search, gamma)
        runs[f"value_iteration, gamma {gamma}"] = lambda gamma=gamma: seconds(lambda: value_iteration(maze.mdp, gamma))
    taken = medians(runs, repeats)
    rows = [("program", "milliseconds", "times the search", "target")]
    for name in runs:
        target = "" if name == SEARCH else "10 or less, 5 the aim"
        rows.append((name, f"{1e3 * taken[name]:.1f}", f"{taken[name] / taken[SEARCH]:.2f}", target))
    show(f"A maze of {side} x {side} cells, every move certain, medians of {repeats} runs in turn", rows)


def quantecons(mdp, gamma):
    """The world as QuantEcon takes it, in its sparse form: one row a (state, action).

    It knows no ends, so a state more is added, in which all is over: what ends an episode leads there.
    """
    from quantecon.markov import DiscreteDP
    from scipy import sparse

    over, num_actions = mdp.num_states, mdp.num_actions
    pairs = (over + 1) * num_actions
    leads_to = np.append(np.where(mdp.terminal, over, mdp.next_state)[:, :, 0], np.full(num_actions, over))
    reward = np.append(mdp.reward[:, :, 0], np.zeros(num_actions))
    transition = sparse.csr_matrix((np.ones(pairs), leads_to, np.arange(pairs + 1)), shape=(pairs, over + 1))
    states, actions = np.divmod(np.arange(pairs), num_actions)
    return DiscreteDP(reward, transition, gamma, states, actions)


def solve_quantecons(world, method):
    return world.solve(method=method, epsilon=1e-8, max_iter=100_000)


def check_quantecon(mdp, gamma, method):
    """`ValueError` unless QuantEcon and value iteration agree on every value to 1e-8."""
    theirs = solve_quantecons(quantecons(mdp, gamma), method).v[:-1]
    off = np.abs(theirs - value_iteration(mdp, gamma).values).max()
    if not off <= 1e-8:
        raise ValueError(f"value iteration and QuantEcon's {method} differ by {off:.1e} at gamma = {gamma}")


def race_quantecon(side, repeats):
    mdp = Maze.random(side, side, walls=0.2, seed=0).mdp
    rows = [("gamma", "program", "milliseconds", "speed of value_iteration over it", "target")]
    for gamma in QUANTECON_GAMMAS:
        world, ours = quantecons(mdp, gamma), "course_lib value_iteration"
        runs = {ours: lambda gamma=gamma: seconds(lambda: value_iteration(mdp, gamma))}
        for method in QUANTECON_METHODS:
            check_quantecon(mdp, gamma, method)
            runs[f"QuantEcon {method}"] = lambda world=world, method=method: seconds(
                lambda: solve_quantecons(world, method)
            )
        taken = medians(runs, repeats)
        for name in runs:
            target = "" if name == ours else f"{QUANTECON_AT_LEAST} or more"
            rows.append((f"{gamma}", name, f"{1e3 * taken[name]:.1f}", f"{taken[name] / taken[ours]:.1f}", target))
    show(f"A maze of {side} x {side} cells, every move certain, medians of {repeats} runs in turn", rows)


def time_slippery(side):
    mdp = Maze.random(side, side, walls=0.2, seed=0, slip=0.2).mdp
    rows = [("gamma", "seconds", "sweeps", "error bound")]
    for gamma in SLIPPERY_GAMMAS:
        found = []
        taken = seconds(lambda gamma=gamma, found=found: found.append(value_iteration(mdp, gamma)))
        rows.append((f"{gamma}", f"{taken:.1f}", f"{found[0].sweeps}", f"{found[0].error_bound:.1e}"))
    show(f"A maze of {side} x {side} cells, slip 0.2, one run", rows)


def main(side=1000, quantecon_side=300, repeats=9, quantecon_repeats=3):
    value_iteration(Maze(slip=0.2).mdp, 0.9)  # compiles what is not yet compiled
    if compiler():
        race_search(side, repeats)
    else:
        print("\ngcc is not installed: nothing in C to compare with")
    try:
        race_quantecon(quantecon_side, quantecon_repeats)
    except ImportError:
        print("\nquantecon is not installed: pip install quantecon")
    time_slippery(side)


if __name__ == "__main__":
    main()
