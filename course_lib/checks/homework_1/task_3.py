"""Task 3, training that stops by itself, as soon as the mouse can walk to the cheese."""

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_1.mazes import ahead, blank, map_of, place
from course_lib.checks.homework_1.training import train
from course_lib.checks.plain import counted, described
from course_lib.maze import LESSON_GRID, Action, Maze, Tile

_SHAPES = ((3, 4), (4, 3), (4, 4), (3, 5))
_MOST_EPISODES = 300
_TESTS_IN_MAZE = "your mouse walks its test in `maze`. There a bump ends nothing; `eval_maze` is for the test."
_GOES_ON = "your loop goes on although the mouse can walk to the cheese: stop at the first walk that succeeds."


def _trainings(call, seed):
    """Several trainings, one after the other, done once a check.

    All mazes but the lesson's have walls around them, so that a mouse which knows little bumps on its test walk.
    """
    mazes = [Maze.random(*shape, walls=0.2, seed=7 * seed + i) for i, shape in enumerate(_SHAPES, start=1)]
    grids = [LESSON_GRID] + [np.pad(maze.grid, 1, constant_values=Tile.WALL).tolist() for maze in mazes]
    return call.once("trainings", lambda: [train(call, grid, seed + i, _MOST_EPISODES) for i, grid in enumerate(grids)])


def _stops_when_it_can_walk(call, seed):
    for training in _trainings(call, seed):
        _check_it_trained_and_tested(training)
        episodes, walks = training.episodes, training.walks
        if not episodes:
            continue
        arrived = [walk.began for walk in walks if walk.reached_the_cheese]
        if arrived and episodes[-1].began > arrived[0]:
            played = sum(episode.began < arrived[0] for episode in episodes)
            raise NotYet(
                f"the mouse walked to the cheese after {counted(played, 'episode')}, but trained for {len(episodes)}",
                _GOES_ON,
            )
        if not arrived:
            _say_why_it_stopped(training)


def _check_it_trained(training):
    """There was an episode, but for a mouse that tests before it trains and was lucky."""
    if not training.episodes and not any(walk.reached_the_cheese for walk in training.walks):
        likely = "your function does not train: it is to play its episodes in `maze`."
        raise NotYet("no episode in `maze`", likely, map_of(training.maze))


def _check_it_trained_and_tested(training):
    episodes, walks, here = training.episodes, training.walks, map_of(training.maze)
    _check_it_trained(training)
    if not episodes:
        return
    if walks:
        tested_first = walks[0].began < episodes[0].began and walks[-1].began < episodes[-1].began
        if tested_first and len(walks) == len(episodes) < training.max_episodes:
            raise NotYet(
                f"{len(walks)} times a walk in `eval_maze` and then one in `maze`, at the end too",
                "the two mazes are mixed up: the mouse trains in `maze` and walks its test in `eval_maze`.",
            )
        return
    likely = "`eval_maze` was not used: it is there for the test walk, after every episode."
    if len(episodes) == 2 * (training.number or 0):
        likely = _TESTS_IN_MAZE
    elif len(episodes) < training.max_episodes and episodes[-1].reached_the_cheese:
        likely = (
            "your training stops at the first episode that reaches the cheese. That may be luck, the mouse was still "
            "exploring: let it walk greedily in `eval_maze` to be sure."
        )
    raise NotYet(f"{counted(len(episodes), 'episode')} without a walk in `eval_maze`", likely, here)


def _say_why_it_stopped(training):
    number, last = len(training.episodes), training.walks[-1]
    here, where = map_of(training.maze, last.states[-1]), place(training.maze, last.states[-1])
    if number >= training.max_episodes:
        raise NotYet(
            f"no test walk reached the cheese in {counted(number, 'episode')} of training",
            "your mouse learns nothing that it can walk by. Does its table begin with zeros, is it the same in all "
            "episodes and on the test walk, and does the test walk take the best action of each row?",
            here,
        )
    stopped = f"stopped after {counted(number, 'episode')}; the last test walk"
    if last.truncated:
        raise NotYet(
            f"{stopped} was truncated after {len(last)} steps, in {where}",
            "your function takes `truncated` for an arrival. The clock had stopped that walk, far from the cheese.",
            here,
        )
    if last.terminated:
        raise NotYet(
            f"{stopped} hit a wall from {where}",
            "your function takes every `terminated` for an arrival. In `eval_maze` a bump terminates too: look at the "
            "reward, or at `info['bumped']`.",
            here,
        )
    raise NotYet(
        f"{stopped} broke off after {len(last)} steps, in {where}",
        "your training stops although the mouse has not reached the cheese on its test walk.",
        here,
    )


