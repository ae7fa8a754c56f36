"""Task 3, what the network is trained towards: double deep Q-learning's targets, from possible actions alone."""

from dataclasses import dataclass, replace

import numpy as np

from course_lib.checks.check import Check, Trial
from course_lib.checks.homework_3.arrays import MISTAKES_WITH_ARRAYS, Case, check_arrays

_WANTED = "one number for each of the B steps, shape (B,)"
_NAMES = ("rewards", "terminated", "next_possible", "next_online", "next_target", "gamma")


def targets(rewards, terminated, next_possible, next_online, next_target, gamma):
    """float[B]: r + gamma q'(s', argmax over possible a of q(s', a)); r where terminated."""
    batch = Batch(rewards, terminated, next_possible, next_online, next_target, gamma)
    return batch.aim(batch.after)


@dataclass(frozen=True)
class Batch:
    """B steps, as `targets` is given them."""

    rewards: np.ndarray
    terminated: np.ndarray
    possible: np.ndarray
    online: np.ndarray
    target: np.ndarray
    gamma: float

    def aim(self, after):
        """The target, r + gamma * after, or r where terminated. `after` is the value of the next state, float[B]."""
        return self.rewards + np.where(self.terminated, 0.0, self.gamma * after)

    def masked(self, values):
        """Values float[B, A] of which the impossible ones never win."""
        return np.where(self.possible, values, -np.inf)

    @property
    def after(self):
        """The right value of the next state, of each step."""
        return chosen(self.target, self.masked(self.online).argmax(axis=1))


def chosen(values, actions):
    """One value of each row."""
    return values[np.arange(len(values)), actions]


_MASK = (
    "impossible actions are among those that the best one is chosen from: "
    "`np.where(next_possible, next_online, -np.inf)`."
)
_PLAIN = "your target is not a double one: the online network chooses the action, the target network says its value."
_ONE_FOR_ALL = "the best action is looked for once for the whole batch: each row has its own, `argmax(axis=1)`."

_MISTAKES = [
    (lambda b: b.aim(chosen(b.target, b.online.argmax(axis=1))), _MASK),
    (
        lambda b: b.aim(chosen(b.target, (b.online * b.possible).argmax(axis=1))),
        "impossible actions count as 0, which beats every negative value: put `-np.inf` in their place, not 0.",
    ),
    (lambda b: b.aim(b.masked(b.target).max(axis=1)), _PLAIN),
    (lambda b: b.aim(b.target.max(axis=1)), f"{_PLAIN} And `next_possible` is not used."),
    (
        lambda b: b.aim(b.masked(b.online).max(axis=1)),
        "the value is that of the online network. It only chooses; the target network says what its choice is worth.",
    ),
    (lambda b: b.aim(b.online.max(axis=1)), "neither the target network nor `next_possible` is used."),
    (
        lambda b: b.aim(chosen(b.online, b.masked(b.target).argmax(axis=1))),
        "the two networks are exchanged: the online network chooses, the target network says what that is worth.",
    ),
    (
        lambda b: b.rewards + b.gamma * b.after,
        "your target looks beyond the end: where `terminated` is true nothing follows, and the target is r.",
    ),
    (
        lambda b: b.rewards + np.where(b.terminated, b.gamma * b.after, 0),
        "`terminated` is used the wrong way round: the target is r where it is true.",
    ),
    (
        lambda b: np.where(b.terminated, 0, b.rewards + b.gamma * b.after),
        "your target is 0 where `terminated` is true: the last reward still counts.",
    ),
    (
        lambda b: b.rewards + np.where(b.terminated, 0, b.after),
        "gamma is missing: r + gamma · the value of the next state.",
    ),
    (
        lambda b: b.gamma * (b.rewards + np.where(b.terminated, 0, b.after)),
        "gamma multiplies the reward as well: r + gamma · the value of the next state.",
    ),
    (
        lambda b: np.where(b.terminated, 0, b.gamma * b.after),
        "the reward is missing: r + gamma · the value of the next state.",
    ),
    (lambda b: b.aim(b.target[:, b.masked(b.online).max(axis=0).argmax()]), _ONE_FOR_ALL),
    (lambda b: b.aim(b.target[:, b.masked(b.online).mean(axis=0).argmax()]), _ONE_FOR_ALL),
    (lambda b: b.aim(b.masked(b.target).max()), _ONE_FOR_ALL),
    (
        lambda b: b.aim(chosen(b.target, np.where(b.possible, b.online, np.inf).argmin(axis=1))),
        "the lowest value is looked for, not the highest.",
    ),
    (
        lambda b: b.aim(chosen(b.target, np.where(b.possible, -np.inf, b.online).argmax(axis=1))),
        "the mask is used the wrong way round: an action is possible where `next_possible` is true.",
    ),
    *[
        (
            lambda b, gamma=gamma: replace(b, gamma=gamma).aim(b.after),
            f"your gamma is a number of its own, {gamma}: use the argument `gamma`.",
        )
        for gamma in (0.5, 0.8, 0.9, 0.95, 0.98, 0.99)
    ],
]


