"""Q-learning: the package's compiled loop against the same loop in C, and against the original lesson's program.

    python tests/benchmarks/q_learning.py

The C twin (q_learning.c) does the same work, draw for draw, and must end with the same table to the last bit.
"""

import ctypes

import numpy as np
import original_q_table
from measure import address, compile_c, compiler, medians, seconds, show

from course_lib import Maze, QAgent, kernels

SETTINGS = {"gamma": 0.9, "alpha": 0.1, "epsilon": 0.1}
MAX_STEPS = 1000
SHORTEST = 6  # moves from the start of the lesson's maze to its goal
C_NUMPY, C_INLINE = "C, numpy's PCG64 through bitgen_t", "C, PCG64 written out"
TRAIN, KERNEL, ORIGINAL = "QAgent.train", "its compiled loop alone", "the original program"
TARGETS = {C_NUMPY: 0.8, C_INLINE: 0.8, ORIGINAL: 300}


def free_bumps():
    """The lesson's maze, where running into a wall costs nothing and ends nothing."""
    return Maze(wall_reward=0.0, wall_ends_episode=False)


class Learned:
    """Room for what a run of Q-learning writes, and the generator that it draws from, as a new QAgent has it."""

    def __init__(self, maze, num_episodes):
        agent = QAgent(maze, **SETTINGS)
        self.maze, self.rng, self.q_table, self.visits = maze, agent.rng, agent.q_table, agent.visits
        self.returns, self.lengths = np.zeros(num_episodes), np.zeros(num_episodes, np.int64)
        self.terminated = np.zeros(num_episodes, np.bool_)

    def same_as(self, agent):
        """Whether a trained QAgent holds the same, to the last bit."""
        history = agent.history
        theirs = (agent.q_table, agent.visits, history.episode_return, history.episode_length, history.terminated)
        ours = (self.q_table, self.visits, self.returns, self.lengths, self.terminated)
        return all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))


def run_c(library, learned, inline):
    """Fill `learned` by the C loop; the seconds it took."""
    words = pcg64_words(learned.rng)
    mdp, numpys = learned.maze.mdp, learned.rng.bit_generator.ctypes.bit_generator
    whole, real = ctypes.c_int64, ctypes.c_double
    arguments = (
        address(learned.q_table), address(learned.visits), whole(mdp.num_actions),
        address(mdp.next_state), address(mdp.reward), address(mdp.terminal), whole(learned.maze.start),
        address(words) if inline else numpys,
        real(SETTINGS["gamma"]), real(SETTINGS["alpha"]), real(SETTINGS["epsilon"]), real(1.0),
        whole(MAX_STEPS), whole(len(learned.returns)),
        address(learned.returns), address(learned.lengths), address(learned.terminated),
    )  # fmt: skip
    return seconds(lambda: library.q_learning(*arguments))


def pcg64_words(rng):
    """State and increment of a PCG64, each as its high and its low 64 bits."""
    state = rng.bit_generator.state["state"]
    numbers = [half for number in (state["state"], state["inc"]) for half in divmod(number, 2**64)]
    return np.array(numbers, np.uint64)


def run_kernel(learned):
    """Fill `learned` by the compiled loop, called once and with nothing around it; the seconds it took."""
    mdp, start = learned.maze.mdp, np.full((1, 1, 1), learned.maze.start, float)
    arguments = (
        learned.q_table, learned.visits, (mdp.next_state, mdp.probability, mdp.reward, mdp.terminal),
        start, False, learned.rng, learned.maze.np_random,
        SETTINGS["gamma"], SETTINGS["alpha"], None, SETTINGS["epsilon"], 1.0, MAX_STEPS, 2**62, np.zeros(4),
        learned.returns, learned.lengths, learned.terminated,
    )  # fmt: skip
    return seconds(lambda: kernels.q_learning(*arguments))


def trained(maze, num_episodes):
    agent = QAgent(maze, **SETTINGS)
    agent.train(num_episodes, max_steps=MAX_STEPS)
    return agent