def _tests_after_every_episode(call, seed):
    for training in _trainings(call, seed):
        _check_it_trained_and_tested(training)
        tests = [walk.began for walk in training.walks]
        ends = [episode.began for episode in training.episodes[1:]] + [np.inf]
        for number, (episode, end) in enumerate(zip(training.episodes, ends, strict=False), start=1):
            if not any(episode.began < test < end for test in tests):
                raise NotYet(
                    f"no walk in `eval_maze` after episode {number} of {len(training.episodes)}",
                    "your function tests only now and then, so it cannot stop as soon as the mouse can walk.",
                )


def _counts_its_episodes(call, seed):
    _check_counts(_trainings(call, seed))


def _check_counts(trainings):
    for training in trainings:
        _check_it_trained(training)
    wrong = [training for training in trainings if training.returned()[1] != len(training.episodes)]
    if not wrong:
        return
    numbers, played = [training.number for training in wrong], [len(training.episodes) for training in wrong]
    with_walks = [len(training.episodes) + len(training.walks) for training in wrong]
    likely = "your function returns something else than the number of episodes."
    if all(not training.walks and len(training.episodes) == 2 * training.number for training in wrong):
        likely = _TESTS_IN_MAZE
    elif numbers == [number - 1 for number in played]:
        likely = "your count begins at 0: after the first episode it must say 1."
    elif numbers == [number + 1 for number in played]:
        likely = "you count one more before you look whether the mouse can walk."
    elif numbers == with_walks:
        likely = "you count the test walks too: only episodes in `maze` are training."
    elif numbers == [training.world.steps for training in wrong]:
        likely = "you count steps, not episodes."
    raise NotYet(f"{described(numbers[0])}; {counted(played[0], 'episode')} in `maze`", likely)


def _returns_the_table_of_its_walks(call, seed):
    for training in _trainings(call, seed):
        table, _ = training.returned()
        shape = blank(training.maze).shape
        if table.shape != shape or not np.isfinite(table).all():
            raise NotYet(
                f"a table of shape {table.shape}, with {np.sum(~np.isfinite(table))} entries infinite or NaN",
                f"the table does not fit this maze: it needs a number for each state and action, {shape}.",
            )
        _check_it_trained_and_tested(training)
        if training.learned_as_taught():  # then the table that it had at each walk is known
            for number, (walk, at_walk) in enumerate(zip(training.walks, training.tables()[0], strict=True), start=1):
                _check_greedy(training.maze, walk, at_walk, f"test walk {number}")
        elif training.learned_as_taught(learns_on_walks=True):
            raise NotYet(
                "the table has changed on the test walks",
                "your mouse learns on its test walk too: leave out the update there.",
            )
        else:
            _check_greedy(training.maze, training.walks[-1], table, "last test walk")
    _check_ties(_trainings(call, seed))


def _check_greedy(maze, walk, table, name):
    """Each step took a best action of the table, or a best one among those that lead to cells it had not been in."""
    visited = set()
    for t, state, action, _, _, _ in walk.steps():
        visited.add(state)
        fresh = [other for other in Action if (cell := ahead(maze, state, other)) is not None and cell not in visited]
        if fresh and table[state, action] < table[state, fresh].max() - 1e-9:
            raise NotYet(
                f"{name}, step {t + 1}: {Action(action).name} from {place(maze, state)}, "
                f"worth {table[state, action]:.3f}; the best action there is worth {table[state].max():.3f}",
                "the test walk does not always take the best action of the table that you return: it must not "
                "explore, and not learn.",
                map_of(maze, state),
            )


