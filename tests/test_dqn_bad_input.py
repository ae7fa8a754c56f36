"""Bad input gets one clear `ValueError` from DQN agents, too, and changes nothing."""

import copy
from types import SimpleNamespace

import gymnasium
import numpy as np
import pytest
import torch
from dqn_worlds import everything as everything_of
from test_bad_input import INF, NAN, Pixels, Steering

from course_lib import DQNAgent, Maze


def world():
    """A maze, agents in the middle of training in one, and agents that see vectors."""
    maze = Maze(slip=0.2)
    deep = DQNAgent(Maze(slip=0.2), num_agents=2, replay=10, batch_size=2, target_update=3)
    deep.train(num_steps=5)
    return SimpleNamespace(maze=maze, deep=deep, seeing=DQNAgent(Pixels(), num_agents=2))


def everything(w):
    """What a failed call must leave as it is."""
    return everything_of(w.deep), everything_of(w.seeing), w.deep.env._state


def deep_in(w, env):
    """The agents, in another world."""
    agents = copy.copy(w.deep)
    agents.env = env
    return agents


class ManyPixels(gymnasium.Env):
    observation_space = gymnasium.spaces.Box(0, 1, (16,))
    action_space = gymnasium.spaces.Discrete(4)


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
    ({"learning_starts": 0}, "learning_starts must be at least 1, got 0"),
    ({"learning_starts": -1}, "learning_starts must be at least 1, got -1"),
    ({"learning_starts": False}, "learning_starts must be at least 1, got False"),
    ({"learning_starts": 2.5}, "learning_starts must be a whole number, got 2.5"),
    ({"learning_starts": NAN}, "learning_starts must be a whole number, got nan"),
    ({"learning_starts": INF}, "learning_starts must be a whole number, got inf"),
    ({"learning_starts": "soon"}, "learning_starts must be a whole number, got 'soon'"),
    ({"learning_starts": [8]}, "learning_starts must be a whole number, got [8]"),
    ({"learning_starts": 3, "batch_size": 4, "replay": 10}, "learning_starts must be at least 4, got 3"),
    ({"learning_starts": 8e3, "replay": 10}, "learning_starts must be a whole number, got 8000.0"),
    ({"learning_starts": 2}, "learning_starts of 2 needs a replay buffer to collect in, got replay=None"),
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
BAD = [
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
    (lambda w: setattr(w.deep, "weights", np.full((2, 424), 1e300)), "or NaN or infinity among them"),
    (lambda w: setattr(w.deep, "weights", "heavy"), "weights must be numbers, got 'heavy'"),
    (lambda w: setattr(w.deep, "weights", None), "weights must be [2, 424] finite numbers, got []"),
    (lambda w: w.deep.save("no/such/folder/agent"), "there is no folder no/such/folder"),
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
