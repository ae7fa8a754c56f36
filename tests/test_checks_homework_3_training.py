"""The check of homework 3's training: memories of worlds whose values are known, and mistakes told apart."""

import subprocess
import sys
import time

import numpy as np
import pytest

from course_lib.checks.check import Call, NotYet
from course_lib.checks.here import Here
from course_lib.checks.homework_3 import memories
from course_lib.checks.homework_3.task_4 import learns_with_a_target_that_holds_still as check
from course_lib.checks.homework_3.training import one_thread, shown, trained
from course_lib.checks.verdict import Outcome

MEMORIES = {
    "many states": memories.many_states,
    "a chain": lambda seed: memories.chains(seed, [2.0], loss=-0.5),
    "two chains": lambda seed: memories.chains(seed, [2.0, -2.0], loss=-3.0, S=3),
    "trades": memories.costly_trades,
}


def learner(
    *,
    copies=True,
    gamma=0.9,
    ends=True,
    masks=lambda q, possible: np.where(possible, q, -np.inf),
    last=lambda q: q,
    batch=None,
    lags=False,
    says=lambda values: values,
    takes=lambda steps: steps,
    seed_of=lambda seed: seed,
):
    """A `learn` with a table in the network's place, which learns all that its target holds; and mistakes to order.

    copies  False: the target is never copied; "no copy": it is the network itself; "back": the network becomes it;
            "no copy later": it becomes the network itself when the first copy after the beginning is due
    batch   how many of the transitions it ever looks at
    lags    it returns what the target says
    """

    def learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, seed):
        rng = np.random.default_rng(seed_of(seed))
        rows, ids = np.unique(np.concatenate([observations, next_observations]), axis=0, return_inverse=True)
        ids, next_ids = np.split(ids, 2)
        q = rng.normal(scale=0.1, size=(len(rows), next_possible.shape[1]))
        old, steps, seen = q.copy(), takes(steps), slice(batch)
        if steps < 100:
            return says(q[ids]) + rng.normal(scale=0.01)
        for step in range(0, steps, 20):  # twenty steps are enough to learn one target
            if step % copy_every == 0 and copies is True:
                old = q.copy()
            elif step % copy_every == 0 and copies == "back":
                q = old.copy()
            if copies == "no copy" or (copies == "no copy later" and step >= copy_every):
                old = q.copy()
            best = masks(q[next_ids], next_possible).argmax(axis=1)
            after = gamma * old[next_ids, best]
            if step < steps - 20 or copies != "back":
                q[ids[seen], actions[seen]] = last(rewards + np.where(terminated & ends, 0, after))[seen]
        return says((old if lags else q)[ids])

    return learn


def rows_of(function, seed=0):
    verdict = check(function, seed=seed)
    assert "check itself" not in repr(verdict)
    return verdict.rows


def likely_of(function, seed=0):
    return next(row.likely for row in rows_of(function, seed) if row.outcome is Outcome.NOT_YET)


# --- worlds of known values -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("make", MEMORIES.values(), ids=MEMORIES.keys())
@pytest.mark.parametrize("seed", range(5))
def test_a_memory_holds_every_possible_step_several_times(make, seed):
    memory = make(seed)
    observations, actions, rewards, next_observations, next_possible, terminated = memory.transitions
    N, (S, A) = len(memory.states), memory.exact.shape
    assert N == len(observations) == len(actions) == len(rewards) == len(next_observations) == len(terminated)
    assert next_possible.shape == (N, A)
    assert next_possible.dtype == terminated.dtype == bool
    assert N >= 128, "a batch of 64 can be drawn without one twice"
    assert next_possible.any(axis=1).all()
    counts = np.zeros((S, A), int)
    np.add.at(counts, (memory.states, actions), 1)
    assert ((counts > 0) == ~np.isnan(memory.exact)).all()
    assert counts.max() == counts[counts > 0].min() >= 2
    for state in range(S):
        assert len(np.unique(observations[memory.states == state], axis=0)) == 1
    seen = np.unique(observations, axis=0)
    assert len(seen) == S
    differences = (seen[:, None] != seen).sum(axis=2)
    assert differences[~np.eye(S, dtype=bool)].min() >= seen.shape[1] / 4, "they are told apart easily"
    assert {tuple(row) for row in next_observations} <= {tuple(row) for row in observations}


