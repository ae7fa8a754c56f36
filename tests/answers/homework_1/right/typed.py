"""Types and dataclasses; the table is a list of lists in training, and is returned as one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray


class Cell(NamedTuple):
    row: int
    column: int


class World(Protocol):
    rows: int
    columns: int

    def reset(self) -> tuple[int, dict]: ...
    def step(self, action: int) -> tuple[int, float, bool, bool, dict]: ...


@dataclass(frozen=True, slots=True)
class Settings:
    gamma: float = 0.9
    alpha: float = 0.1
    epsilon: float = 0.1


@dataclass(slots=True)
class Memory:
    visited: set[Cell] = field(default_factory=set)
    walls: set[Cell] = field(default_factory=set)
    trail: list[Cell] = field(default_factory=list)

    def enter(self, cell: Cell) -> None:
        if cell not in self.visited:
            self.visited.add(cell)
            self.trail.append(cell)


MOVES: tuple[Cell, ...] = (Cell(-1, 0), Cell(1, 0), Cell(0, -1), Cell(0, 1))


def beyond(maze: World, cell: Cell, action: int) -> Cell | None:
    there = Cell(cell.row + MOVES[action].row, cell.column + MOVES[action].column)
    return there if 0 <= there.row < maze.rows and 0 <= there.column < maze.columns else None


def learn(q_table, state: int, action: int, reward: float, next_state: int, terminated: bool, s: Settings) -> None:
    future: float = 0.0 if terminated else s.gamma * max(q_table[next_state])
    q_table[state][action] += s.alpha * (reward + future - q_table[state][action])


def epsilon_greedy(q_row, actions: list[int], rng: np.random.Generator, s: Settings) -> int:
    if rng.random() < s.epsilon:
        return int(rng.choice(actions))
    return max(actions, key=lambda action: q_row[action])


def play_remembering(
    maze: World, q_table: NDArray[np.float64] | list[list[float]], rng: np.random.Generator, s: Settings | None = None
) -> int:
    s = s or Settings()
    memory = Memory()
    state, _ = maze.reset()
    cell = Cell(*divmod(state, maze.columns))
    memory.enter(cell)
    steps: int = 0
    over: bool = False
    while not over:
        ahead = {action: beyond(maze, cell, action) for action in range(4)}
        fresh = [a for a, there in ahead.items() if there and there not in memory.visited | memory.walls]
        if fresh:
            action = epsilon_greedy(q_table[state], fresh, rng, s)
        else:
            memory.trail.pop()
            action = next(a for a, there in ahead.items() if there == memory.trail[-1])
        next_state, reward, terminated, truncated, info = maze.step(action)
        steps += 1
        learn(q_table, state, action, reward, next_state, terminated, s)
        if info["bumped"]:
            memory.walls.add(ahead[action])
        state, cell = next_state, Cell(*divmod(next_state, maze.columns))
        memory.enter(cell)
        over = terminated or truncated
    return steps


@dataclass
class Exam:
    maze: World

    def passed(self, q_table: list[list[float]]) -> bool:
        state, info = self.maze.reset()
        terminated = truncated = False
        while not (terminated or truncated):
            state, _, terminated, truncated, info = self.maze.step(q_table[state].index(max(q_table[state])))
        return bool(terminated and not info["bumped"])


def train(maze: World, eval_maze: World, rng: np.random.Generator, max_episodes: int) -> tuple[list, int]:
    q_table: list[list[float]] = [[0.0] * 4 for _ in range(maze.rows * maze.columns)]
    exam = Exam(eval_maze)
    for episodes in range(1, max_episodes + 1):
        play_remembering(maze, q_table, rng)
        if exam.passed(q_table):
            break
    return q_table, episodes