def _batch(rng, B, A, gamma, *, ends=0.0, impossible=0.0, lure=0.0, level=0.0):
    """A case: B steps, of which a share has ended, with a share of impossible actions that look better by `lure`."""
    possible = rng.random((B, A)) >= impossible
    possible[np.arange(B), rng.integers(A, size=B)] = True
    online, target = (rng.normal(size=(B, A)) + level for _ in range(2))
    if level:
        online, target = -abs(online), -abs(target)
    online[~possible] += lure
    target[~possible] += lure
    over = rng.random(B) < ends
    if ends and B > 1:
        over[:2] = True, False
    given = rng.normal(size=B), over, possible, online, target, gamma
    return Case(given, f"gamma = {gamma:g}", lambda index: _step(index[0], *given))


def _step(i, rewards, terminated, next_possible, next_online, next_target, gamma):
    """One step of a batch as text."""
    rows = [
        ("action", [str(action) for action in range(next_online.shape[1])]),
        ("next_possible", [str(bool(possible)) for possible in next_possible[i]]),
        ("next_online", [f"{value:.2f}" for value in next_online[i]]),
        ("next_target", [f"{value:.2f}" for value in next_target[i]]),
    ]
    head = f"step {i} of the batch: reward {rewards[i]:.4g}, terminated {bool(terminated[i])}, gamma {gamma:g}"
    return "\n".join([head] + [f"{name:14}" + "".join(f"{word:>8}" for word in words) for name, words in rows])


def _aims_with_both_networks(call, seed):
    rng = np.random.default_rng(seed)
    _check(call, [_batch(rng, B, A, 0.9) for B, A in ((12, 3), (20, 5))])


def _stops_at_the_end(call, seed):
    rng = np.random.default_rng(seed + 10)
    _check(call, [_batch(rng, B, A, 0.9, ends=0.5) for B, A in ((12, 3), (20, 5))])


def _leaves_out_what_is_impossible(call, seed):
    rng = np.random.default_rng(seed + 20)
    _check(call, [_batch(rng, B, A, 0.95, ends=0.2, impossible=0.4, lure=5) for B, A in ((20, 3), (20, 5))])


def _leaves_it_out_where_all_is_bad(call, seed):
    rng = np.random.default_rng(seed + 30)
    _check(call, [_batch(rng, B, A, 0.95, ends=0.2, impossible=0.4, level=-3) for B, A in ((20, 3), (20, 5))])


def _takes_any_batch_and_gamma(call, seed):
    rng = np.random.default_rng(seed + 40)
    sizes = (20, 3, 0.5), (1, 3, 0.99), (30, 4, 1.0)
    _check(call, [_batch(rng, *size, ends=0.3, impossible=0.3) for size in sizes], _NAMES)


def _check(call, cases, names=()):
    mistakes = [(_of_arguments(mistake), words) for mistake, words in _MISTAKES]
    check_arrays(call, cases, targets, mistakes, _WANTED, names=names)


def _of_arguments(function):
    return lambda *arguments: function(Batch(*arguments))


aims_at_possible_actions = Check(
    "aims_at_possible_actions",
    title="Task 3, the targets",
    usage="targets(rewards, terminated, next_possible, next_online, next_target, gamma)",
    trials=[
        Trial(
            "batches without an end, every action possible",
            "r + gamma · `next_target` of the action that looks best in `next_online`",
            _aims_with_both_networks,
        ),
        Trial("batches in which steps have terminated", "r alone at these steps", _stops_at_the_end),
        Trial(
            "impossible actions that look splendid",
            "the best of the possible ones is taken",
            _leaves_out_what_is_impossible,
        ),
        Trial(
            "batches in which all values are negative",
            "the best of the possible ones here too",
            _leaves_it_out_where_all_is_bad,
        ),
        Trial(
            "other values of gamma, and a batch of one step",
            "the same rule, and all arrays as they were",
            _takes_any_batch_and_gamma,
        ),
    ],
    likely=MISTAKES_WITH_ARRAYS,
    hints=[
        "Two questions, two networks. Which action? The one with the highest value in `next_online`, among the "
        "possible ones. What is it worth? That is said by `next_target`.",
        "An impossible action must never win, also where all others are negative: "
        "`np.where(next_possible, next_online, -np.inf)` leaves `next_online` as it is.",
        "`best = ….argmax(axis=1)` has one action for each row, and `next_target[np.arange(len(best)), best]` the "
        "value of each.",
        "Where `terminated` is true nothing follows: `rewards + np.where(terminated, 0, gamma * value)`.",
    ],
)