@pytest.mark.parametrize("make", MEMORIES.values(), ids=MEMORIES.keys())
def test_exact_values_solve_the_equation_of_bellman(make):
    memory = make(3)
    _, actions, rewards, next_observations, next_possible, terminated = memory.transitions
    keys = {tuple(row): state for row, state in zip(memory.transitions[0], memory.states, strict=True)}
    for i, state in enumerate(memory.states):
        after = memory.exact[keys[tuple(next_observations[i])]]
        assert (np.isnan(after) == ~next_possible[i]).all()
        value = rewards[i] + (0 if terminated[i] else 0.9 * np.nanmax(after))
        assert memory.exact[state, actions[i]] == pytest.approx(value)


def test_values_along_a_chain_are_powers_of_gamma():
    exact = MEMORIES["a chain"](0).exact
    np.testing.assert_allclose(exact[:, 0], 2 * 0.9 ** np.arange(4, -1, -1))
    np.testing.assert_allclose(exact[:, 1], -0.5)


def test_many_states_have_more_pairs_than_a_batch_and_a_known_share_of_losses():
    for seed in range(10):
        exact = memories.many_states(seed).exact
        assert exact.size > 64
        assert np.mean(exact < 0) == pytest.approx(0.4)
        assert (abs(exact) >= 0.5).all()


def test_values_are_put_in_the_order_of_states():
    memory = memories.costly_trades(0)
    np.testing.assert_array_equal(memory.by_state(memory.exact[memory.states]), memory.exact)


# --- right trainings, and mistaken ones -------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(30))
def test_whoever_comes_to_the_right_values_passes(seed):
    assert check(learner(), seed=seed).passed


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(
    ("mistake", "rows", "words"),
    [
        ({"copies": False}, [1, 0, 0, 1, 1], "does not travel back"),
        ({"copies": "no copy"}, [1, 1, 1, 0, 1], "`target = network` is a second name"),
        ({"copies": "no copy later"}, [1, 1, 1, 0, 1], "makes a second name, no copy"),
        ({"copies": "back"}, [1, 0, 0, 1, 1], "or the other way round"),
        ({"gamma": 0.0}, [1, 0, 0, 1, 1], "does not travel back"),
        ({"gamma": 1.0}, [1, 0, 1, 1, 1], "gamma is missing"),
        ({"ends": False}, [1, 0, 0, 1, 1], "look beyond the end"),
        ({"masks": lambda q, _: q}, [1, 1, 0, 1, 1], "impossible in the next state"),
        ({"masks": lambda q, possible: q * possible}, [1, 1, 0, 1, 1], "impossible in the next state"),
        ({"last": lambda q: np.maximum(q, 0)}, [0, 0, 0, 1, 1], "ReLU stands after the last layer"),
        ({"last": np.tanh}, [1, 0, 0, 0, 1], "tanh at the end"),
        ({"batch": 64}, [0, 1, None, 1, 1], "a part of the memory"),
        ({"takes": lambda _: 300}, [1, 1, 1, 1, 0], "another number of steps"),
        ({"takes": lambda _: 5}, [0, 0, 0, 0, 1], "not trained at all"),
        ({"seed_of": lambda _: 7}, [1, 1, 1, 1, 0], "does not use `seed`"),
        ({"seed_of": lambda _: time.perf_counter_ns()}, [1, 1, 1, 1, 0], "does not decide all of the chance"),
        ({"lags": True}, [0, 1, 0, 0, 1], "lag behind"),
        ({"says": lambda values: values.max(axis=1)}, [0] * 5, "one value for each observation"),
        ({"says": lambda values: values[:64]}, [0] * 5, "the values of a batch"),
        ({"says": lambda values: values.T}, [0] * 5, "rows and columns are exchanged"),
        ({"says": lambda values: values - np.inf}, [0] * 5, "grow without end"),
        ({"last": lambda q: 0 * q + q.mean()}, [0, 0, 0, 0, 1], "about the same"),
        ({"says": lambda values: values[::-1]}, [0] * 5, "in another order"),
        ({"last": lambda q: -q}, [0, 0, 0, 0, 1], "something else than the rewards"),
        ({"says": lambda values: values / 2}, [0, 0, 0, 1, 1], "too little in so many steps"),
        ({"says": lambda values: values / 2}, [0, 0, 0, 1, 1], "`optimizer.zero_grad()` missing"),
    ],
)
def test_mistakes_are_told_apart(mistake, rows, words, seed):
    found = rows_of(learner(**mistake), seed)
    likely = next(row.likely for row in found if row.outcome is Outcome.NOT_YET)
    assert words in likely
    for row, passes in zip(found, rows, strict=True):
        assert passes in (None, row.outcome is Outcome.PASSED), row


