"""Task 1, a bump is not the end: the mouse stays where it is and tries another action."""

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_1.learning import check_learned, check_steps
from course_lib.checks.homework_1.mazes import (
    blank,
    bumpy_mazes,
    map_of,
    place,
    random_table,
    table_that_loves_walls,
)
from course_lib.checks.homework_1.walks import check_one_whole_episode, play
from course_lib.maze import Action, Maze


def _walks_on_to_the_cheese(call, seed):
    for i, maze in enumerate(bumpy_mazes(seed)):
        world, _ = play(call, maze, blank(maze), seed + i)
        check_one_whole_episode(world)


def _heeds_the_clock(call, seed):
    maze = Maze.random(9, 9, walls=0.1, seed=seed, wall_ends_episode=False)
    world, _ = play(call, maze, blank(maze), seed, time_limit=15)
    check_one_whole_episode(world)


def _tries_another_action(call, seed):
    for i, maze in enumerate(bumpy_mazes(seed)):
        for table in (table_that_loves_walls(maze, seed + i), blank(maze)):
            world, _ = play(call, maze, table, seed + i)
            for episode in world.episodes:
                _check_no_second_bump(maze, episode)
            check_one_whole_episode(world)


def _check_no_second_bump(maze, episode):
    bumped = {}
    for t, state, action, _, _, bump in episode.steps():
        if bump and (state, action) in bumped:
            _say_bumped_again(maze, state, action, t, bumped[state, action])
        if bump:
            bumped[state, action] = t


def _say_bumped_again(maze, state, action, now, before):
    came = f"steps {before + 1} and {now + 1}: {Action(action).name} from {place(maze, state)}, a bump both times"
    if now == before + 1:
        likely = (
            "your mouse chooses among all actions again, though it has just bumped: leave out the actions that have "
            "bumped in this cell."
        )
    else:
        likely = (
            "your mouse forgets its bumps when it tries another action or leaves the cell: remember them until the "
            "episode is over."
        )
    raise NotYet(came, likely, map_of(maze, state))


def _learns_from_every_step(call, seed):
    for i, maze in enumerate(bumpy_mazes(seed)):
        before = random_table(maze, seed + i)
        world, returned = play(call, maze, before, seed + i)
        check_learned(world, before, returned)


def _counts_its_steps(call, seed):
    for i, maze in enumerate(bumpy_mazes(seed)):
        world, returned = play(call, maze, table_that_loves_walls(maze, seed + i), seed + i)
        check_steps(world, returned)


goes_on_after_a_bump = Check(
    "goes_on_after_a_bump",
    title="Task 1, a bump is not the end",
    usage="play_on(maze, q_table, rng)",
    trials=[
        Trial(
            "four mazes full of walls", "one reset, then steps, bumps and all, to the cheese", _walks_on_to_the_cheese
        ),
        Trial("a clock that stops the episode after 15 steps", "no step after that", _heeds_the_clock),
        Trial(
            "tables that love walls",
            "in one episode, no second bump into the same wall from the same cell",
            _tries_another_action,
        ),
        Trial("a table full of numbers", "after each step, a bump too, lesson 3's update", _learns_from_every_step),
        Trial("what it returns", "the number of steps", _counts_its_steps),
    ],
    hints=[
        "Begin with lesson 3's `play_episode`. In these mazes `terminated` is false after a bump, so its loop already "
        "goes on. What is missing is that the mouse tries another action.",
        "Keep a set of pairs `(state, action)` that have bumped in this episode. `info['bumped']` tells you when to "
        "add one. Make the set before the loop.",
        "List the actions that are left: `[a for a in range(4) if (state, a) not in bumped]`. Then choose among them: "
        "at random with probability epsilon, else one with the highest value in `q_table[state]`.",
        "The update needs no change at all: after a bump `next_state` is `state`, and `terminated` is false.",
    ],
)
