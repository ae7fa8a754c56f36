"""Task 4, deep Q-learning from a memory: replay, a target network that holds still, possible actions alone.

A training is judged by the values that it leads to, in small decision processes whose exact values are known. The
limits are far from what a right training misses by, and from what the mistakes that are named lead to.
"""

import numpy as np

from course_lib.checks.check import Check, NotYet, Trial
from course_lib.checks.homework_3.arrays import MISTAKES_WITH_ARRAYS
from course_lib.checks.homework_3.memories import chains, costly_trades, many_states
from course_lib.checks.homework_3.training import shown, trained

_NEVER = 10_000  # a `copy_every` that is longer than any training here
_CLOSE, _CLOSE_AHEAD = 0.3, 0.25  # mean errors, of rewards that are about 1 in size and of values that lie ahead
_FIRST_THINGS_FIRST = (
    "your network does not even learn the reward of a single step, which is what the first check looks at: mend the "
    "first check first."
)
_ZERO_GRAD = "Is `optimizer.zero_grad()` missing? Without it the gradients of all steps add up."
_TOO_SLOW = (
    f"your network learns too little in so many steps. {_ZERO_GRAD} Does each step take one `optimizer.step()`? And is "
    "the learning rate of Adam 0.001 to 0.003?"
)


def _mean_error(values, exact):
    return float(np.nanmean(abs(values - exact)))


def _likely_of_the_end(values):
    """What may stand after the last layer, if the values show that something does."""
    if values.min() >= 0 and np.allclose(values.sum(axis=1), 1, atol=1e-3):
        return "there is a softmax at the end of your network. It makes probabilities; values need none."
    if values.min() >= 0 and values.max() > 0 and np.mean(values == 0) > 0.1:
        return "ReLU stands after the last layer of your network: the values of bad actions cannot be negative then."
    if 0.9 < abs(values).max() <= 1:
        return "there is a tanh at the end of your network: no value can be beyond −1 and 1."
    return ""


def _learns_what_actions_pay(call, seed):
    memory = many_states(seed)
    values = trained(call, memory, steps=300, copy_every=_NEVER, seed=seed)
    error = _mean_error(values, memory.exact)
    if error < _CLOSE:
        call.kept["learns"] = True
        return
    came = f"values that are off by {error:.2f} on average"
    likely = _likely_of_the_end(values) or _why_not_learned(call, memory, values, seed)
    raise NotYet(came, likely, shown(memory, values, range(6), ["hold", "open", "close"]))


def _why_not_learned(call, memory, values, seed):
    """Which mistake it looks like, where every step was the last one and the reward is all there is to learn."""
    exact, known = memory.exact, abs(values - memory.exact) < 0.1
    first = trained(call, memory, steps=1, copy_every=_NEVER, seed=seed)
    if np.allclose(values, first, atol=0.02):
        if _mean_error(trained(call, memory, steps=300, copy_every=1, seed=seed), exact) < _CLOSE:
            return (
                "your function returns the values of the target network, which lag behind: ask the one that is trained."
            )
        return (
            "your network is not trained at all. Each of the `steps` needs `optimizer.zero_grad()`, "
            "`loss.backward()` and `optimizer.step()`, and the optimizer the parameters of this network."
        )
    if values.std() < 0.1:
        return (
            "all values are about the same, as if rewards were no matter of states and actions. Does your loss compare "
            "shape [64, 1] with shape [64]? Torch makes a table of 64 × 64 of that: `.squeeze(1)`. Or do the rows of a "
            "batch come from different transitions?"
        )
    if np.mean(values.std(axis=1)) < 0.2 * np.mean(values.std(axis=0)):
        return (
            "all actions of a state are trained towards the same target: it belongs to the action that was taken, "
            "`network(x).gather(1, actions[:, None]).squeeze(1)`."
        )
    if 0.2 < known.mean() < 0.8 and abs(values - exact)[~known].mean() > 0.5:
        return (
            "your network knows a part of the memory well, and the rest not at all: draw a new batch for each step, "
            "from all N transitions."
        )
    if np.corrcoef((values - first).ravel(), (exact - first).ravel())[0, 1] > 0.4:
        return _TOO_SLOW
    return f"your network learns something else than the rewards of the actions taken. {_ZERO_GRAD}"


