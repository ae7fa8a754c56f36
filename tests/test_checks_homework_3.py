"""The checks of homework 3 but for the training: what they hold for right, and what they make of mistakes."""

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from course_lib.checks import homework_3
from course_lib.checks.homework_3 import scaling_mistakes, task_1, task_2, task_3, task_5
from course_lib.checks.homework_3.arrays import ANY
from course_lib.checks.learner import arrays_in
from course_lib.checks.verdict import Outcome

MISTAKES = {
    "scales_by_what_it_may_know": [*scaling_mistakes.VALUE_MISTAKES, *scaling_mistakes.WARM_UP_MISTAKES],
    "passes_forward": task_2._MISTAKES,
    "aims_at_possible_actions": [(task_3._of_arguments(mistake), words) for mistake, words in task_3._MISTAKES],
    "stops_by_validation": task_5._MISTAKES,
}
RIGHT = dict(zip(MISTAKES, (task_1.network_inputs, task_2.q_values, task_3.targets, task_5.best_moment), strict=True))
ALL_MISTAKES = [(name, i) for name, mistakes in MISTAKES.items() for i in range(len(mistakes))]

seeds = st.integers(0, 2**32 - 1)


# --- what is right ----------------------------------------------------------------------------------------------------


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.integers(1, 8))
def test_inputs_are_what_their_definition_says(seed, k):
    rng = np.random.default_rng(seed)
    T = int(rng.integers(k + 3, 40))
    num_train = int(rng.integers(3, T + 1))
    close = task_1.closes(rng.standard_t(2, size=T - 1) * 0.1)
    returns = [np.log(close[t] / close[t - 1]) for t in range(1, T)]
    sigma = np.std([returns[t - 1] for t in range(1, num_train)])
    rows = task_1.network_inputs(close, num_train, k)
    assert rows.shape == (T, k)
    assert np.isnan(rows[:k]).all()
    for t in range(k, T):
        for j in range(k):
            value = returns[t - k + j] / sigma
            assert rows[t, j] == pytest.approx(max(-5, min(5, value)))


def test_inputs_do_not_depend_on_the_currency():
    close = task_1.closes(task_1.calm(np.random.default_rng(0), 30, 0.2))
    np.testing.assert_allclose(task_1.network_inputs(close, 20, 3), task_1.network_inputs(7 * close, 20, 3))


@settings(derandomize=True, deadline=None, max_examples=50)
@given(seeds, st.lists(st.integers(1, 6), min_size=2, max_size=6))
def test_the_forward_pass_is_that_of_torch(seed, sizes):
    torch = pytest.importorskip("torch")
    rng = np.random.default_rng(seed)
    layers, x = task_2.network(rng, sizes), rng.normal(size=(4, sizes[0]))
    modules = []
    for weights, biases in layers:
        linear = torch.nn.Linear(*weights.shape, dtype=torch.float64)
        linear.load_state_dict({"weight": torch.tensor(weights.T), "bias": torch.tensor(biases)})
        modules += [linear, torch.nn.ReLU()]
    expected = torch.nn.Sequential(*modules[:-1])(torch.tensor(x)).detach().numpy()
    np.testing.assert_allclose(task_2.q_values(x, layers), expected, atol=1e-12)


@settings(derandomize=True, deadline=None, max_examples=100)
@given(seeds, st.integers(1, 20), st.integers(1, 5), st.sampled_from([0.0, 0.5, 0.9, 1.0]))
def test_targets_are_what_their_definition_says(seed, B, A, gamma):
    case = task_3._batch(np.random.default_rng(seed), B, A, gamma, ends=0.3, impossible=0.4, lure=2)
    rewards, terminated, possible, online, target, _ = case.arguments
    y = task_3.targets(*case.arguments)
    for i in range(B):
        assert possible[i].any()
        best = max((a for a in range(A) if possible[i, a]), key=lambda a: online[i, a])
        assert y[i] == pytest.approx(rewards[i] if terminated[i] else rewards[i] + gamma * target[i, best])


@settings(derandomize=True, deadline=None, max_examples=200)
@given(st.lists(st.integers(-5, 5), min_size=1, max_size=15), st.integers(1, 6))
def test_a_training_stops_where_its_definition_says(scores, patience):
    ages = [stage - scores.index(max(scores[: stage + 1])) for stage in range(len(scores))]
    old = [stage for stage, age in enumerate(ages) if age >= patience]
    stop = old[0] if old else len(scores) - 1
    best = scores.index(max(scores[: stop + 1]))
    assert tuple(task_5.best_moment(np.array(scores, float), patience)) == (stop, best)


# --- mistakes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "i"), ALL_MISTAKES, ids=[f"{name}-{i}" for name, i in ALL_MISTAKES])
def test_each_mistake_meets_its_own_words(name, i):
    mistake, words = MISTAKES[name][i]
    check = getattr(homework_3, name)

    def function(*arguments):
        with np.errstate(all="ignore"):
            result = np.array(mistake(*arguments), float)
        result[result == ANY] = 0.25
        return result

    for seed in range(5):
        verdict = check(function, seed=seed)
        found = [row.likely for row in verdict.rows if row.outcome is Outcome.NOT_YET]
        assert found[0], verdict
        assert words in found, verdict
        assert "check itself" not in repr(verdict)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        (task_5._best_of_all_first, "go through the stages one by one"),
        (task_5._best_of_all_first_and_no_end, "go through the stages one by one"),
        (task_5._falls_in_a_row, "counts falls in a row"),
        (task_5._never_stops, "never stops before the last stage"),
    ],
)
def test_mistakes_about_the_stop_are_not_taken_for_one_another(mistake, words, seed):
    rows = homework_3.stops_by_validation(mistake, seed=seed).rows
    likely = [row.likely for row in rows if row.outcome is Outcome.NOT_YET]
    assert likely
    assert all(words in each for each in likely), likely


