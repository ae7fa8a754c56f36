"""Stopped, saved and loaded, training goes on as if nothing had happened, to the last bit."""

import os
import signal
import threading
import time

import gymnasium
import pytest
from dqn_worlds import SWITCHES, WORLDS, Chance, everything, learned, watched

from course_lib import DQNAgent, Maze

MEMORY = SWITCHES["everything"]
pytestmark = pytest.mark.usefixtures("usual_handler")
every_world = pytest.mark.parametrize("world", WORLDS.values(), ids=WORLDS.keys())
both = pytest.mark.parametrize("switches", [{}, MEMORY], ids=["latest transition", "memory"])


@pytest.fixture
def usual_handler():
    """Ctrl-C raises `KeyboardInterrupt`, also where the tests are started in the background, which ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


# --- saved and loaded -------------------------------------------------------------------------------------------------


@every_world
@pytest.mark.parametrize("switches", SWITCHES.values(), ids=SWITCHES.keys())
def test_training_goes_on_from_a_file_as_if_it_had_never_stopped(world, switches, tmp_path):
    """In the middle of episodes, with the memory half full and with it turned over."""
    unbroken, resumed = (DQNAgent(world(), num_agents=2, seed=3, **switches) for _ in range(2))
    for steps in (0, 31, 1, 60):
        for agent in (unbroken, resumed):
            agent.train(num_steps=steps)
        resumed.save(tmp_path / "agent")
        resumed = DQNAgent.load(tmp_path / "agent", world())
        assert resumed.history.episode_return.shape == (2, 0)
        assert learned(resumed) == learned(unbroken)
        for agent in (unbroken, resumed):
            agent.train(2, max_steps=20)
        assert everything(resumed) == everything(unbroken)
    names = ("hidden", "gamma", "learning_rate", "epsilon_decay", "replay", "batch_size", "target_update", "double")
    names += ("mask_terminal", "num_agents", "seed", "device")
    assert [getattr(resumed, name) for name in names] == [getattr(unbroken, name) for name in names]


def test_loading_leaves_the_file_as_it_is_and_saving_leaves_the_agent(tmp_path):
    agent, path = DQNAgent(Maze(slip=0.3), num_agents=2, **MEMORY), tmp_path / "agent"
    agent.train(num_steps=50)
    before = everything(agent)
    agent.save(path)
    assert everything(agent) == before
    content = path.read_bytes()
    loaded = DQNAgent.load(path, Maze(slip=0.3))
    loaded.train(10)
    assert path.read_bytes() == content
    assert everything(agent) == before
    assert loaded.q_values([0]).tobytes() != agent.q_values([0]).tobytes()


def test_a_saved_agent_walks_and_answers_as_before(tmp_path):
    agent = DQNAgent("CartPole-v1", num_agents=2)
    agent.train(num_steps=50)
    agent.save(str(tmp_path / "agent"))
    loaded = DQNAgent.load(str(tmp_path / "agent"), "CartPole-v1")
    for ours, theirs in zip(loaded.test(2), agent.test(2), strict=True):
        assert ours.states.tobytes() == theirs.states.tobytes()
        assert loaded.q_values(ours.states).tobytes() == agent.q_values(ours.states).tobytes()


def test_a_vector_environments_agents_go_on_with_what_they_know_in_new_episodes(tmp_path):
    def carts():
        return gymnasium.make_vec("CartPole-v1", num_envs=3, vectorization_mode="sync")

    agent = DQNAgent(carts(), **MEMORY)
    agent.train(num_steps=40)
    agent.save(tmp_path / "agent")
    loaded = DQNAgent.load(tmp_path / "agent", carts())
    assert learned(loaded) == learned(agent)
    for some in (agent, loaded):
        some.train(num_steps=30)
    assert everything(loaded) == everything(agent)


# --- interrupted ------------------------------------------------------------------------------------------------------


class Stopped(gymnasium.Wrapper):
    """Does `stop` in the step or the reset of that number, counted over all copies; nothing at any other time."""

    def __init__(self, env, stop, number, where="step"):
        super().__init__(env)
        self.stop, self.number, self.where = stop, number, where
        Stopped.count = 0

    def _count(self, where):
        Stopped.count += where == self.where
        if where == self.where and Stopped.count == self.number:
            self.stop()

    def step(self, action):
        self._count("step")
        return self.env.step(action)

    def reset(self, **arguments):
        self._count("reset")
        return self.env.reset(**arguments)


def raise_interrupt():
    raise KeyboardInterrupt


def press_ctrl_c():
    signal.raise_signal(signal.SIGINT)


def press_ctrl_c_twice():
    press_ctrl_c()
    press_ctrl_c()


def interrupted(world, stop, number, where="step", num_agents=2, **arguments):
    """(agent, steps it has made), stopped in the step of that number; all is put back when it is."""
    switches = {name: arguments.pop(name) for name in list(arguments) if name in MEMORY}
    agent = DQNAgent(Stopped(world(), stop, number, where), num_agents=num_agents, **switches)
    made = watched(agent)
    with pytest.raises(KeyboardInterrupt):
        agent.train(**arguments)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    return agent, len(made)


STOPS = {
    "in the world": (raise_interrupt, 0),
    "by a signal that waits for the step": (press_ctrl_c, 1),
    "by a second signal at once": (press_ctrl_c_twice, 0),
}


@pytest.mark.parametrize("world", ["maze", "slippery maze", "cart pole"])
@both
@pytest.mark.parametrize(("stop", "finished"), STOPS.values(), ids=STOPS.keys())
def test_stopped_anywhere_saved_and_loaded_it_ends_where_an_unbroken_run_ends(
    world, switches, stop, finished, tmp_path
):
    """Two agents; the 78th step of the two is the second one's 39th, which then has been made or has not."""
    world = WORLDS[world]
    agent, made = interrupted(world, stop, 78, num_steps=100, **switches)
    assert made == 38 + finished
    unbroken = DQNAgent(world(), num_agents=2, **switches)
    unbroken.train(num_steps=made)
    assert everything(agent) == everything(unbroken)
    agent.save(tmp_path / "agent")
    resumed = DQNAgent.load(tmp_path / "agent", world())
    for some in (agent, resumed, unbroken):
        some.train(num_steps=100 - made)
    assert learned(agent) == learned(resumed) == learned(unbroken)