def _learns_what_lies_ahead(call, seed):
    memory = chains(seed, [2.0], loss=-0.5)
    values = trained(call, memory, steps=301, copy_every=20, seed=seed)  # a copy just before the end
    errors = abs(values - memory.exact).mean(axis=0)
    if errors.max() < _CLOSE_AHEAD:
        call.kept["looks ahead"] = True
        return
    worst = int(errors.argmax())
    came = f"values of {('going on', 'leaving')[worst]} that are off by {errors[worst]:.2f} on average"
    likely = _FIRST_THINGS_FIRST
    if call.kept.get("learns"):
        likely = _likely_of_the_end(values) or _why_not_ahead(*values.T, *memory.exact.T)
    raise NotYet(came, likely, shown(memory, values, range(5), ["go on", "leave"]))


def _why_not_ahead(go_on, leave, exact, _):
    if go_on[-1] < exact[-1] - 0.6:
        return (
            "not even the last reward stays learned. Is the network copied to the target, "
            "`target.load_state_dict(network.state_dict())`, or the other way round?"
        )
    if leave.mean() > 0 or go_on.max() > 3:
        return "your targets look beyond the end: where `terminated` is true nothing follows, and the target is r."
    if abs(go_on - go_on[-1]).mean() < 0.2:
        return "gamma is missing from your targets: a reward one step away is worth gamma times as much."
    if go_on[:-2].mean() < exact[:-2].mean() / 2:
        return (
            "the reward does not travel back. Is the target network made anew from the network every `copy_every` "
            "steps, and is gamma · the value of the next state added to the reward?"
        )
    return "your targets are others than those of task 3, or the target network is copied too seldom."


def _leaves_out_what_is_impossible(call, seed):
    memory = costly_trades(seed)
    values = trained(call, memory, steps=200, copy_every=50, seed=seed)
    errors = np.nanmean(abs(values - memory.exact), axis=0)
    if errors.max() < _CLOSE_AHEAD:
        return
    worst, names = int(errors.argmax()), ["hold", "open", "close"]
    came = f"values of {names[worst]}, where it is possible, that are off by {errors[worst]:.2f} on average"
    likely = _FIRST_THINGS_FIRST
    if call.kept.get("learns"):
        likely = _likely_of_the_end(values) or "your targets are others than those of task 3."
    if call.kept.get("looks ahead") and worst == 1 and np.nanmean(values[:, 1] - memory.exact[:, 1]) > 0:
        likely = (
            "your targets hope for actions that are impossible in the next state: leave them out before the max, "
            "`q.masked_fill(~next_possible, -torch.inf)`. Zero in their place is no help where all others are below it."
        )
    raise NotYet(came, likely, shown(memory, values, (0, 1, 2, 6, 7, 8), names))


def _holds_its_target_still(call, seed):
    memory = chains(seed + 1, [2.0, -2.0], loss=-3.0, S=3)
    values = trained(call, memory, steps=160, copy_every=_NEVER, seed=seed)
    good, bad = values[:, 0].reshape(2, -1)
    exact_good, exact_bad = memory.exact[:, 0].reshape(2, -1)
    map_ = shown(memory, values, range(6), ["go on", "leave"])
    if good[-1] - bad[-1] < (exact_good[-1] - exact_bad[-1]) / 2:
        came = f"going on is worth {good[-1]:.2f} in the last state of one chain, {bad[-1]:.2f} in that of the other"
        likely = _likely_of_the_end(values) or _TOO_SLOW if call.kept.get("learns") else _FIRST_THINGS_FIRST
        raise NotYet(came, likely, map_)
    apart = np.mean(good[:-1] - bad[:-1])
    if apart > 0.6 * np.mean(exact_good[:-1] - exact_bad[:-1]):
        raise NotYet(
            f"in the states before the last ones, going on is worth {apart:.2f} more in the chain with the good end",
            "your targets learn along, though no copy is due yet. Either `target = network` is a second name for the "
            "same network: `copy.deepcopy(network)` makes another one. Or the value of the next state comes from the "
            "network itself: it only chooses, `target(next_x)` says what its choice is worth.",
            map_,
        )
    _still_holds_it_after_a_copy(call, seed)


