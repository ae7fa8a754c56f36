"""Task 2, a memory of cells: the mouse keeps to fresh ones, and is not lost in a dead end."""

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_1.learning import check_learned, check_steps, table_after
from course_lib.checks.homework_1.mazes import (
    blank,
    bumpy_mazes,
    corridor,
    labyrinth,
    random_table,
    table_that_loves_walls,
    table_that_turns_back,
)
from course_lib.checks.homework_1.memory import Choices, open_fresh_actions
from course_lib.checks.homework_1.task_1 import MISTAKES_WITH_CHOICES, say_bumped_again, second_bumps
from course_lib.checks.homework_1.walks import (
    check_arrived,
    check_follows,
    check_not_too_long,
    check_one_whole_episode,
    check_played,
    explain_fault,
    nothing_was_left,
    play,
)
from course_lib.checks.learner import Fault, Kind, Seed
from course_lib.checks.worlds import Watched
from course_lib.maze import Maze

_NOT_EMPTIED = (
    "your mouse's memory is not emptied between episodes: make the set inside the function, "
    "not outside it and not as a default argument."
)
_ROWS_FOR_COLUMNS = (
    "your mouse takes one cell for another where a maze is not square: `state = row * columns + column`, "
    "which `maze.state(row, column)` works out."
)


def _leaves_visited_cells(call, seed):
    seen = Choices(None, [])
    lesson = bumpy_mazes(seed)[0]
    _watch_choices(call, lesson, blank(lesson), seed, seen)
    if not seen.returns:
        _check_does_as_well_again(call, lesson, seed)
    for maze, table in _with_tables(_square_mazes(seed), seed):
        _watch_choices(call, maze, table, seed, seen)
    square, seen = seen, Choices(None, [])
    try:
        for maze, table in _with_tables(_oblong_mazes(seed), seed):
            _watch_choices(call, maze, table, seed, seen)
    except Fault as fault:
        if nothing_was_left(fault) and not square.returns:
            raise NotYet(f"in a maze that is not square: {fault}", _ROWS_FOR_COLUMNS) from None
        raise
    if seen.often and not square.returns:
        seen.say(_ROWS_FOR_COLUMNS)
    square.add(seen)
    square.say()
    _heeds_known_walls(call, seed)


def _check_does_as_well_again(call, maze, seed):
    """The same call several times: a mouse that does well the first time, and not again, has kept its memory."""
    for _ in range(5):
        try:
            again = Choices(None, [])
            _watch_choices(call, maze, blank(maze), seed, again)
            again.say()
        except (NotYet, Fault) as finding:
            if isinstance(finding, Fault) and finding.kind is not Kind.RAISED:
                raise
            call.kept["memory stays"] = True
            came = f"one episode went well; then, in another that began like it, {finding}"
            raise NotYet(came, _NOT_EMPTIED, getattr(finding, "map", "")) from None


def _watch_choices(call, maze, table, seed, seen):
    """Add to `seen` what the mouse chooses before the first dead end of an episode."""
    world = Watched(maze)
    try:
        call(world, table, Seed(seed))
    except Fault as fault:
        seen.add(Choices(maze, world.episodes, only_before_dead_ends=True))
        if fault.kind is Kind.RAISED:
            seen.say()  # it went wrong before it came to this
        explain_fault(fault, world, remembers=True)
        raise
    check_not_too_long(world, "")
    check_one_whole_episode(world, remembers=True)
    seen.add(Choices(maze, world.episodes, only_before_dead_ends=True))


def _square_mazes(seed):
    mazes = [maze for maze in bumpy_mazes(seed) if maze.rows == maze.columns]
    return mazes + [Maze.random(8, 8, walls=0.0, wall_ends_episode=False)] * 4


def _oblong_mazes(seed):
    shapes = ((5, 7), (7, 5), (4, 9))
    return [Maze.random(*shape, walls=0.1, seed=seed, wall_ends_episode=False) for shape in shapes]


def _with_tables(mazes, seed):
    """Each maze with an empty table, and with one that would rather turn back."""
    return [(maze, table) for maze in mazes for table in (blank(maze), table_that_turns_back(maze, seed))]


def _heeds_known_walls(call, seed):
    """Where a fresh cell is at hand; in a dead end only the way out counts."""
    again = []
    for i, maze in enumerate(bumpy_mazes(seed)):
        world, _ = play(call, maze, table_that_loves_walls(maze, seed + i), seed + i, remembers=True)
        for episode in world.played:
            again += [bump for bump in second_bumps(maze, episode) if open_fresh_actions(maze, episode, bump[-1])]
    if again:
        at_once = [bump for bump in again if bump[-1] == bump[-2] + 1]
        say_bumped_again(*(at_once or again)[0], at_once=bool(at_once))


