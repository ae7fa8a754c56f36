"""Remembers pairs of cell and action beside the cells, asks whether it can walk before it trains, and prints a lot."""

import numpy as np

bumped_ever = set()  # in all games, on purpose never looked at


def show(maze, state, steps):
    print(f"step {steps}: in {maze.cell(state)}")


def learn(Q, s, a, r, s_next, end):
    Q[s, a] += 0.1 * (r + (0 if end else 0.9 * Q[s_next].max()) - Q[s, a])


def play_on(maze, Q, rng):
    s, _ = maze.reset()
    bumps, n = set(), 0
    while True:
        A = [a for a in range(4) if (s, a) not in bumps]
        a = A[int(len(A) * rng.random())] if rng.random() < 0.1 else A[int(Q[s, A].argmax())]
        s_next, r, end, clock, info = maze.step(a)
        n = n + 1
        show(maze, s_next, n)
        learn(Q, s, a, r, s_next, end)
        if info["bumped"]:
            bumps |= {(s, a)}
            bumped_ever.add((s, a))
        if end or clock:
            return n
        s = s_next


def play_remembering(maze, Q, rng):
    s, _ = maze.reset()
    done, cells, n, back = set(), {s}, 0, {}
    while True:
        r0, c0 = maze.cell(s)
        A = []
        for a, r1, c1 in [(0, r0 - 1, c0), (1, r0 + 1, c0), (2, r0, c0 - 1), (3, r0, c0 + 1)]:
            if 0 <= r1 < maze.rows and 0 <= c1 < maze.columns:
                if (s, a) not in done and maze.state(r1, c1) not in cells:
                    A.append(a)
        if not A:
            a = back[s]
        elif rng.random() < 0.1:
            a = A[int(len(A) * rng.random())]
        else:
            a = A[int(Q[s, A].argmax())]
        done.add((s, a))
        s_next, r, end, clock, info = maze.step(a)
        n = n + 1
        show(maze, s_next, n)
        learn(Q, s, a, r, s_next, end)
        if s_next not in cells:
            back[s_next] = [1, 0, 3, 2][a]
        cells.add(s_next)
        if end or clock:
            return n
        s = s_next


def can_walk(eval_maze, Q):
    s, _ = eval_maze.reset()
    while True:
        s, r, end, clock, info = eval_maze.step(Q[s].argmax())
        if end or clock:
            return bool(end) and not info["bumped"]


def train(maze, eval_maze, rng, max_episodes):
    Q = np.zeros((maze.rows * maze.columns, 4))
    episodes = 0
    while not can_walk(eval_maze, Q) and episodes < max_episodes:
        play_remembering(maze, Q, rng)
        episodes += 1
        print("episode", episodes, "done")
        print(Q)
    return Q, episodes
