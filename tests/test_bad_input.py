"""Bad input gets one clear `ValueError` that says what came and what was wanted, and changes nothing."""

import copy
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import everything as everything_of

from course_lib import (
    MDP,
    DQNAgent,
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
    deep = DQNAgent(Maze(slip=0.2), num_agents=2, replay=10, batch_size=2, target_update=3)
    deep.train(num_steps=5)
    return SimpleNamespace(
        maze=maze,
        fresh=Maze(),
        mdp=Maze(slip=0.2).mdp,
        values=np.zeros(16),
        agent=agent,
        deep=deep,
        seeing=DQNAgent(Pixels(), num_agents=2),
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
        (everything_of(w.deep), everything_of(w.seeing), w.deep.env._state),
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


def deep_in(w, env):
    """The DQN agents, in another world."""
    agents = copy.copy(w.deep)
    agents.env = env
    return agents


class Pixels(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0, 1, (2,))
    action_space = gymnasium.spaces.Discrete(2)


class ManyPixels(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0, 1, (16,))
    action_space = gymnasium.spaces.Discrete(4)


class Steering(gymnasium.Env):
    observation_space = gymnasium.spaces.Discrete(2)
    action_space = gymnasium.spaces.Box(0, 1, (1,))


def three_lanes(env="CartPole-v1"):
    return gymnasium.make_vec(env, num_envs=3, vectorization_mode="sync")


DQN_SETTINGS = [  # what is given to a DQNAgent, and what it says
    ({"hidden": 5}, "hidden must be the sizes of the hidden layers, such as (20,), got 5"),
    ({"hidden": None}, "hidden must be the sizes of the hidden layers, such as (20,), got None"),
    ({"hidden": (0,)}, "a hidden layer's size must be at least 1, got 0"),
    ({"hidden": (20, -1)}, "a hidden layer's size must be at least 1, got -1"),
    ({"hidden": (2.5,)}, "a hidden layer's size must be a whole number, got 2.5"),
    ({"hidden": (NAN,)}, "a hidden layer's size must be a whole number, got nan"),
    ({"hidden": "20"}, "a hidden layer's size must be a whole number, got '2'"),
    ({"gamma": 1.5}, "gamma must be in [0, 1], got 1.5"),
    ({"gamma": -0.1}, "gamma must be in [0, 1], got -0.1"),
    ({"gamma": NAN}, "gamma must be a finite number, got nan"),
    ({"gamma": "much"}, "gamma must be a number, got 'much'"),
    ({"gamma": None}, "gamma must be a number, got None"),
    ({"learning_rate": 0}, "learning_rate must be positive, got 0"),
    ({"learning_rate": -1e-3}, "learning_rate must be positive, got -0.001"),
    ({"learning_rate": NAN}, "learning_rate must be a finite number, got nan"),
    ({"learning_rate": INF}, "learning_rate must be a finite number, got inf"),
    ({"learning_rate": "slow"}, "learning_rate must be a number, got 'slow'"),
    ({"learning_rate": [1, 2]}, "learning_rate must be a number, got [1, 2]"),
    ({"epsilon": -0.1}, "epsilon must be in [0, 1], got -0.1"),
    ({"epsilon": 2}, "epsilon must be in [0, 1], got 2"),
    ({"epsilon": NAN}, "epsilon must be a finite number, got nan"),
    ({"epsilon": None}, "epsilon must be a number, got None"),
    ({"epsilon_decay": 1.1}, "epsilon_decay must be in [0, 1], got 1.1"),
    ({"epsilon_decay": -1}, "epsilon_decay must be in [0, 1], got -1"),
    ({"epsilon_decay": NAN}, "epsilon_decay must be a finite number, got nan"),
    ({"epsilon_decay": "fast"}, "epsilon_decay must be a number, got 'fast'"),
    ({"replay": 0}, "replay must be at least 1, got 0"),
    ({"replay": -5}, "replay must be at least 1, got -5"),
    ({"replay": False}, "replay must be at least 1, got False"),
    ({"replay": 1e4}, "replay must be a whole number, got 10000.0"),
    ({"replay": NAN}, "replay must be a whole number, got nan"),
    ({"replay": "all"}, "replay must be a whole number, got 'all'"),
    ({"replay": 10**15}, "there is no memory for 1,000,000,000,000,000 transitions of 1 agents"),
    ({"replay": 2**62, "num_agents": 3}, "there is no memory for 4,611,686,018,427,387,904 transitions of 3 agents"),
    ({"replay": 2**64}, "there is no memory for 18,446,744,073,709,551,616 transitions of 1 agents"),
    ({"replay": 10**15, "batch_size": 10**15}, "there is no memory for 1,000,000,000,000,000 transitions"),
    ({"replay": 3, "batch_size": 4}, "replay must be at least 4, got 3"),
    ({"batch_size": 0}, "batch_size must be at least 1, got 0"),
    ({"batch_size": 2.5, "replay": 10}, "batch_size must be a whole number, got 2.5"),
    ({"batch_size": None, "replay": 10}, "batch_size must be a whole number, got None"),
    ({"batch_size": "all", "replay": 10}, "batch_size must be a whole number, got 'all'"),
    ({"batch_size": 2}, "a batch_size of 2 needs a replay buffer to draw from, got replay=None"),
    ({"target_update": 0}, "target_update must be None, a number of steps from 1 or a fraction below 1, got 0"),
    ({"target_update": -1}, "a number of steps from 1 or a fraction below 1, got -1"),
    ({"target_update": 0.0}, "a number of steps from 1 or a fraction below 1, got 0.0"),
    ({"target_update": 1.0}, "a number of steps from 1 or a fraction below 1, got 1.0"),
    ({"target_update": 1.5}, "a number of steps from 1 or a fraction below 1, got 1.5"),
    ({"target_update": -0.5}, "a number of steps from 1 or a fraction below 1, got -0.5"),
    ({"target_update": NAN}, "a number of steps from 1 or a fraction below 1, got nan"),
    ({"target_update": False}, "a number of steps from 1 or a fraction below 1, got False"),
    ({"target_update": "often"}, "a number of steps from 1 or a fraction below 1, got 'often'"),
    ({"target_update": 2**63}, "a number of steps from 1 or a fraction below 1, got 9223372036854775808"),
    ({"double": True}, "double needs a target network to ask for a second opinion, got target_update=None"),
    ({"num_agents": 0}, "num_agents must be at least 1, got 0"),
    ({"num_agents": -1}, "num_agents must be at least 1, got -1"),
    ({"num_agents": False}, "num_agents must be at least 1, got False"),
    ({"num_agents": 2.0}, "num_agents must be a whole number, got 2.0"),
    ({"num_agents": "two"}, "num_agents must be a whole number, got 'two'"),
    ({"device": "nonsense"}, "device must be one that torch has here, such as 'cpu', got 'nonsense'"),
    ({"device": "cuda:99"}, "device must be one that torch has here, such as 'cpu', got"),
    ({"device": "hpu"}, "device must be one that torch has here, such as 'cpu', got"),
    ({"device": "meta"}, "device must be one that torch has here, such as 'cpu', got"),
    ({"device": None}, "device must be one that torch has here, such as 'cpu', got None"),
    ({"device": 3.5}, "device must be one that torch has here, such as 'cpu', got 3.5"),
    ({"seed": -1}, "seed must be at least 0, got -1"),
    ({"seed": 0.5}, "seed must be a whole number, got 0.5"),
    ({"seed": None}, "seed must be a whole number, got None"),
]
if not torch.cuda.is_available():
    DQN_SETTINGS.append(({"device": "cuda"}, "device must be one that torch has here, such as 'cpu', got"))
BAD_DQN = [
    *((lambda w, given=given: DQNAgent(w.maze, **given), words) for given, words in DQN_SETTINGS),
    (lambda _: DQNAgent(Steering()), "DQNAgent needs an environment with a Discrete action_space, got Box"),
    (lambda _: DQNAgent("Pendulum-v1"), "Discrete action_space, got Box"),
    (lambda _: DQNAgent("Blackjack-v1"), "Discrete or Box observation_space, got Tuple"),
    (lambda _: DQNAgent(three_lanes("Blackjack-v1")), "Discrete or Box observation_space, got Tuple"),
    (lambda _: DQNAgent(three_lanes("Pendulum-v1")), "Discrete action_space, got Box"),
    (lambda _: DQNAgent(three_lanes(), num_agents=2), "a lane an agent, got 3 lanes for 2 agents"),
    (lambda _: DQNAgent(None), "DQNAgent needs an environment with a Discrete or Box observation_space, got None"),
    (lambda _: DQNAgent(7), "Discrete or Box observation_space, got None"),
    (lambda _: DQNAgent("NoSuchWorld-v0"), "there is no environment 'NoSuchWorld-v0'"),
    (lambda _: DQNAgent("CartPole-v99"), "there is no environment 'CartPole-v99'"),
    (lambda _: DQNAgent("no_such_module:World-v0"), "there is no environment 'no_such_module:World-v0'"),
    (lambda _: DQNAgent(""), "there is no environment ''"),
    (lambda w: w.deep.train(), "say how long to train: num_episodes or num_steps"),
    (lambda w: w.deep.train(max_steps=5), "say how long to train: num_episodes or num_steps"),
    (lambda w: w.deep.train(-1), "num_episodes must be at least 0, got -1"),
    (lambda w: w.deep.train(2.5), "num_episodes must be a whole number, got 2.5"),
    (lambda w: w.deep.train("all"), "num_episodes must be a whole number, got 'all'"),
    (lambda w: w.deep.train(num_steps=-1), "num_steps must be at least 0, got -1"),
    (lambda w: w.deep.train(num_steps=1e3), "num_steps must be a whole number, got 1000.0"),
    (lambda w: w.deep.train(5, num_steps=NAN), "num_steps must be a whole number, got nan"),
    (lambda w: w.deep.train(5, max_steps=0), "max_steps must be at least 1, got 0"),
    (lambda w: w.deep.train(5, max_steps=1e3), "max_steps must be a whole number, got 1000.0"),
    (lambda w: w.deep.train(5, max_steps=None), "max_steps must be a whole number, got None"),
    (lambda w: w.deep.test(0), "num_episodes must be at least 1, got 0"),
    (lambda w: w.deep.test(2.5), "num_episodes must be a whole number, got 2.5"),
    (lambda w: w.deep.test(None), "num_episodes must be a whole number, got None"),
    (lambda w: w.deep.test(max_steps=0), "max_steps must be at least 1, got 0"),
    (lambda w: w.deep.test(seed=-1), "seed must be at least 0, got -1"),
    (lambda w: w.deep.test(seed=None), "seed must be a whole number, got None"),
    (lambda w: deep_in(w, Maze.random(5, 5)).train(1), "layers of (16, 20, 4) nodes, this env needs others"),
    (lambda w: deep_in(w, Maze.random(5, 5)).test(), "this env needs others: (25, 20, 4)"),
    (lambda w: deep_in(w, Pixels()).test(), "this env needs others: (2, 20, 2)"),
    (lambda w: deep_in(w, ManyPixels()).train(1), "made for another kind of observations than <ManyPixels"),
    (lambda w: deep_in(w, Steering()).train(1), "DQNAgent needs an environment with a Discrete action_space, got Box"),
    (lambda w: deep_in(w, None).test(), "Discrete or Box observation_space, got None"),
    (lambda w: deep_in(w, three_lanes("FrozenLake-v1")).train(1), "a lane an agent, got 3 lanes for 2 agents"),
    (lambda w: w.deep.q_values(3), "observations must be states, int[B] or int[2, B], got int64[]"),
    (lambda w: w.deep.q_values([3.0]), "observations must be states, int[B] or int[2, B], got float64[1]"),
    (lambda w: w.deep.q_values([True]), "observations must be states, int[B] or int[2, B], got bool[1]"),
    (lambda w: w.deep.q_values([]), "observations must be states, int[B] or int[2, B], got float64[0]"),
    (lambda w: w.deep.q_values([[1], [2], [3]]), "int[B] or int[2, B], got int64[3, 1]"),
    (lambda w: w.deep.q_values([[[1]], [[2]]]), "int[B] or int[2, B], got int64[2, 1, 1]"),
    (lambda w: w.deep.q_values("start"), "observations must be states, int[B] or int[2, B], got <U5[]"),
    (lambda w: w.deep.q_values(None), "observations must be states, int[B] or int[2, B], got object[]"),
    (lambda w: w.deep.q_values([3, 16]), "states must be from 0 to 15, got 3 to 16"),
    (lambda w: w.deep.q_values([-1]), "states must be from 0 to 15, got -1 to -1"),
    (lambda w: w.seeing.q_values([0.5, 0.5]), "must have shape [B, 2] or [2, B, 2], got [2]"),
    (lambda w: w.seeing.q_values([[0.5]]), "must have shape [B, 2] or [2, B, 2], got [1, 1]"),
    (lambda w: w.seeing.q_values(np.zeros((3, 5, 2))), "must have shape [B, 2] or [2, B, 2], got [3, 5, 2]"),
    (lambda w: w.seeing.q_values(np.zeros((2, 2, 5, 2))), "must have shape [B, 2] or [2, B, 2], got [2, 2, 5, 2]"),
    (lambda w: w.seeing.q_values(0.5), "must have shape [B, 2] or [2, B, 2], got []"),
    (lambda w: w.seeing.q_values([[0.5, 0.5], [0.5]]), "observations must be numbers, got [[0.5, 0.5], [0.5]]"),
    (lambda w: w.seeing.q_values([["left", "right"]]), "observations must be numbers, got [['left', 'right']]"),
    (lambda w: w.seeing.q_values({}), "observations must be numbers, got {}"),
    (lambda w: setattr(w.deep, "weights", np.zeros((3, 424))), "must be [2, 424] finite numbers, got [3, 424]"),
    (lambda w: setattr(w.deep, "weights", 0.0), "weights must be [2, 424] finite numbers, got []"),
    (lambda w: setattr(w.deep, "weights", np.full((2, 424), NAN)), "or NaN or infinity among them"),
    (lambda w: setattr(w.deep, "weights", np.full((2, 424), INF)), "or NaN or infinity among them"),
    (lambda w: setattr(w.deep, "weights", "heavy"), "weights must be numbers, got 'heavy'"),
    (lambda w: setattr(w.deep, "weights", None), "weights must be [2, 424] finite numbers, got []"),
    (lambda w: w.deep.save("no/such/folder/agent"), "there is no folder no/such/folder"),
]  # fmt: skip

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


BAD += BAD_DQN


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