def _check_ties(trainings):
    """The last walks took the first of equally good actions each time, or the last: the same table, the same walk."""
    guesses = [_guess(training) for training in trainings if training.walks]
    for rule in range(len(_RULES)):
        if not any(guess[rule] for guess in guesses):
            return
    t, state, action, other, maze = next(guess[0] for guess in guesses if guess[0])
    raise NotYet(
        f"step {t + 1} of a last test walk: {Action(action).name} from {place(maze, state)}, where "
        f"{Action(other).name} is worth as much",
        "your test walk guesses among equally good actions. The guess was lucky; asked again, the same table may fail. "
        "Take the first of the best, `np.argmax(q_table[state])`.",
        map_of(maze, state),
    )


_RULES = [(end, among) for end in (0, -1) for among in ("all", "fresh")]


def _guess(training):
    """For each rule the first step of the last walk that breaks it: (t, state, action, the rule's, maze) or None."""
    table, _ = training.returned()
    maze, walk, visited = training.maze, training.walks[-1], set()
    found = [None] * len(_RULES)
    for t, state, action, *_ in walk.steps():
        visited.add(state)
        fresh = [other for other in Action if (cell := ahead(maze, state, other)) is not None and cell not in visited]
        for i, (end, among) in enumerate(_RULES):
            actions = np.array(fresh if among == "fresh" and fresh else list(Action), int)
            values = table[state, actions]
            ruled = int(actions[np.flatnonzero(values == values.max())[end]])
            if found[i] is None and ruled != action:
                found[i] = t, state, action, ruled, maze
    return found


def _gives_up_in_time(call, seed):
    maze = Maze.random(7, 7, walls=0.25, seed=seed)
    training = train(call, maze.grid.tolist(), seed, 3)
    played = len(training.episodes)
    _check_it_trained_and_tested(training)
    if played > 3:
        likely = "your loop runs until the mouse can walk, however long that takes: it is to give up after "
        likely += "`max_episodes`."
        raise NotYet(f"{counted(played, 'episode')} with max_episodes = 3", likely)
    if played < 3 and not any(walk.reached_the_cheese for walk in training.walks):
        likely = "your loop stops before `max_episodes`, although no walk in `eval_maze` has reached the cheese."
        raise NotYet(f"{counted(played, 'episode')} with max_episodes = 3", likely)
    _check_counts([training])


stops_by_itself = Check(
    "stops_by_itself",
    title="Task 3, training that stops by itself",
    usage="train(maze, eval_maze, rng, max_episodes)",
    trials=[
        Trial("five mazes", "stops after the first greedy walk to the cheese without a bump", _stops_when_it_can_walk),
        Trial("when it tests", "a walk in `eval_maze` after every episode", _tests_after_every_episode),
        Trial("the number it returns", "the episodes played in `maze`", _counts_its_episodes),
        Trial(
            "the table it returns",
            "its best actions, the first of equals, are those of the test walks",
            _returns_the_table_of_its_walks,
        ),
        Trial("`max_episodes = 3` in a large maze", "three episodes, and an end", _gives_up_in_time),
    ],
    likely={
        "out of bounds for axis 0": "your table does not fit this maze: the mazes differ in size. A table needs "
        "`maze.observation_space.n` rows.",
    },
    hints=[
        "Split it in two: one function that walks once, greedily, in `eval_maze` and says whether the mouse arrived, "
        "and one that plays an episode in `maze`, asks the first, and stops or goes on.",
        "The walk is over when `terminated or truncated`. It has arrived if `terminated` is true and "
        "`info['bumped']` is false after the last step. It takes `np.argmax(q_table[state])` each time: nothing is "
        "learned on it, and epsilon has no part in it.",
        "The table begins as `np.zeros((maze.observation_space.n, 4))`, so that it fits any maze. "
        "`for episodes in range(1, max_episodes + 1):` counts from 1, so that `episodes` is the number you return.",
        "After each `play_remembering(maze, q_table, rng)`: `if can_walk(eval_maze, q_table): break`. After the loop "
        "`return q_table, episodes`.",
    ],
)
