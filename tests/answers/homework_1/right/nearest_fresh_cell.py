"""In a dead end the mouse plans: a breadth-first search over the cells that it knows, to the nearest fresh one."""

from collections import deque

import numpy as np


def update(q, s, a, r, s2, end):
    q[s, a] += 0.1 * ((r if end else r + 0.9 * q[s2].max()) - q[s, a])


def neighbours(maze, s):
    row, column = maze.cell(s)
    for a, (dr, dc) in enumerate(((-1, 0), (1, 0), (0, -1), (0, 1))):
        if 0 <= row + dr < maze.rows and 0 <= column + dc < maze.columns:
            yield a, maze.state(row + dr, column + dc)


def plan(maze, s, visited, walls):
    """The actions from s over visited cells to the nearest cell with something fresh beside it."""
    queue, ways = deque([s]), {s: []}
    while queue:
        here = queue.popleft()
        for a, there in neighbours(maze, here):
            if there in walls:
                continue
            if there not in visited:
                return ways[here]
            if there not in ways:
                ways[there] = ways[here] + [a]
                queue.append(there)
    raise RuntimeError("there is no way to the cheese")


def play_remembering(maze, q_table, rng):
    s, _ = maze.reset()
    visited, walls, todo, steps, over = {s}, set(), [], 0, False
    while not over:
        if not todo:
            todo = plan(maze, s, visited, walls)
        if todo:
            a = todo.pop(0)
        else:
            fresh = [a for a, there in neighbours(maze, s) if there not in visited and there not in walls]
            if rng.random() < 0.1:
                a = fresh[rng.integers(len(fresh))]
            else:
                a = fresh[np.argmax(q_table[s, fresh])]
        s2, r, terminated, truncated, info = maze.step(a)
        update(q_table, s, a, r, s2, terminated)
        steps += 1
        if info["bumped"]:
            walls.add(dict(neighbours(maze, s))[a])
        visited.add(s2)
        s, over = s2, terminated or truncated
    return steps


def train(maze, eval_maze, rng, max_episodes):
    """Its test walk remembers as well: greedy among the fresh cells."""
    q_table = np.zeros((maze.rows * maze.columns, 4))
    for episodes in range(1, max_episodes + 1):
        play_remembering(maze, q_table, rng)
        s, info = eval_maze.reset()
        seen, terminated, truncated = {s}, False, False
        while not (terminated or truncated):
            fresh = [a for a, there in neighbours(maze, s) if there not in seen] or [0, 1, 2, 3]
            a = max(fresh, key=lambda a: q_table[s, a])
            s, r, terminated, truncated, info = eval_maze.step(a)
            seen.add(s)
        if terminated and not info["bumped"]:
            break
    return q_table, episodes