@pytest.mark.parametrize("gamma", [0.9, 0.95])
def test_a_gamma_of_its_own_is_named_wherever_it_is_wrong(gamma):
    def targets(*arguments):
        return task_3.targets(*arguments[:-1], gamma)

    for seed in range(10):
        rows = homework_3.aims_at_possible_actions(targets, seed=seed).rows
        likely = [row.likely for row in rows if row.outcome is Outcome.NOT_YET]
        assert len(likely) == 3
        assert all(f"a number of its own, {gamma}:" in words for words in likely)


def test_words_for_a_mistake_read_well():
    for name, mistakes in MISTAKES.items():
        for _, words in mistakes:
            assert words.endswith("."), name
            assert words.count("`") % 2 == 0, words
            assert "*" not in re.sub(r"`[^`]*`", "", words), words


def test_where_two_mistakes_are_made_no_single_one_is_named():
    def bent(close, num_train, k):
        return task_1.network_inputs(close, num_train, k)[:, ::-1] * 2

    verdict = homework_3.scales_by_what_it_may_know(bent)
    assert verdict.rows[0].likely == ""
    assert "is right" in verdict.rows[0].came


@pytest.mark.parametrize("seed", range(50))
def test_what_is_right_passes_with_any_seed(seed):
    for name, right in RIGHT.items():
        assert getattr(homework_3, name)(right, seed=seed).passed


@pytest.mark.parametrize("name", MISTAKES)
def test_another_seed_means_other_data(name):
    seen = []

    def remember(*arguments):
        seen.append([array.tobytes() for array in arguments if isinstance(array, np.ndarray)])
        return 0

    for seed in (0, 0, 1):
        getattr(homework_3, name)(remember, seed=seed)
    third = len(seen) // 3
    assert seen[:third] == seen[third : 2 * third] != seen[2 * third :]


@pytest.mark.parametrize("name", MISTAKES)
def test_whoever_writes_into_what_was_given_loses_one_point(name):
    for i in range(sum(1 for _ in given_arrays(name))):

        def function(*arguments, i=i):
            result = RIGHT[name](*arguments)
            given = list(arrays_in(arguments))
            given[i % len(given)].flat[0] = not given[i % len(given)].flat[0]
            return result

        verdict = getattr(homework_3, name)(function)
        assert verdict.points == verdict.max_points - 1
        assert "is not what it was" in verdict.rows[-1].came


def given_arrays(name):
    """The arrays that a check passes in its last call."""
    seen = []

    def remember(*arguments):
        seen.append(arguments)
        return RIGHT[name](*arguments)

    getattr(homework_3, name)(remember)
    return arrays_in(seen[-1])


def test_impossible_actions_lure_and_all_may_be_bad():
    seen = []

    def remember(*arguments):
        seen.append(arguments)
        return task_3.targets(*arguments)

    assert homework_3.aims_at_possible_actions(remember).passed
    for _, _, possible, online, target, _ in seen[4:6]:
        for values in (online, target):
            assert np.mean(values[~possible].min() > values[possible]) > 0.9
    for _, _, possible, online, target, _ in seen[6:8]:
        assert not possible.all()
        assert max(online.max(), target.max()) < 0


def test_rows_that_know_the_future_are_told_from_those_that_share_something_with_it():
    def leaks(close, num_train, k):
        rows = task_1.network_inputs(close, num_train, k)
        return rows * np.std(close)

    def peeks(close, num_train, k):
        rows = task_1.network_inputs(close, num_train, k)
        return np.concatenate([rows[1:], rows[-1:]])

    def peeks_now_and_then(close, num_train, k):
        rows = task_1.network_inputs(close, num_train, k)
        rows[k + 2] += close[-1]
        return rows

    def sees_nothing(close, _, k):
        return np.ones((len(close), k))

    def lags(close, num_train, k):
        rows = task_1.network_inputs(close, num_train, k)
        return np.concatenate([rows[:1], rows[:-1]])

    def writes(close, num_train, k):
        rows = task_1.network_inputs(close, num_train, k)
        close[0] = 1
        return rows

    words = {
        leaks: "something that all rows share",
        peeks: "reach beyond their own bar",
        peeks_now_and_then: "knows of closes that come",
        sees_nothing: "do not hold the returns",
        lags: "do not hold the returns",
        writes: "writes into `close`",
    }
    for function, likely in words.items():
        assert likely in homework_3.scales_by_what_it_may_know(function).rows[-1].likely


# --- what is shown beside a finding -----------------------------------------------------------------------------------


def test_a_step_and_its_scores_fit_a_page():
    rng = np.random.default_rng(0)
    case = task_3._batch(rng, 30, 5, 0.95, ends=0.3, impossible=0.4, lure=100)
    texts = [case.shown((29,)), task_5._shown(-100 * rng.random(23)), task_5._shown(np.ones(1))]
    for text in texts:
        assert max(map(len, text.split("\n"))) <= 80
    assert texts[0].startswith("step 29 of the batch: reward ")
    assert [line.split()[0] for line in texts[1].split("\n")] == ["stage", "score"] * 3
    assert texts[2].split() == ["stage", "0", "score", "1.00"]