def _still_holds_it_after_a_copy(call, seed):
    """One copy, in the middle: the ends are known two links away, and not beyond."""
    memory = chains(seed + 2, [2.0, -2.0], loss=-3.0)
    values = trained(call, memory, steps=340, copy_every=180, seed=seed)
    good, bad = values[:, 0].reshape(2, -1)
    exact_good, exact_bad = memory.exact[:, 0].reshape(2, -1)
    apart = np.mean(good[:-2] - bad[:-2])  # about 0 with a copy, below 0.45 of what is exact where it follows softly
    if apart > 0.6 * np.mean(exact_good[:-2] - exact_bad[:-2]):
        raise NotYet(
            f"after 340 steps, with `copy_every = 180`, five states a chain: going on is worth {apart:.2f} more in the "
            "good one's first three, which cannot know yet",
            "your target network holds still until its first copy, and learns along from then on. `target = network` "
            "makes a second name, no copy: use `target.load_state_dict(network.state_dict())` or "
            "`target = copy.deepcopy(network)`. (Or is it copied more often than every `copy_every` steps?)",
            shown(memory, values, range(10), ["go on", "leave"]),
        )


def _heeds_steps_and_seed(call, seed):
    memory = many_states(seed + 1)

    def after_five_steps(seed):
        return trained(call, memory, steps=5, copy_every=_NEVER, seed=seed)

    once = after_five_steps(seed)
    if _mean_error(once, memory.exact) < _CLOSE:
        raise NotYet(
            f"values that are off by {_mean_error(once, memory.exact):.2f} on average, after `steps = 5`",
            "your training takes another number of steps than `steps`.",
        )
    again, other = after_five_steps(seed), after_five_steps(seed + 1)
    if not np.allclose(once, again, atol=1e-3):
        raise NotYet(
            f"the same seed twice: {once[0, 0]:.4f} and {again[0, 0]:.4f} for the same state and action",
            "`seed` does not decide all of the chance in your training: `torch.manual_seed(seed)` before the network "
            "is made, and `np.random.default_rng(seed)` for the batches.",
        )
    if np.allclose(once, other, atol=1e-6):
        raise NotYet(
            f"seeds {seed} and {seed + 1} give the same values",
            "your training does not use `seed`: is another number in its place, or is there no training?",
        )


learns_with_a_target_that_holds_still = Check(
    "learns_with_a_target_that_holds_still",
    title="Task 4, deep Q-learning from a memory",
    usage="learn(observations, actions, rewards, next_observations, next_possible, terminated, steps, copy_every, "
    "seed)",
    trials=[
        Trial(
            "thirty states in which every action ends the episode",
            "after 300 steps the values are the rewards, also negative ones",
            _learns_what_actions_pay,
        ),
        Trial(
            "a chain of five states with a reward at the end, a copy every 20 steps",
            "after 301 steps the values are 2 · gamma to the power of the steps that lie between",
            _learns_what_lies_ahead,
        ),
        Trial(
            "trades that can only be closed at a loss, and not be opened again",
            "only possible actions count in the next state",
            _leaves_out_what_is_impossible,
        ),
        Trial(
            f"a chain with a good end and one with a bad end, `copy_every = {_NEVER}`",
            "after 160 steps only the last states know of their ends",
            _holds_its_target_still,
        ),
        Trial("five steps, the same seed twice, then another", "the same values, then others", _heeds_steps_and_seed),
    ],
    likely={
        "same number of dimensions": "`gather` wants the actions as a column: `actions[:, None]`.",
        "int64 for index|used as indices must be|type LongTensor": "an index is no whole number: "
        "`torch.tensor(actions)` keeps the int64 that numpy has.",
        "shapes cannot be multiplied": "the network does not fit these worlds: `observations.shape[1]` numbers go in, "
        "and `next_possible.shape[1]` values come out.",
        **MISTAKES_WITH_ARRAYS,
    },
    hints=[
        "Two networks of the same shape: one that is trained, and `target = copy.deepcopy(network)`. In goes "
        "`observations.shape[1]`, out comes `next_possible.shape[1]`.",
        "Each step: draw 64 numbers, `rng.integers(N, size=64)`, and take these rows of all six arrays. Every "
        "`copy_every` steps, first: `target.load_state_dict(network.state_dict())`.",
        "The targets are those of task 3, without a gradient: `with torch.no_grad():`. Impossible actions are left out "
        "by `network(next_x).masked_fill(~possible, -torch.inf)`.",
        "The loss compares them with the values of the actions taken, "
        "`network(x).gather(1, actions[:, None]).squeeze(1)`. Then `optimizer.zero_grad()`, `loss.backward()`, "
        "`optimizer.step()`.",
        "At the end: `with torch.no_grad(): return network(all_observations).numpy()`.",
    ],
)
