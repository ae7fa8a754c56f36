"""What a walk should have taught the mouse, and what else it may have learned from it."""

import numpy as np

from course_lib.checks.check import NotYet
from course_lib.checks.homework_1.mazes import ahead, map_of
from course_lib.checks.homework_1.memory import open_fresh_actions
from course_lib.checks.plain import described

GAMMA, ALPHA = 0.9, 0.1  # those that the tasks ask for

_LEARNED_INSTEAD = {
    "the cell bumped into": "after a bump your target looks up the cell that was bumped into. The mouse is not in it: "
    "it is still where it was, and `maze.step` says so.",
    "a bump as an end": "your update treats a bump as the end, without gamma · max Q(s', a'). The walk goes on from "
    "the same cell, so the target needs it.",
    "nothing from a bump": "your mouse learns nothing from a bump: its −1 has to reach the table too.",
    "nothing on the way back": "your mouse learns nothing while it walks back from a dead end: update the table after "
    "each step, whichever way it was chosen.",
    "the end as any step": "your update adds gamma · max Q(s', a') after the cheese as well. Nothing comes after it: "
    "use `terminated`.",
    "the action taken next": "your update looks at the action that the mouse took next; Q-learning looks at the best.",
    "the cell it came to": "your update writes into the row of the cell the mouse came to, not of the one it left.",
    "no alpha": "your update puts the target in the place of the old value: it is to go a tenth of the way, by alpha.",
    "no gamma": "gamma is missing from your target: `gamma * q_table[next_state].max()`.",
}


def table_after(returned, before):
    """The table that was passed to the learner's function, as it is after the call; `NotYet` if it is none any more."""
    after = returned.arrays[0]
    if not isinstance(after, np.ndarray) or after.shape != before.shape:
        raise NotYet(
            f"after the call `q_table` is {described(after)}; it was {described(before)}",
            "your function changes the form of the table: only its numbers are to change.",
        )
    if not np.isfinite(after).all():
        raise NotYet(
            "the table holds numbers that are infinite or NaN (no number)",
            "a line of your code divides by zero, or lets the numbers grow without end.",
        )
    return after


def check_learned(world, before, returned):
    """The table was learned in place, by lesson 3's rule, from each step of the walk that was made."""
    after = table_after(returned, before)
    right = learned(before, world.maze, world.episodes)
    if same(after, right):
        return
    if np.array_equal(before, after):
        raise NotYet(
            "the table is as it was",
            "your function learns in a copy, or not at all: lesson 3's `update` writes into `q_table` itself.",
        )
    state, action = np.argwhere(~np.isclose(after, right, atol=1e-9))[0]
    came = (
        f"q_table[{state}, {action}] was {before[state, action]:.4f} and became {after[state, action]:.4f}; "
        f"{right[state, action]:.4f} is right for the walk that was made"
    )
    for rule, likely in _LEARNED_INSTEAD.items():
        instead = learned(before, world.maze, world.episodes, rule)
        if rule == "the action taken next" and world.episodes[-1].truncated:  # what would have come next is not known
            last = world.episodes[-1].states[-2], world.episodes[-1].actions[-1]
            instead[last] = after[last]
        if same(after, instead):
            raise NotYet(came, likely, map_of(world.maze))
    raise NotYet(came, "your update is not that of lesson 3, with alpha = 0.1 and gamma = 0.9, once after each step.")


def same(table, other):
    return np.allclose(table, other, atol=1e-9)


def learned(before, maze, episodes, rule="Q-learning"):
    """The table after recorded walks, learned by the right rule, or by one of those that it is mistaken for."""
    table = before.copy()
    for episode in episodes:
        learn(table, maze, episode, rule)
    return table


def learn(table, maze, episode, rule="Q-learning"):
    """The same from one episode, in place."""
    last = len(episode) - 1
    gamma, alpha = 1.0 if rule == "no gamma" else GAMMA, 1.0 if rule == "no alpha" else ALPHA
    for t, state, action, reward, next_state, bumped in episode.steps():
        ended = episode.terminated and t == last
        if bumped and rule == "nothing from a bump":
            continue
        if rule == "nothing on the way back" and not bumped and not open_fresh_actions(maze, episode, t):
            continue
        if bumped and rule == "the cell bumped into":
            next_state = ahead(maze, state, action)
        if bumped and rule == "a bump as an end":
            ended = True
        value = table[next_state].max()
        if rule == "the action taken next" and t < last:
            value = table[next_state, episode.actions[t + 1]]
        if rule == "the end as any step":
            ended = False
        row = next_state if rule == "the cell it came to" else state
        target = reward + (0 if ended else gamma * value)
        table[row, action] += alpha * (target - table[row, action])


def check_steps(played):
    """What was returned is the number of steps, bumps included. played: [(world, returned), …] of several episodes."""
    wrong = [(world, returned.value) for world, returned in played if not _is_number(returned.value, world.steps)]
    if not wrong:
        return
    world, value = wrong[0]
    bumps = [sum(sum(episode.bumps) for episode in world.episodes) for world, _ in wrong]
    likely = "your function returns something else than the number of all steps, bumps included."
    if value is None:
        likely = "your function ends without `return`."
    elif all(_is_number(value, world.steps - 1) for world, value in wrong):
        likely = "you return the index of the last step, which counts from 0."
    elif all(_is_number(value, world.steps - hit) for (world, value), hit in zip(wrong, bumps, strict=True)):
        likely = "you do not count the bumps; they are steps too, since they take the mouse's time."
    raise NotYet(f"{described(value)} after {world.steps} steps, {bumps[0]} of them bumps", likely)


def _is_number(value, number):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value == number
