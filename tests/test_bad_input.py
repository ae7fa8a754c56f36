"""Bad input gets one clear `ValueError` that says what came and what was wanted, and changes nothing."""

import copy
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest

from course_lib import (
    MDP,
    History,
    Maze,
    QAgent,
    Rollout,
    action_values,
    bellman_sweep,
    evaluate_policy,
    policy_iteration,
    value_iteration,
)

NAN, INF = float("nan"), float("inf")


def world():
    """One of everything that a call can be made on: a mouse in the middle of a walk, an agent that has learned, …"""
    maze = Maze(slip=0.2)
    maze.reset(seed=0)
    maze.step(3)
    agent = QAgent(Maze(slip=0.2), epsilon_decay=0.9)
    agent.train(5)
    return SimpleNamespace(
        maze=maze,
        fresh=Maze(),
        mdp=Maze(slip=0.2).mdp,
        values=np.zeros(16),
        agent=agent,
        history=History(np.zeros(3), np.ones(3, np.int64), np.ones(3, bool), np.zeros(3, bool)),
        rollout=Rollout(np.array([0, 1]), np.array([3]), np.array([1.0]), True, False),
    )


def everything(w):
    """What a failed call must leave as it is."""
    return (
        (w.maze._state, w.maze.np_random.bit_generator.state, w.fresh._state),
        w.values.tobytes(),
        (w.agent.q_table.tobytes(), w.agent.visits.tobytes(), w.agent.epsilon, w.agent.rng.bit_generator.state),
        (w.agent.env._state, w.agent.env.np_random.bit_generator.state),
        (w.agent.history.episode_return.tobytes(), w.history.episode_return.tobytes()),
    )


def mdp_with(**changes):
    """A small MDP of lists with some of its arrays replaced."""
    arrays = {
        "next_state": [[[0, 1]], [[1, 0]]],
        "probability": [[[0.5, 0.5]], [[1, 0]]],
        "reward": [[[0, 1]], [[0, 0]]],
    }
    return MDP(**(arrays | {"terminal": [[[False, True]], [[True, True]]]} | changes))


def policy_with(row):
    """A mixed policy, the same in every state but the last."""
    policy = np.full((16, 4), 0.25)
    policy[-1] = row
    return policy


STAY = [(1.0, 0, 0.0, True)]  # what one action of a toy-text table does


def table_env(table):
    return SimpleNamespace(P=table)


def agent_with(w, **changes):
    """A copy of the agent with something else put in its place."""
    agent = copy.copy(w.agent)
    for name, value in changes.items():
        setattr(agent, name, value)
    return agent


class Pixels(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0, 1, (2,))
    action_space = gymnasium.spaces.Discrete(2)


class Steering(gymnasium.Env):
    observation_space = gymnasium.spaces.Discrete(2)
    action_space = gymnasium.spaces.Box(0, 1, (1,))


