"""How a mouse walked in a watched maze: one whole episode, and to the cheese."""

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.homework_1.mazes import map_of, place, table_that_knows_the_way
from course_lib.checks.homework_1.memory import Choices, open_fresh_actions
from course_lib.checks.learner import Fault, Kind, Seed
from course_lib.checks.worlds import Watched
from course_lib.maze import Action

_LIMIT_OF_LESSON_3 = 1000  # steps; a learner may have kept it
# When nothing is left to choose from.
_EMPTY_CHOICE_RAISES = (
    "IndexError",
    "KeyError",
    "StopIteration",
    "TypeError",
    "UnboundLocalError",
    "ValueError",
    "ZeroDivisionError",
)


def play(call, maze, table, seed, *, remembers=False, **limits):
    """One call of the learner's play(maze, q_table, rng): the watched maze and what was returned.

    remembers  it is the mouse of task 2
    """
    world = Watched(maze, **limits)
    try:
        returned = call(world, table, Seed(seed))
    except Fault as fault:
        explain_fault(fault, world, remembers=remembers)
        raise
    check_not_too_long(world, "")
    check_played(world)
    return world, returned


def explain_fault(fault, world, *, remembers=False):
    """Raise `NotYet` with the misunderstanding that a fault looks like, if the record shows one."""
    if fault.kind not in (Kind.INTERRUPTED, Kind.DIED) and (world.stepped_after or world.exhausted):
        check_not_too_long(world, str(fault))
    if not world.episodes:
        return
    if fault.kind is Kind.RAISED and remembers:
        Choices(world.maze, world.episodes).say()  # it went wrong before it came to this
    if fault.kind is Kind.RAISED and remembers and in_dead_end(world):
        here = world.episodes[-1].states[-1]
        raise NotYet(
            f"in a dead end ({place(world.maze, here)}): {fault}",
            "your code does not expect a dead end, where nothing fresh is left: say what the mouse does there."
            if nothing_was_left(fault)
            else "something goes wrong where nothing fresh is left: look at what your code does there.",
            map_of(world.maze, here),
        ) from None


def in_dead_end(world):
    """Whether the mouse was last in a cell with nothing fresh beside it."""
    episode = world.episodes[-1] if world.episodes else []
    return len(episode) > 0 and not open_fresh_actions(world.maze, episode, len(episode))


def nothing_was_left(fault):
    """Whether a fault may come from choosing among no actions at all."""
    return fault.kind is Kind.RAISED and str(fault).startswith(_EMPTY_CHOICE_RAISES)


def check_not_too_long(world, came):
    """The mouse stopped when its episode was over."""
    if world.stepped_after == "truncated":
        raise NotYet(
            came or "a step after the clock had stopped the episode",
            "your loop waits for `terminated` only: an episode is over when it is terminated or truncated.",
        )
    if world.stepped_after:
        raise NotYet(
            came or "a step after the mouse had found the cheese",
            "your loop does not stop at the cheese: an episode is over when `terminated` or `truncated` is true.",
        )
    if world.exhausted:
        raise NotYet(
            f"still going after {len(world.episodes)} episodes and {world.steps} steps",
            "your code plays episode after episode, without end.",
            last=True,
        )


def check_played(world):
    """At least one step was taken: who does nothing has not done it right."""
    if not world.episodes:
        raise NotYet("the maze was never reset", "your function does not begin an episode: call `maze.reset()` first.")
    if not world.played:
        raise NotYet("no step was taken", "your function returns before it has called `maze.step`.")


def check_one_whole_episode(*worlds, remembers=False):
    """In each world one episode, until the world says that it is over. A reset that no step follows is let pass."""
    for world in worlds:
        check_played(world)
    unfinished = [world for world in worlds if not world.played[0].over]
    if unfinished:
        # One walk may have ended at its first bump by chance.
        at_a_bump = all(world.played[0].bumps[-1] and sum(world.played[0].bumps) == 1 for world in unfinished)
        _say_why_it_ended(unfinished[0], at_a_bump, remembers)
    for world in worlds:
        if len(world.played) > 1:
            raise NotYet(
                f"{len(world.played)} episodes",
                "your function plays more than one episode: reset the maze once only.",
            )


