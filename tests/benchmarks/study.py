"""Many small agents: what ten thousand of the lesson's take, and what a second core is good for.

    python tests/benchmarks/study.py

A study of tables is run by one thread, by two, by one worker process and by two, in turn; all must find the same to the
last bit. The compiled loop by itself, which leaves the interpreter alone for a second at a time, says what the second
core of this machine has to give at that moment.
"""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack
from multiprocessing import get_context

from measure import medians, seconds, show

from course_lib import Maze, QAgent, study

WORLDS = {"a bump costs and ends nothing": {"wall_reward": 0.0, "wall_ends_episode": False}, "strict": {}}
ONE_THREAD, TWO_THREADS = "1 thread", "2 threads"
ONE_PROCESS, TWO_PROCESSES = "1 worker process", "2 worker processes"
LIMIT, FACTOR = 10.0, 1.7  # seconds for ten thousand agents on two cores; how much faster two cores are than one


def pools(stack):
    """{name: executor}; worker processes are started with nothing of this one's threads."""
    fresh = get_context("spawn")
    made = {
        ONE_THREAD: ThreadPoolExecutor(1),
        TWO_THREADS: ThreadPoolExecutor(2),
        ONE_PROCESS: ProcessPoolExecutor(1, fresh),
        TWO_PROCESSES: ProcessPoolExecutor(2, fresh),
    }
    return {name: stack.enter_context(pool) for name, pool in made.items()}


def train(rules, num_agents, num_episodes, executor):
    grid = {"env": rules, "num_episodes": num_episodes}
    return study.run(study.train_tables, grid, seeds=num_agents, executor=executor)


def check_same(executors, rules, num_agents, num_episodes):
    """`ValueError` unless all executors find the same to the last bit; the mean return of all agents."""
    found = {name: train(rules, num_agents, num_episodes, pool).measures for name, pool in executors.items()}
    for name, measures in found.items():
        for measure, numbers in measures.items():
            if numbers.tobytes() != found[ONE_THREAD][measure].tobytes():
                raise ValueError(f"{name} and {ONE_THREAD} found different numbers for {measure}")
    return float(found[ONE_THREAD]["mean_return"].mean())


def long_runs(executor, num_episodes, num_agents=4):
    """So many agents of so many episodes, in which Python has next to nothing to do."""
    rules = WORLDS["a bump costs and ends nothing"]
    return list(executor.map(lambda seed: len(QAgent(Maze(**rules), seed=seed).train(num_episodes)), range(num_agents)))


def main(num_agents=10_000, num_episodes=1000, long_episodes=500_000, repeats=5):
    with ExitStack() as stack:
        executors = pools(stack)
        for title, rules in WORLDS.items():
            check_same(executors, rules, min(num_agents, 200), num_episodes)
            runs = {
                name: lambda pool=pool, rules=rules: seconds(lambda: train(rules, num_agents, num_episodes, pool))
                for name, pool in executors.items()
            }
            alone = {
                threads: lambda pool=executors[threads]: seconds(lambda: long_runs(pool, long_episodes))
                for threads in (ONE_THREAD, TWO_THREADS)
            }
            taken = medians(runs | {f"loop, {threads}": run for threads, run in alone.items()}, repeats)
            rows = [("who", "seconds", f"of {LIMIT:g} s", "times as fast", "target")]
            for name in runs:
                before = ONE_PROCESS if name in (ONE_PROCESS, TWO_PROCESSES) else ONE_THREAD
                target = f"{FACTOR} or more" if name == TWO_PROCESSES else ""
                factor = taken[before] / taken[name]
                rows.append((name, f"{taken[name]:.2f}", f"{taken[name] / LIMIT:.2f}", f"{factor:.2f}", target))
            factor = taken[f"loop, {ONE_THREAD}"] / taken[f"loop, {TWO_THREADS}"]
            rows.append(("the loop alone, 2 threads", "", "", f"{factor:.2f}", ""))
            how_many = f"{num_agents:,} agents, {num_episodes:,} episodes each"
            show(f"{how_many}, lesson's maze, {title}, medians of {repeats} in turn", rows)


if __name__ == "__main__":
    main()