BAD = [
    # a grid
    (lambda _: Maze([[3, 0], [0, 0, 4]]), "as long as the others, got rows of [2, 3] tiles"),
    (lambda _: Maze([]), "grid is empty"),
    (lambda _: Maze([[]]), "grid is empty"),
    (lambda _: Maze(np.zeros((0, 4), int)), "grid is empty"),
    (lambda _: Maze(7), "grid must be rows of tiles, such as LESSON_GRID, got 7"),
    (lambda _: Maze([3, 0, 4]), "grid must be rows of tiles"),
    (lambda _: Maze("S..G"), "tiles must be whole numbers"),
    (lambda _: Maze([[3, 0.5, 4]]), "tiles must be whole numbers, got float64"),
    (lambda _: Maze([[3, NAN, 4]]), "tiles must be whole numbers"),
    (lambda _: Maze([[3, None, 4]]), "tiles must be whole numbers"),
    (lambda _: Maze([["3", "0", "4"]]), "tiles must be whole numbers"),
    (lambda _: Maze(np.zeros((2, 2, 2), int)), "tiles must be whole numbers, got int64 of shape (2, 2, 2)"),
    (lambda _: Maze([[3, 5, 4]]), "unknown tile 5"),
    (lambda _: Maze([[3, -1, 4]]), "unknown tile -1"),
    (lambda _: Maze([[3, 2**40, 4]]), "unknown tile 1099511627776"),
    (lambda _: Maze([[3, 260, 4]]), "unknown tile 260"),
    (lambda _: Maze([[3, 2, 4]]), "tile 2 (occupied) is for pictures"),
    (lambda _: Maze([[0, 0, 4]]), "exactly one start (tile 3), got 0"),
    (lambda _: Maze([[3, 3, 4]]), "exactly one start (tile 3), got 2"),
    (lambda _: Maze([[3, 0, 0]]), "at least one goal (tile 4), got none"),
    (lambda _: Maze([[3, 1, 4]]), "no path leads from the start to the goal in row 0, column 2"),
    (lambda _: Maze([[3, 4, 4]]), "no path leads from the start to the goal in row 0, column 2"),
    (lambda _: Maze([[4, 1], [3, 1], [1, 4]]), "no path leads from the start to the goal in row 2, column 1"),
    # the rules of a maze
    (lambda _: Maze(slip=-0.1), "slip must be in [0, 1], got -0.1"),
    (lambda _: Maze(slip=1.1), "slip must be in [0, 1], got 1.1"),
    (lambda _: Maze(slip=NAN), "slip must be a finite number, got nan"),
    (lambda _: Maze(slip="often"), "slip must be a number, got 'often'"),
    (lambda _: Maze(slip=None), "slip must be a number, got None"),
    (lambda _: Maze(step_reward=NAN), "step_reward must be a finite number, got nan"),
    (lambda _: Maze(wall_reward=-INF), "wall_reward must be a finite number, got -inf"),
    (lambda _: Maze(goal_reward=[1, 2]), "goal_reward must be a number, got [1, 2]"),
    (lambda _: Maze(goal_reward=10**400), "goal_reward must be a number"),
    (lambda _: Maze(cell_rewards=np.zeros((4, 5))), "cell_rewards must have the grid's shape (4, 4), got (4, 5)"),
    (lambda _: Maze(cell_rewards=1.0), "cell_rewards must have the grid's shape (4, 4), got ()"),
    (lambda _: Maze(cell_rewards=np.full((4, 4), NAN)), "cell_rewards must be finite"),
    (lambda _: Maze(cell_rewards="much"), "cell_rewards must be numbers of shape (4, 4), got 'much'"),
    (lambda _: Maze(render_mode="human"), "render_mode must be None, 'ansi' or 'rgb_array', got 'human'"),
    # a random maze
    (lambda _: Maze.random(0, 5), "rows must be at least 1, got 0"),
    (lambda _: Maze.random(5, -1), "columns must be at least 1, got -1"),
    (lambda _: Maze.random(2.5, 5), "rows must be a whole number, got 2.5"),
    (lambda _: Maze.random(1, 1), "a maze needs at least 2 cells, got 1 x 1"),
    (lambda _: Maze.random(4, 4, walls=1.5), "walls must be in [0, 1], got 1.5"),
    (lambda _: Maze.random(4, 4, walls=NAN), "walls must be a finite number, got nan"),
    (lambda _: Maze.random(4, 4, seed=-1), "seed must be at least 0, got -1"),
    (lambda _: Maze.random(4, 4, seed=None), "seed must be a whole number, got None"),
    (lambda _: Maze.random(4, 4, slip=2), "slip must be in [0, 1], got 2"),
    # actions, states and cells
    (lambda w: w.maze.step(4), "action must be from 0 to 3, got 4"),
    (lambda w: w.maze.step(-1), "action must be from 0 to 3, got -1"),
    (lambda w: w.maze.step(1.0), "action must be a whole number, got 1.0"),
    (lambda w: w.maze.step("up"), "action must be a whole number, got 'up'"),
    (lambda w: w.maze.step(None), "action must be a whole number, got None"),
    (lambda w: w.fresh.step(0), "call reset() before step()"),
    (lambda w: w.maze.state(4, 0), "row must be from 0 to 3, got 4"),
    (lambda w: w.maze.state(0, -1), "column must be from 0 to 3, got -1"),
    (lambda w: w.maze.state(0.5, 0), "row must be a whole number, got 0.5"),
    (lambda w: w.maze.cell(16), "state must be from 0 to 15, got 16"),
    (lambda w: w.maze.cell(-1), "state must be from 0 to 15, got -1"),
    # an MDP
    (lambda _: mdp_with(next_state=[[0, 1], [1, 0]]), "must have shape (states, actions, outcomes), got (2, 2)"),
    (lambda _: mdp_with(next_state=np.zeros((0, 1, 2), int)), "next_state must have shape (states, actions, outcomes)"),
    (lambda _: mdp_with(next_state=[[[0.0, 1.0]], [[1.0, 0.0]]]), "must hold whole numbers, got dtype float64"),
    (lambda _: mdp_with(next_state=[[[0, 2]], [[1, 0]]]), "next_state must be from 0 to 1, got 0 to 2"),
    (lambda _: mdp_with(next_state=[[[0, -1]], [[1, 0]]]), "next_state must be from 0 to 1, got -1 to 1"),
    (lambda _: mdp_with(probability=[[[0.5, 0.4]], [[1, 0]]]), "must sum to 1, got 0.9 in state 0, action 0"),
    (lambda _: mdp_with(probability=[[[0.5, 0.5]], [[1, 1]]]), "must sum to 1, got 2 in state 1, action 0"),
    (lambda _: mdp_with(probability=[[[1.5, -0.5]], [[1, 0]]]), "must not be negative or NaN, got -0.5 in state 0"),
    (lambda _: mdp_with(probability=[[[0.5, 0.5]], [[1, NAN]]]), "must not be negative or NaN, got nan in state 1"),
    (lambda _: mdp_with(probability=[[[0.5, 0.5]], [[INF, 0]]]), "probabilities must sum to 1, got inf in state 1"),
    (lambda _: mdp_with(probability=[[0.5, 0.5], [1, 0]]), "probability must have next_state's shape (2, 1, 2)"),
    (lambda _: mdp_with(reward=[[[0, NAN]], [[0, 0]]]), "reward must be finite, got nan in state 0, action 0"),
    (lambda _: mdp_with(reward=[[[0, 1]], [[-INF, 0]]]), "reward must be finite, got -inf in state 1, action 0"),
    (lambda _: mdp_with(reward=1.0), "reward must have next_state's shape (2, 1, 2), got ()"),
    (lambda _: mdp_with(terminal=[[[False]], [[True]]]), "terminal must have next_state's shape (2, 1, 2)"),
    (lambda _: MDP.from_gymnasium(gymnasium.make("CartPole-v1")), "has no table of transitions"),
    (lambda _: MDP.from_gymnasium(None), "None has no table of transitions"),
    (lambda _: MDP.from_gymnasium(table_env({})), "is not of the form P[s][a]"),
    (lambda _: MDP.from_gymnasium(table_env([[[(1.0, 0, 0.0)]]])), "is not of the form P[s][a]"),
    (lambda _: MDP.from_gymnasium(table_env([[[(1.0, 2**40, 0.0, True)]]])), "is not of the form P[s][a]"),
    (lambda _: MDP.from_gymnasium(table_env([[[(1.0, 1, 0.0, True)]]])), "next_state must be from 0 to 0"),
    (lambda _: MDP.from_gymnasium(table_env([[[(0.5, 0, 0.0, True)]]])), "must sum to 1, got 0.5 in state 0"),
    (lambda _: MDP.from_gymnasium(table_env([[STAY, STAY], [STAY]])), "is not of the form P[s][a]"),
    (lambda _: MDP.from_gymnasium(table_env([[STAY, []]])), "must sum to 1, got 0 in state 0, action 1"),
    (lambda _: MDP.from_gymnasium(table_env([[[]]])), "next_state must have shape (states, actions, outcomes)"),
    (lambda _: Maze.random(100, 100).mdp.T, "T would need 3 GiB for 10000 states"),
    # planning
    (lambda w: value_iteration(w.maze, 0.9), "an MDP is needed, got a Maze"),
    (lambda w: policy_iteration(w.maze, 0.9), "take maze.mdp, or MDP.from_gymnasium(env)"),
    (lambda w: value_iteration(w.mdp, 1.01), "gamma must be in [0, 1], got 1.01"),
    (lambda w: value_iteration(w.mdp, -0.1), "gamma must be in [0, 1], got -0.1"),
    (lambda w: value_iteration(w.mdp, NAN), "gamma must be a finite number, got nan"),
    (lambda w: value_iteration(w.mdp, None), "gamma must be a number, got None"),
    (lambda w: value_iteration(w.mdp, 0.9, tolerance=0), "tolerance must be positive, got 0"),
    (lambda w: value_iteration(w.mdp, 0.9, tolerance=-1e-8), "tolerance must be positive, got -1e-08"),
    (lambda w: value_iteration(w.mdp, 0.9, tolerance=NAN), "tolerance must be a finite number, got nan"),
    (lambda w: policy_iteration(w.mdp, 2), "gamma must be in [0, 1], got 2"),
    (lambda w: policy_iteration(w.mdp, NAN), "gamma must be a finite number, got nan"),
    (lambda w: policy_iteration(w.mdp, 1), "at gamma = 1 this policy's values are not defined"),
    (lambda w: action_values(w.mdp, w.values, 1.5), "gamma must be in [0, 1], got 1.5"),
    (lambda w: action_values(w.mdp, np.zeros(15), 0.9), "values must have shape (16,), one a state, got (15,)"),
    (lambda w: action_values(w.mdp, np.zeros((16, 4)), 0.9), "values must have shape (16,), one a state, got (16, 4)"),
    (lambda w: action_values(w.mdp, np.full(16, NAN), 0.9), "values must be finite"),
    (lambda w: bellman_sweep(w.mdp, w.values, NAN), "gamma must be a finite number, got nan"),
    (lambda w: bellman_sweep(w.mdp, 0.0, 0.9), "values must have shape (16,), one a state, got ()"),
    (lambda w: bellman_sweep(w.mdp, np.full(16, INF), 0.9), "values must be finite"),
    (lambda w: bellman_sweep(w.mdp, w.values, 0.9, np.zeros(15, int)), "a policy is int[16] (actions) or float[16, 4]"),
    (lambda w: evaluate_policy(w.mdp, np.zeros(16, int), 7), "gamma must be in [0, 1], got 7"),
    (lambda w: evaluate_policy(w.mdp, np.zeros(16, int), 1), "at gamma = 1 this policy's values are not defined"),
    (lambda w: evaluate_policy(w.mdp, np.full(16, 4), 0.9), "a policy's actions must be from 0 to 3, got 4 to 4"),
    (lambda w: evaluate_policy(w.mdp, np.full(16, -1), 0.9), "a policy's actions must be from 0 to 3, got -1 to -1"),
    (lambda w: evaluate_policy(w.mdp, np.zeros(16), 0.9), "(actions) or float[16, 4] (probabilities), got float64[16]"),
    (lambda w: evaluate_policy(w.mdp, np.zeros((16, 3)), 0.9), "a policy is int[16] (actions) or float[16, 4]"),
    (lambda w: evaluate_policy(w.mdp, None, 0.9), "a policy is int[16] (actions) or float[16, 4]"),
    (lambda w: evaluate_policy(w.mdp, ["up"] * 16, 0.9), "a policy is int[16] (actions) or float[16, 4]"),
    (lambda w: evaluate_policy(w.mdp, policy_with([0.5, 0.5, 0.5, 0]), 0.9), "sum to 1 in every state"),
    (lambda w: evaluate_policy(w.mdp, policy_with([1.5, -0.5, 0, 0]), 0.9), "must not be negative or NaN"),
    (lambda w: evaluate_policy(w.mdp, policy_with([NAN, 1, 0, 0]), 0.9), "must not be negative or NaN"),
    # an agent
    (lambda _: QAgent(Pixels()), "Discrete observation_space, got Box"),
    (lambda _: QAgent(Steering()), "Discrete action_space, got Box"),
    (lambda _: QAgent(None), "Discrete observation_space, got None"),
    (lambda w: QAgent(w.maze, gamma=1.5), "gamma must be in [0, 1], got 1.5"),
    (lambda w: QAgent(w.maze, gamma=NAN), "gamma must be a finite number, got nan"),
    (lambda w: QAgent(w.maze, alpha=0), "alpha must be in (0, 1], got 0"),
    (lambda w: QAgent(w.maze, alpha=1.5), "alpha must be in (0, 1], got 1.5"),
    (lambda w: QAgent(w.maze, alpha=NAN), "alpha must be a finite number, got nan"),
    (lambda w: QAgent(w.maze, epsilon=-0.1), "epsilon must be in [0, 1], got -0.1"),
    (lambda w: QAgent(w.maze, epsilon=2), "epsilon must be in [0, 1], got 2"),
    (lambda w: QAgent(w.maze, epsilon=NAN), "epsilon must be a finite number, got nan"),
    (lambda w: QAgent(w.maze, epsilon_decay=1.1), "epsilon_decay must be in [0, 1], got 1.1"),
    (lambda w: QAgent(w.maze, alpha_power=-0.5), "alpha_power must not be negative, got -0.5"),
    (lambda w: QAgent(w.maze, alpha_power=INF), "alpha_power must be a finite number, got inf"),
    (lambda w: QAgent(w.maze, seed=-1), "seed must be at least 0, got -1"),
    (lambda w: QAgent(w.maze, seed=0.5), "seed must be a whole number, got 0.5"),
    (lambda w: w.agent.train(-1), "num_episodes must be at least 0, got -1"),
    (lambda w: w.agent.train(2.5), "num_episodes must be a whole number, got 2.5"),
    (lambda w: w.agent.train(None), "num_episodes must be a whole number, got None"),
    (lambda w: w.agent.train(5, max_steps=0), "max_steps must be at least 1, got 0"),
    (lambda w: w.agent.train(5, max_steps=1e3), "max_steps must be a whole number, got 1000.0"),
    (lambda w: w.agent.test(max_steps=0), "max_steps must be at least 1, got 0"),
    (lambda w: agent_with(w, q_table=np.zeros((15, 4))).train(5), "must have shape (16, 4) for this env, got (15, 4)"),
    (lambda w: agent_with(w, q_table=np.zeros(16)).test(), "q_table must have shape (16, 4) for this env, got (16,)"),
    (lambda w: agent_with(w, visits=np.zeros((16, 3))).train(5), "visits must have shape (16, 4) for this env"),
    (lambda w: agent_with(w, env=Maze.random(5, 5)).train(5), "must have shape (25, 4) for this env, got (16, 4)"),
    (lambda w: agent_with(w, env=Pixels()).train(5), "Discrete observation_space, got Box"),
    (lambda w: w.agent.act(16), "state must be from 0 to 15, got 16"),
    (lambda w: w.agent.act(-1), "state must be from 0 to 15, got -1"),
    (lambda w: w.agent.act(0.0), "state must be a whole number, got 0.0"),
    (lambda w: w.agent.act((0, 0)), "state must be a whole number, got (0, 0)"),
    (lambda w: w.agent.save("no/such/folder/agent"), "there is no folder no/such/folder"),
    # what happened
    (lambda w: w.history.curve(0), "window must be at least 1, got 0"),
    (lambda w: w.history.curve(2.0), "window must be a whole number, got 2.0"),
    (lambda w: w.history.curve(None), "window must be a whole number, got None"),
    (lambda w: w.rollout.discounted_return(1.5), "gamma must be in [0, 1], got 1.5"),
    (lambda w: w.rollout.discounted_return(NAN), "gamma must be a finite number, got nan"),
]  # fmt: skip


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("call", "words"), BAD, ids=[f"{i:03} {words}" for i, (_, words) in enumerate(BAD)])
def test_bad_input_is_refused_in_one_clear_sentence_and_changes_nothing(call, words):
    w = world()
    before = everything(w)
    with pytest.raises(ValueError, match=r"^[^\n]+$") as error:
        call(w)
    assert words in str(error.value)
    assert everything(w) == before


def test_a_whole_number_may_be_of_any_kind():
    maze = Maze()
    maze.reset(seed=0)
    for action in (3, np.int64(3), np.array(3), np.uint8(3)):
        maze.reset()
        assert maze.step(action)[0] == 1