def _gets_out_of_dead_ends(call, seed):
    for i in range(4):
        maze, table = corridor(4 * seed + i)
        world, _ = play(call, maze, table, seed + i, remembers=True)
        check_arrived(world)
    for i, rooms in enumerate((3, 4, 5)):
        maze = labyrinth(rooms, 10 * seed + i)
        world, _ = play(call, maze, random_table(maze, seed + i), seed + i, remembers=True, time_limit=5000)
        check_arrived(world, lesson_limit_will_do=True)


def _remembers_after_a_dead_end(call, seed):
    for i in range(8):
        maze = labyrinth(4, 100 + 10 * seed + i)
        world, _ = play(call, maze, random_table(maze, seed + i), seed + i, remembers=True, time_limit=5000)
        check_arrived(world, lesson_limit_will_do=True)
        before, all_choices = (Choices(maze, world.episodes, only_before_dead_ends=only) for only in (True, False))
        before.say()
        all_choices.say(
            "your mouse forgets cells in a dead end. It may walk back over those that it knows, but must still know "
            "them when it comes to a fork."
        )


def _begins_each_episode_afresh(call, seed):
    maze = bumpy_mazes(seed)[0]
    world, table = Watched(maze), blank(maze)
    for i in range(10):
        try:
            returned = call(world, table, Seed(seed + i))
        except Fault as fault:
            if fault.kind is Kind.RAISED and call.kept.get("memory stays"):
                raise NotYet(f"in episode {i + 1}: {fault}", _NOT_EMPTIED) from None
            explain_fault(fault, world, remembers=True)
            raise
        check_not_too_long(world, "")
        check_played(world)
        table = table_after(returned, table)
    Choices(maze, world.episodes[:1]).say()
    later = Choices(maze, world.episodes[1:])
    later.say(_NOT_EMPTIED if call.kept.get("memory stays") else "")


def _follows_its_table(call, seed):
    lesson, *larger = bumpy_mazes(seed)
    mazes = [lesson, *larger[1:], Maze.random(6, 6, walls=0.0, wall_ends_episode=False)]
    check_follows(call, mazes, seed, remembers=True)


def _learns_and_counts(call, seed):
    open_maze = Maze.random(9, 9, walls=0.1, seed=seed, wall_ends_episode=False)
    check_one_whole_episode(play(call, open_maze, blank(open_maze), seed, remembers=True, time_limit=10)[0])
    played = []
    mazes = [*bumpy_mazes(seed), labyrinth(4, seed)]
    with_tables = [(maze, random_table(maze, seed + i)) for i, maze in enumerate(mazes)]
    for i, (maze, before) in enumerate([*with_tables, corridor(2 * seed), corridor(2 * seed + 1)]):
        played.append(play(call, maze, before, seed + i, remembers=True))
        check_learned(played[-1][0], before, played[-1][1])
    check_steps(played)


keeps_to_fresh_cells = Check(
    "keeps_to_fresh_cells",
    title="Task 2, a memory of cells",
    usage="play_remembering(maze, q_table, rng)",
    trials=[
        Trial(
            "many mazes, and tables that would rather turn back",
            "no visited cell and no known wall, while a fresh cell is at hand",
            _leaves_visited_cells,
        ),
        Trial(
            "dead ends, and tables that love them",
            "back over visited cells, and on to the cheese",
            _gets_out_of_dead_ends,
        ),
        Trial("forks behind a dead end", "the visited cells are still known there", _remembers_after_a_dead_end),
        Trial("ten episodes in the same maze", "each begins with an empty memory", _begins_each_episode_afresh),
        Trial("tables that know the way", "most steps take the best of the fresh actions", _follows_its_table),
        Trial(
            "a clock, the table, and what it returns",
            "as in task 1: an end when truncated, lesson 3's update, the number of steps",
            _learns_and_counts,
        ),
    ],
    likely=MISTAKES_WITH_CHOICES
    | {
        "(row|column) must be": "your code asks for a cell beyond the edge: test row and column before you ask "
        "`maze.state`.",
    },
    hints=[
        "You need to know where an action leads before the mouse takes it. Row and column of a state come from "
        "`maze.cell(state)`, and back with `maze.state(row, column)`. What lies beyond the edge is no cell.",
        "Keep a set of visited cells, the start among them. An action is fresh if the cell ahead is in the maze, is "
        "not in that set, and has not turned out to be a wall. Walls that you bump into may go into the set too.",
        "Choose among the fresh actions only, for the random step as well as for the best one. If there are none "
        "you are in a dead end.",
        "The surest way out of a dead end is the way you came. Keep a list `path` of the cells from the start to here: "
        "append each new cell, and in a dead end take the last one off and step back to the one before it. Which "
        "action leads there? Try the four: it is the one whose cell ahead is `path[-1]`.",
    ],
)