def _say_why_it_ended(world, at_a_bump, remembers):
    maze, episode, began_again = world.maze, world.played[0], len(world.played) > 1
    here = map_of(maze, episode.states[-1])
    where = f"at step {len(episode)}, in {place(maze, episode.states[-1])}"
    came = f"reset {where}" if began_again else f"the walk ended {where}"
    in_a_dead_end = remembers and not open_fresh_actions(maze, episode, len(episode))
    if at_a_bump and in_a_dead_end:  # it may be either
        likely = "your mouse gives up in a dead end, or at a bump"
        if began_again:
            likely = "a dead end, or a bump, sends your mouse back to the start"
        likely += ": a bump ends nothing, and from a dead end it is to walk back over cells that it knows."
        raise NotYet(f"{came}, after a bump, in a dead end", likely, here)
    if at_a_bump:
        likely = "your loop stops at a bump. In this maze a bump ends nothing: only `terminated` and `truncated` do."
        if began_again:
            likely = "a bump still sends your mouse back to the start. `maze.reset()` belongs before the loop, once."
        raise NotYet(f"{came}, after a bump", likely, here)
    if in_a_dead_end:
        likely = "your mouse gives up in a dead end: it is to walk back over cells that it knows."
        if began_again:
            likely = "a dead end sends your mouse back to the start: it is to walk back over cells that it knows."
        raise NotYet(f"{came}, in a dead end", likely, here)
    likely = "your loop stops before the world says that the episode is over."
    if began_again:
        likely = "your mouse goes back to the start in the middle of an episode: reset the maze once, before the loop."
    raise NotYet(came, likely, here)


def check_arrived(world, *, lesson_limit_will_do=False):
    """The one episode ended at the cheese, not by the clock.

    lesson_limit_will_do  a mouse that stops itself after 1000 steps, as lesson 3's does, is given the benefit of the
                          doubt: one that wanders at random may need more
    """
    own_limit = len(world.played) == 1 and len(world.played[0]) >= _LIMIT_OF_LESSON_3 and not world.played[0].over
    if own_limit and lesson_limit_will_do:
        return
    if not own_limit:
        check_one_whole_episode(world, remembers=True)
    episode, maze = world.played[0], world.maze
    if episode.reached_the_cheese:
        return
    lately = episode.states[-200:]
    stayed = np.mean(np.array(lately[1:]) == np.array(lately[:-1]))
    raise NotYet(
        f"no cheese after {len(episode)} steps; the last 200 of them in {len(set(lately))} of the maze's cells, "
        f"around {place(maze, episode.states[-1])}",
        "your mouse is stuck in a dead end: it runs against the same walls or edges again and again. It is to walk "
        "back, whatever the table says."
        if stayed > 0.5
        else "your mouse is lost in a dead end: it goes to and fro over the cells that it knows. It is to walk back "
        "until a fresh one is at hand, whatever the table says.",
        map_of(maze, episode.states[-1]),
    )


def check_follows(call, mazes, seed, *, remembers=False):
    """With tables that know the way, the steps are best ones, of those that the task allows, well above chance."""
    best = number = by_chance = 0
    for i, maze in enumerate(mazes):
        table = table_that_knows_the_way(maze)
        for episode in range(5):
            world, _ = play(call, maze, table, 10 * (seed + i) + episode, remembers=remembers)
            check_one_whole_episode(world, remembers=remembers)
            for t, state, action, *_ in world.played[0].steps():
                allowed = open_fresh_actions(maze, world.played[0], t) if remembers else list(Action)
                are_best = table[state, allowed] >= table[state, allowed].max(initial=-np.inf) - 1e-6
                if action in allowed and not are_best.all():
                    number += 1
                    by_chance += are_best.mean()
                    best += are_best[allowed.index(action)]
    if best < (number + by_chance) / 2:
        raise NotYet(
            f"where there was a choice, {best} of {number} steps were best ones; chance alone makes {by_chance:.0f}",
            "your mouse does not follow its table: but for the steps on which it explores, it is to take the action "
            "with the highest value of those that it may choose.",
        )