@pytest.mark.parametrize("world", ["maze", "slippery maze", "cart pole"])
@pytest.mark.parametrize("number", [3, 24, 41])
def test_stopped_by_episodes_what_is_missing_of_them_can_be_played_later(world, number, tmp_path):
    agent, _ = interrupted(WORLDS[world], press_ctrl_c, number, num_agents=1, num_episodes=16)
    done = len(agent.history)
    assert done < 16
    agent.save(tmp_path / "agent")
    resumed, unbroken = DQNAgent.load(tmp_path / "agent", WORLDS[world]()), DQNAgent(WORLDS[world]())
    rest, whole = resumed.train(16 - done), unbroken.train(16)
    assert learned(resumed) == learned(unbroken)
    for name in ("episode_return", "episode_length", "terminated", "truncated"):
        first, second = (getattr(record, name)[0].tolist() for record in (agent.history, rest))
        assert first + second == getattr(whole, name)[0].tolist()


@pytest.mark.parametrize("where", ["step", "reset"])
def test_stopped_while_it_is_brought_back_to_where_it_was_it_is_still_there(where):
    agent = DQNAgent(WORLDS["cart pole"](), num_agents=2)
    agent.train(num_steps=8)
    unbroken, before = agent.env, learned(agent)
    assert agent._underway.steps.min() > 1, "both are in an episode that must be played again"
    agent.env = Stopped(WORLDS["cart pole"](), raise_interrupt, 2, where)
    with pytest.raises(KeyboardInterrupt):
        agent.train(num_steps=5)
    assert learned(agent) == before
    agent.env = unbroken
    agent.train(num_steps=5)
    whole = DQNAgent(WORLDS["cart pole"](), num_agents=2)
    whole.train(num_steps=13)
    assert learned(agent) == learned(whole)


@pytest.mark.skipif(os.name != "posix", reason="signals as POSIX has them")
@both
def test_a_signal_from_outside_stops_an_endless_training_after_a_whole_step(switches):
    """It comes from another thread, at whatever moment; the agent is then where some whole number of steps leads."""

    def begin_to_wait():
        threading.Thread(target=send_later, daemon=True).start()

    def send_later():
        time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGINT)

    agent, made = interrupted(Chance, begin_to_wait, 3, num_steps=10**9, **switches)
    unbroken = DQNAgent(Chance(), num_agents=2, **switches)
    unbroken.train(num_steps=made)
    assert everything(agent) == everything(unbroken)


@pytest.mark.parametrize(("number", "where", "episodes"), [(20, "step", 5), (6, "reset", 5), (1, "reset", 0)])
def test_a_signal_at_the_very_end_is_not_forgotten(number, where, episodes):
    """It comes in the last step, in the reset after it, or where there is no step at all."""
    agent, made = interrupted(Chance, press_ctrl_c, number, where, num_agents=1, num_episodes=episodes)
    assert made == 4 * episodes
    assert len(agent.history) == episodes


def test_training_in_a_thread_where_there_are_no_signals_is_training():
    usual, threaded = (DQNAgent(Maze(slip=0.2), num_agents=2) for _ in range(2))
    usual.train(num_steps=30)
    thread = threading.Thread(target=threaded.train, kwargs={"num_steps": 30})
    thread.start()
    thread.join()
    assert everything(threaded) == everything(usual)


def test_a_handler_that_somebody_has_set_is_the_one_that_is_asked():
    heard = []

    def note(number, _):
        heard.append(number)

    signal.signal(signal.SIGINT, note)
    agent = DQNAgent(Stopped(Chance(), press_ctrl_c, 7))
    try:
        agent.train(5)
    except KeyboardInterrupt:
        pytest.fail("another's handler was put aside")
    assert len(agent.history) == 5
    assert signal.getsignal(signal.SIGINT) is note
    assert heard == [signal.SIGINT]