def run_train(maze, num_episodes):
    agent = QAgent(maze, **SETTINGS)
    return seconds(lambda: agent.train(num_episodes, max_steps=MAX_STEPS))


class CountingMaze(original_q_table.Maze):
    """The original's maze, which counts steps; not used where time is taken."""

    steps = 0

    def step(self, action):
        self.steps += 1
        return super().step(action)


def original_agent(maze_class, num_episodes):
    """The original's agent before training, with the same random numbers ahead of it every time."""
    np.random.seed(0)  # noqa: NPY002
    maze = maze_class(original_q_table.GRID, 0, 0, 3, 3)
    return original_q_table.QAgent(**SETTINGS, num_episodes=num_episodes, maze=maze)


def run_original(num_episodes):
    return seconds(original_agent(original_q_table.Maze, num_episodes).train)


def greedy_length(q_table, maze):
    """How many best actions lead from the start to the goal; up to MAX_STEPS."""
    state, _ = maze.reset()
    for step in range(1, MAX_STEPS + 1):
        state, _, terminated, _, _ = maze.step(int(np.argmax(q_table[state])))
        if terminated:
            return step
    return MAX_STEPS


def c_libraries():
    return {C_NUMPY: compile_c("q_learning.c"), C_INLINE: compile_c("q_learning.c", "-DINLINE_PCG64")}


def check_c(libraries, num_episodes):
    """`ValueError` unless both C twins and the bare kernel give what QAgent gives, to the last bit; its steps."""
    maze = free_bumps()
    agent = trained(maze, num_episodes)
    for name, library in libraries.items():
        learned = Learned(maze, num_episodes)
        run_c(library, learned, name == C_INLINE)
        if not learned.same_as(agent):
            raise ValueError(f"{name} and QAgent.train learned different tables")
    learned = Learned(maze, num_episodes)
    run_kernel(learned)
    if not learned.same_as(agent):
        raise ValueError("the compiled loop alone and QAgent.train learned different tables")
    return int(agent.history.episode_length.sum())


def check_original(num_episodes):
    """`ValueError` unless the original and QAgent both learn the shortest way; the original's steps.

    They draw in different ways, so their tables are not the same number for number.
    """
    maze = free_bumps()
    theirs = original_agent(CountingMaze, num_episodes)
    theirs.train()
    found = {
        "the original": greedy_length(np.array(theirs.q_table).reshape(-1, 4), maze),
        "QAgent": greedy_length(trained(maze, num_episodes).q_table, maze),
    }
    if set(found.values()) != {SHORTEST}:
        raise ValueError(f"the shortest way has {SHORTEST} moves, found: {found}")
    return theirs.maze.steps


def main(num_episodes=100_000, original_episodes=1000, repeats=25):
    maze = free_bumps()
    libraries = c_libraries() if compiler() else {}
    steps = dict.fromkeys([*libraries, TRAIN, KERNEL], check_c(libraries, num_episodes))
    steps[ORIGINAL] = check_original(original_episodes)
    runs = {
        name: lambda name=name: run_c(libraries[name], Learned(maze, num_episodes), name == C_INLINE)
        for name in libraries
    }
    runs[TRAIN] = lambda: run_train(maze, num_episodes)
    runs[KERNEL] = lambda: run_kernel(Learned(maze, num_episodes))
    runs[ORIGINAL] = lambda: run_original(original_episodes)
    taken = medians(runs, repeats)
    rate = {name: steps[name] / taken[name] for name in runs}
    rows = [("program", "ns a step", "steps a second", "speed of QAgent.train over it", "target")]
    for name in runs:
        target = f"{TARGETS[name]} or more" if name in TARGETS else ""
        rows.append((name, f"{1e9 / rate[name]:.1f}", f"{rate[name]:,.0f}", f"{rate[TRAIN] / rate[name]:.2f}", target))
    show(f"Q-learning in the lesson's maze, {steps[TRAIN]:,} steps, medians of {repeats} runs in turn", rows)
    if not libraries:
        print("\ngcc is not installed: nothing in C to compare with")


if __name__ == "__main__":
    main()
