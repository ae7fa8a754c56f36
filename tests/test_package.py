"""The package as a whole: what importing it costs, what it offers, and the rules that hold in every file."""

import ast
import inspect
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import course_lib
from course_lib import market, study

PACKAGE = Path(course_lib.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))
# Imports run down this list, never up; modules of one row do not know each other.
ROWS = [
    ["validate", "files", "choice", "generators", "kernels"],
    ["history"],
    ["mdp"],
    ["maze"],
    ["bellman", "table_world"],
    ["q_table", "dqn", "market"],
    ["study"],
    ["plots"],
    ["explore", "checks"],
    ["classroom"],
]
ROW_OF = {module: row for row, modules in enumerate(ROWS) for module in modules}
OFFERED = [(home, name) for home in (course_lib, market, study) for name in home.__all__]
MAY_WARN = {"market/prices.py"}  # of what may be a split or a crash, which nobody can decide but the learner

each_file = pytest.mark.parametrize("path", FILES, ids=[str(path.relative_to(PACKAGE)) for path in FILES])


def run(code, **environment):
    """What a fresh Python prints that runs `code`, with no module taken from the folder it happens to run in."""
    environment = {name: value for name, value in (os.environ | environment).items() if value is not None}
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], env=environment, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def module_of(path):
    """The room that a file belongs to: its module, or the folder it is in; empty for the package's own __init__."""
    first = path.relative_to(PACKAGE).parts[0]
    return "" if first == "__init__.py" else first.removesuffix(".py")


def imported_by(path):
    """The full names of everything a file imports, anywhere in it."""
    names = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports name the package"
            names += [f"{node.module}.{alias.name}" for alias in node.names]
    return names


# --- what it offers ---------------------------------------------------------------------------------------------------


def test_importing_it_loads_no_compiler_no_network_library_and_no_plotting():
    heavy = ["torch", "seaborn", "numba", "matplotlib", "pandas", "safetensors", "tqdm", "ipywidgets"]
    loaded = run(f"import sys, course_lib; print([name for name in {heavy} if name in sys.modules])")
    assert loaded == "[]"


def test_importing_it_touches_no_global_generator_and_no_warning_filter():
    code = """
import random, warnings, gymnasium, numpy as np
before = random.getstate(), repr(np.random.get_state()), list(warnings.filters)
import course_lib
from course_lib import Maze, QAgent, market, value_iteration
QAgent(Maze(slip=0.1)).train(3), value_iteration(Maze().mdp, 0.9), Maze.random(4, 4)
prices, encoder = market.RandomWalkMarket().prices(90), market.MinMaxEncoder(5)
QAgent(market.SideEnv(prices, encoder.fit(prices["close"]), side=1)).train(3)
market.percentile(prices, market.oracle(prices))
print((random.getstate(), repr(np.random.get_state()), list(warnings.filters)) == before)
"""
    assert run(code) == "True"


@pytest.mark.parametrize(("home", "name"), OFFERED, ids=[f"{home.__name__}.{name}" for home, name in OFFERED])
def test_every_name_is_there_and_says_what_it_is(home, name):
    thing = getattr(home, name)
    if callable(thing) or inspect.ismodule(thing):
        assert len(inspect.getdoc(thing) or "") > 20
        assert not inspect.getdoc(thing).startswith(f"{name}("), "a text, not the signature a dataclass gets by itself"


CLASSES = [getattr(home, name) for home, name in OFFERED if inspect.isclass(getattr(home, name))]


@pytest.mark.parametrize("offered", CLASSES, ids=[offered.__name__ for offered in CLASSES])
def test_every_public_method_says_what_it_does(offered):
    inherited = {"reset", "step", "close"}  # as Gymnasium documents them
    ours = [kind for kind in offered.__mro__ if kind.__module__.startswith("course_lib")]
    for method, value in ((method, value) for kind in ours for method, value in vars(kind).items()):
        documented = inspect.isfunction(value) or isinstance(value, classmethod)
        if documented and not method.startswith("_") and method not in inherited:
            assert inspect.getdoc(getattr(offered, method)), f"{offered.__name__}.{method} has no docstring"


