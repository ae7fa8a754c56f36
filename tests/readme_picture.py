"""Draw the picture of README.md from the real thing: python tests/readme_picture.py"""

from pathlib import Path

from course_lib import Maze, plots, value_iteration

PLACE = Path(__file__).resolve().parent.parent / "notebooks" / "pictures" / "maze.png"


def picture():
    maze = Maze(wall_reward=0.0, wall_ends_episode=False)
    solution = value_iteration(maze.mdp, gamma=0.9)
    return plots.values(maze, solution.values, q=solution.q, title="What every cell is worth, and what to do there")


if __name__ == "__main__":
    PLACE.write_bytes(picture().png())
