"""Task 1, a bump is not the end: the mouse stays where it is and tries another action."""

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_1.learning import check_learned, check_steps
from course_lib.checks.homework_1.mazes import (
    blank,
    bumpy_mazes,
    map_of,
    place,
    random_table,
    staircase,
    table_that_loves_walls,
)
from course_lib.checks.homework_1.walks import check_follows, check_one_whole_episode, nothing_was_left, play
from course_lib.checks.learner import Fault
from course_lib.maze import Action, Maze

MISTAKES_WITH_CHOICES = {
    "'set' object is not subscriptable": "a set is used like a list. If it is what you give to `choose`: "
    "it wants a list of actions.",
    "'float' object has no attribute 'random'": "a number was given where `rng` belongs. The order is "
    "`choose(q_table, state, rng, actions)`.",
    "empty sequence|[Cc]annot choose from an empty|must be non-empty": "no action is left to choose from. Are bumps of "
    "an earlier episode, or of another cell, still in the memory?",
    "out of bounds for axis 1 with size 4": "an action is too large: there are four, numbered from 0 to 3.",
    "out of bounds for axis 0": "your code expects a maze of another size: a table has one row for each state.",
}


_ONE_CELL = (
    "your mouse gives up a direction everywhere once it has bumped that way. A bump concerns one cell and one action: "
    "remember the pair, `(state, action)`."
)


def _walks_on_to_the_cheese(call, seed):
    mazes = bumpy_mazes(seed)
    check_one_whole_episode(*(play(call, maze, blank(maze), seed + i)[0] for i, maze in enumerate(mazes)))
    _climbs_down_stairs(call, seed)


def _climbs_down_stairs(call, seed):
    """Where every action bumps in one cell and is needed in another, with a table that loves right and down."""
    for i in range(3):
        maze = staircase(3 + i)
        table = blank(maze)
        table[:, [Action.DOWN, Action.RIGHT]] = 0.3
        try:
            world, _ = play(call, maze, table, seed + i)
        except Fault as fault:
            if nothing_was_left(fault):
                raise NotYet(f"on a staircase: {fault}", _ONE_CELL, map_of(maze)) from None
            raise
        check_one_whole_episode(world)
        episode = world.played[0]
        if not episode.reached_the_cheese:
            where = place(maze, episode.states[-1])
            raise NotYet(
                f"on a staircase no cheese after {len(episode)} steps; the mouse is in {where}",
                "your mouse does not follow its table, which says right and down here."
                if {Action.DOWN, Action.RIGHT} & set(episode.actions[-200:])
                else _ONE_CELL,
                map_of(maze, episode.states[-1]),
            )


def _follows_its_table(call, seed):
    check_follows(call, [bumpy_mazes(seed)[0], *bumpy_mazes(seed)[2:]], seed)


def _heeds_the_clock(call, seed):
    maze = Maze.random(9, 9, walls=0.1, seed=seed, wall_ends_episode=False)
    world, _ = play(call, maze, blank(maze), seed, time_limit=15)
    check_one_whole_episode(world)


def _tries_another_action(call, seed):
    worlds = []
    for i, maze in enumerate(bumpy_mazes(seed)):
        worlds += [
            play(call, maze, table, seed + i)[0] for table in (table_that_loves_walls(maze, seed + i), blank(maze))
        ]
    again = [bump for world in worlds for episode in world.episodes for bump in second_bumps(world.maze, episode)]
    if again:
        at_once = [bump for bump in again if bump[-1] == bump[-2] + 1]
        say_bumped_again(*(at_once or again)[0], at_once=bool(at_once))
    check_one_whole_episode(*worlds)


def second_bumps(maze, episode):
    """(maze, state, action, t of one bump, t of the next) of each bump into a wall that had been bumped into."""
    bumped = {}
    for t, state, action, _, _, bump in episode.steps():
        if bump and (state, action) in bumped:
            yield maze, state, action, bumped[state, action], t
        if bump:
            bumped[state, action] = t


def say_bumped_again(maze, state, action, before, now, *, at_once):
    """Raise `NotYet` about the second of two bumps."""
    came = f"steps {before + 1} and {now + 1}: {Action(action).name} from {place(maze, state)}, a bump both times"
    likely = "your mouse forgets its bumps when it tries another action or leaves the cell (remember them until the "
    likely += "episode is over), or its random step does not look at them."
    if at_once:
        likely = "your mouse chooses among all actions again, though it has just bumped: leave out the actions that "
        likely += "have bumped in this cell."
    raise NotYet(came, likely, map_of(maze, state))


def _learns_from_every_step(call, seed):
    for i, maze in enumerate(bumpy_mazes(seed)):
        before = random_table(maze, seed + i)
        world, returned = play(call, maze, before, seed + i)
        check_learned(world, before, returned)


def _counts_its_steps(call, seed):
    mazes = bumpy_mazes(seed)
    check_steps([play(call, maze, table_that_loves_walls(maze, seed + i), seed + i) for i, maze in enumerate(mazes)])


goes_on_after_a_bump = Check(
    "goes_on_after_a_bump",
    title="Task 1, a bump is not the end",
    usage="play_on(maze, q_table, rng)",
    trials=[
        Trial(
            "mazes full of walls, and stairs",
            "one reset, then steps until the cheese; a bump does not end the walk",
            _walks_on_to_the_cheese,
        ),
        Trial("a clock that stops the episode after 15 steps", "no step after that", _heeds_the_clock),
        Trial(
            "tables that love walls",
            "in one episode, no second bump into the same wall from the same cell",
            _tries_another_action,
        ),
        Trial("tables that know the way", "most steps take the best action", _follows_its_table),
        Trial(
            "tables of random numbers", "lesson 3's update after every step, also after a bump", _learns_from_every_step
        ),
        Trial("what it returns", "the number of all steps, bumps included", _counts_its_steps),
    ],
    likely=MISTAKES_WITH_CHOICES,
    hints=[
        "Begin with lesson 3's `play_episode`. In these mazes `terminated` is false after a bump, so its loop already "
        "goes on. What is missing is that the mouse tries another action.",
        "Keep a set of pairs `(state, action)` that have bumped in this episode. `info['bumped']` tells you when to "
        "add one. Make the set before the loop.",
        "The update needs no change at all: after a bump `next_state` is `state`, and `terminated` is false. What "
        "changes is which actions `choose` may choose from.",
        "List the actions that are left: `actions = [a for a in range(4) if (state, a) not in bumped]`. Then "
        "`choose(q_table, state, rng, actions)`.",
    ],
)