def test_dir_shows_what_there_is():
    assert set(course_lib.__all__) <= set(dir(course_lib))
    assert len(set(course_lib.__all__)) == len(course_lib.__all__)


def test_a_name_that_is_not_there_is_answered_with_those_that_are():
    with pytest.raises(AttributeError, match=r"no 'Mazes'; it has: .*Maze, .*value_iteration"):
        course_lib.Mazes  # noqa: B018


def test_gymnasium_knows_the_maze_from_the_import_on():
    assert run("import course_lib, gymnasium; print(gymnasium.make('course_lib/Maze-v0').reset(seed=0)[0])") == "0"


def test_gymnasium_knows_a_side_of_a_share_from_the_import_on():
    code = """
import course_lib, gymnasium, sys
print("pandas" in sys.modules)
from course_lib.market import MinMaxEncoder, RubberBandMarket
prices = RubberBandMarket().prices(100)
encoder = MinMaxEncoder(None).fit(prices["close"])
print(gymnasium.make("course_lib/Side-v0", prices=prices, encoder=encoder, side=1).reset(seed=0)[1]["date"])
"""
    assert run(code).splitlines() == ["False", "2000-01-03 00:00:00"]


def test_a_name_is_offered_once():
    assert not set(course_lib.__all__) & set(market.__all__) - {"action_values"}  # of a policy; of an agent in a part
    assert not set(course_lib.__all__ + market.__all__) & set(study.__all__)
    assert sorted(market.__all__) == market.__all__
    assert sorted(study.__all__) == study.__all__


# --- rules of the house -----------------------------------------------------------------------------------------------


@each_file
def test_imports_run_downwards(path):
    module = module_of(path)
    if not module:
        assert not [name for name in imported_by(path) if name.startswith("course_lib")]
        return
    assert module in ROW_OF, f"{module} has no place in the order of imports"
    for name in imported_by(path):
        if name.split(".")[0] == "course_lib" and name != "course_lib":
            other = name.split(".")[1]
            assert other == module or ROW_OF[other] < ROW_OF[module], f"{module} imports {name}"


def test_only_planning_and_learning_know_the_compiled_loops():
    users = {module_of(path) for path in FILES for name in imported_by(path) if name.startswith("course_lib.kernels")}
    assert users - {"kernels"} == {"bellman", "market", "q_table"}


def test_a_compiled_loop_calls_nothing_compiled_elsewhere():
    """numba decides by a file's date whether a stored kernel is still good, and looks at one file only."""
    own = {"numpy", "course_lib.kernels.compile.compiled", "course_lib.kernels.compile.inlined"}
    loops = [path for path in FILES if module_of(path) == "kernels" and path.stem not in ("__init__", "compile")]
    assert [path.stem for path in loops] == ["learning", "planning"]
    for path in loops:
        assert set(imported_by(path)) == own
    with_numba = [path for path in FILES if any(name.split(".")[0] == "numba" for name in imported_by(path))]
    assert with_numba == [PACKAGE / "kernels" / "compile.py"]