def test_words_for_what_lies_ahead_wait_for_the_first_row():
    rows = rows_of(learner(last=lambda q: 0 * q))
    assert all("mend the first check first" in row.likely for row in rows[1:4])
    assert "targets are others" in likely_of(learner(gamma=0.75))


@pytest.mark.parametrize(
    ("words", "likely"),
    [
        ("Index tensor must have the same number of dimensions as input tensor", "as a column"),
        ("gather(): Expected dtype int64 for index", "an index is no whole number"),
        ("mat1 and mat2 shapes cannot be multiplied (64x24 and 9x32)", "does not fit these worlds"),
        ("mat1 and mat2 must have the same dtype, but got Double and Float", "numbers of two kinds"),
        ("Found dtype Double but expected Float", "numbers of two kinds"),
        ("Can't call numpy() on Tensor that requires grad.", "still carries its gradient"),
        ("Boolean value of Tensor with more than one value is ambiguous", "asked of a whole array"),
        ("Subtraction, the `-` operator, with a bool tensor is not supported.", "`~terminated`"),
        ("something else", ""),
    ],
)
def test_what_torch_raises_has_a_likely_cause(words, likely):
    def learn(*_):
        raise RuntimeError(words)

    row = rows_of(learn)[0]
    assert likely in row.likely
    assert bool(likely) == bool(row.likely)


def test_the_words_are_those_that_torch_has():
    torch = pytest.importorskip("torch")
    single, double, batch = (
        torch.ones(64, 3),
        torch.ones(64, 3, dtype=torch.float64),
        torch.zeros(64, dtype=torch.int64),
    )
    network = torch.nn.Linear(3, 2)
    mistakes = {
        "as a column": lambda: single.gather(1, batch),
        "an index is no whole number": lambda: single.gather(1, batch.float()[:, None]),
        "does not fit these worlds": lambda: network(torch.ones(64, 4)),
        "numbers of two kinds": lambda: network(double),
        "still carries its gradient": lambda: network(single).numpy(),
        "asked of a whole array": lambda: 1 if batch else 0,
        "`~terminated`": lambda: 1 - (batch == 0),
    }
    for likely, mistake in mistakes.items():
        row = rows_of(lambda *_, mistake=mistake: mistake())[0]
        assert likely in row.likely, row


# --- what is called, and shown ----------------------------------------------------------------------------------------


def test_torch_has_one_thread_in_a_call_and_as_many_as_before_after_it():
    torch = pytest.importorskip("torch")
    before, seen = torch.get_num_threads(), []
    torch.set_num_threads(3)
    try:

        def learn(*_):
            seen.append(torch.get_num_threads())
            raise ValueError

        check(learn)
        assert set(seen) == {1}
        assert torch.get_num_threads() == 3
        with one_thread():
            torch.set_num_threads(2)
        assert torch.get_num_threads() == 3
    finally:
        torch.set_num_threads(before)


def test_a_judge_needs_no_torch():
    code = """
import sys
from course_lib.checks import homework_3
for name in homework_3.__all__:
    getattr(homework_3, name)(lambda *_: 0)
print("torch" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout == "False\n", done.stderr


def test_values_beside_exact_ones_fit_a_page():
    memory = memories.costly_trades(0)
    text = shown(memory, -100 - memory.exact, (0, 6, 11), ["hold", "open", "close"])
    lines = text.split("\n")
    assert max(map(len, lines)) <= 80
    assert lines[0].split() == ["state", "hold", "open", "close"]
    assert lines[2].split()[:2] == ["0", "-99.00"]
    assert lines[3].split()[4] == "–"


def test_a_training_is_judged_by_a_row_of_each_state():
    memory = memories.costly_trades(1)
    given = []

    def learn(*arguments):
        given.append(arguments)
        return memory.exact[memory.states].tolist()

    exact = np.nan_to_num(memory.exact)
    call = Call(Here(lambda *_: exact[memory.states].tolist()), 5.0)
    np.testing.assert_array_equal(trained(call, memory, steps=7, copy_every=8, seed=9), exact)
    with pytest.raises(NotYet, match="infinite or NaN"):
        trained(Call(Here(learn), 5.0), memory, steps=7, copy_every=8, seed=9)
    assert given[0][6:] == (7, 8, 9)