@each_file
def test_a_file_is_one_room(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 350


NEW_GENERATORS = {"default_rng", "Generator", "PCG64", "SeedSequence", "BitGenerator"}


@each_file
def test_no_file_uses_a_global_generator_sets_a_warning_filter_or_asserts(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        text = ast.unparse(node) if isinstance(node, ast.Attribute) else ""
        if text.startswith(("np.random.", "numpy.random.")):
            assert text.split(".")[2] in NEW_GENERATORS, f"{text} draws from the one generator that all share"
        may = {"warnings.warn"} if path.relative_to(PACKAGE).as_posix() in MAY_WARN else set()
        assert text not in {"warnings.filterwarnings", "warnings.simplefilter", "warnings.warn"} - may, text
        assert not isinstance(node, ast.Assert), f"line {getattr(node, 'lineno', 0)}: an assert is no error message"
    names = {name.split(".")[0] for name in imported_by(path)}
    assert not names & {"random", "pickle", "dill", "joblib"}, "no global generator, no files that can run code"


# --- compiled loops on disk -------------------------------------------------------------------------------------------

WORK = """
from course_lib import Maze, QAgent, value_iteration
agent = QAgent(Maze(slip=0.1))
agent.train(50)
print(agent.q_table.sum().hex(), value_iteration(Maze().mdp, 0.9).values[0].hex())
"""


def test_where_nothing_can_be_written_everything_still_computes(tmp_path):
    """Permissions stop no root, so the folders for compiled loops are made impossible: a file stands in their place."""
    shutil.copytree(PACKAGE, tmp_path / "course_lib", ignore=shutil.ignore_patterns("__pycache__"))
    for folder in ("course_lib", "course_lib/kernels"):
        (tmp_path / folder / "__pycache__").write_text("")
    nowhere = {"HOME": os.devnull, "XDG_CACHE_HOME": os.devnull, "LOCALAPPDATA": os.devnull, "NUMBA_CACHE_DIR": None}
    nowhere |= {"PYTHONPATH": str(tmp_path), "IPYTHONDIR": os.devnull}
    code = """
from numba import njit
from course_lib import kernels
print(kernels.__file__)
try:
    njit(cache=True)(kernels.sweep_policy.py_func)
except RuntimeError as error:
    print("numba:", "cannot cache" in str(error))
"""
    place, numba = run(code, **nowhere).splitlines()
    assert Path(place) == tmp_path / "course_lib" / "kernels" / "__init__.py"
    assert numba == "numba: True"
    assert run(WORK, **nowhere) == run(WORK)


def test_compiled_loops_are_kept_for_the_next_time(tmp_path):
    code = (
        WORK
        + """
from course_lib import kernels
for kernel in (kernels.q_learning, kernels.all_action_values):
    print(sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""
    )
    first = run(code, NUMBA_CACHE_DIR=str(tmp_path)).splitlines()
    second = run(code, NUMBA_CACHE_DIR=str(tmp_path)).splitlines()
    assert first[1:] == ["0 1", "0 1"]
    assert second[1:] == ["1 0", "1 0"]
    assert first[0] == second[0]


# --- the same everywhere ----------------------------------------------------------------------------------------------


def test_results_do_not_depend_on_the_hash_seed_or_the_number_of_threads():
    """To the last bit; where LAPACK solves a system, its threads round the last digits each in their own way."""
    code = """
import hashlib, gymnasium, numpy as np
from course_lib import MDP, Maze, QAgent, evaluate_policy, policy_iteration, value_iteration
digest = hashlib.sha256()
maze = Maze.random(12, 9, slip=0.2, seed=1)
solution = value_iteration(maze.mdp, 0.95)
for array in (solution.values, solution.q, solution.policy):
    digest.update(array.tobytes())
for env in (maze, gymnasium.make("FrozenLake-v1"), gymnasium.wrappers.RecordEpisodeStatistics(Maze(slip=0.1))):
    agent = QAgent(env, alpha_power=0.7, epsilon_decay=0.99)
    record = agent.train(100)
    for array in (agent.q_table, agent.visits, record.episode_return, record.episode_length):
        digest.update(array.tobytes())
print(digest.hexdigest())
print(*policy_iteration(maze.mdp, 0.95).values, *evaluate_policy(maze.mdp, np.full((108, 4), 0.25), 0.95))
"""
    threads = ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"]
    answers = [
        run(code, PYTHONHASHSEED=seed, **dict.fromkeys(threads, count)).splitlines()
        for seed, count in ("01", "11", "22")
    ]
    assert len({digest for digest, _ in answers}) == 1
    solved = [[float(number) for number in numbers.split()] for _, numbers in answers]
    assert len(solved[0]) == 2 * 108
    assert solved[1] == pytest.approx(solved[0], rel=1e-12, abs=1e-12)
    assert solved[2] == pytest.approx(solved[0], rel=1e-12, abs=1e-12)
