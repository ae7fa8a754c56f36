"""Six made-up markets, whose pattern, or whose lack of one, is known."""

from functools import cached_property

import numpy as np
import pandas as pd

from course_lib.market.accounting import checked_cost
from course_lib.market.chain import Chain, expected_growth, side_mdp
from course_lib.market.prices import PriceDataError, as_price_errors
from course_lib.validate import number, whole_number

_FIRST_PRICE, _FIRST_DAY = 100.0, "2000-01-03"


class Market:
    """What all six have in common. A kind of market gives `_simulate`, `knowledge` and `chain`."""

    def prices(self, num_bars=5000, *, seed=0):
        """So many bars of this market, a frame with one column, close; the same seed gives the same prices."""
        num_bars = _whole("num_bars", num_bars)
        rng = np.random.default_rng(whole_number("seed", seed))
        close = _FIRST_PRICE * np.exp(self._simulate(num_bars, rng))
        return pd.DataFrame({"close": close}, index=self._dates(num_bars))

    def _dates(self, num_bars):
        return pd.bdate_range(_FIRST_DAY, periods=num_bars, name="date")

    def _simulate(self, num_bars, rng):
        """log(price / 100) of each bar, float64[num_bars]."""
        raise NotImplementedError

    def knowledge(self, prices):
        """What who knows the market's law knows at each bar from the prices so far: int64[T], states of `chain`.

        prices  of this market, from its first bar on
        """
        raise NotImplementedError

    @property
    def chain(self):
        """The market as a `Chain` of those states."""
        raise NotImplementedError


class LadderMarket(Market):
    """A price that climbs up and down a ladder of 11 rungs, 1 % apart, and is drawn to the middle one.

    From rung i it goes up with probability 0.5 - 0.06 (i - 5), else down; a step off either end goes the other way. A
    finite chain: `mdp` gives one side's world exactly, for `value_iteration`.
    """

    rungs, step = 11, np.log(1.01)

    def _simulate(self, num_bars, rng):
        return _steps(np.full(num_bars, 5), self._up, rng.random(num_bars)) * self.step

    def knowledge(self, prices):
        level = np.log(prices["close"].to_numpy(float) / _FIRST_PRICE) / self.step
        return np.clip(np.rint(level).astype(np.int64), 0, self.rungs - 1)

    @cached_property
    def _up(self):
        up = 0.5 - 0.06 * (np.arange(self.rungs) - 5)
        up[0], up[-1] = 1.0, 0.0
        return up

    @cached_property
    def chain(self):
        rung = np.arange(self.rungs)
        transition = np.zeros((self.rungs, self.rungs))
        transition[rung[:-1], rung[1:]] = self._up[:-1]
        transition[rung[1:], rung[:-1]] = 1 - self._up[1:]
        return Chain.of_moves(transition, (rung - rung[:, None]) * self.step)

    def mdp(self, side, cost=0.0005):
        """One side's world, an `MDP` of 22 states, position * 11 + rung, and the actions hold, open, close."""
        return side_mdp(self.chain, checked_side(side), checked_cost(cost))


class DayGridMarket(Market):
    """A day of trading on a grid of 9 bars and 9 rows of prices, 0.5 % apart: the maze's cousin.

    A day begins in the middle row, at the price at which the day before ended. From d rows off the middle the price
    goes back by one with probability 0.5 + 0.1 d, else further off; from the last row it always goes back. `mdp` gives
    one side's world exactly; its states are position * 81 + row * 9 + bar.
    """

    bars, rows, step = 9, 9, 0.005
    _middle = 4

    def _dates(self, num_bars):
        days = pd.bdate_range(_FIRST_DAY, periods=-(-num_bars // self.bars))
        hours = pd.to_timedelta(np.arange(self.bars) + 9, unit="h")
        return pd.DatetimeIndex((days.to_numpy()[:, None] + hours.to_numpy()).ravel()[:num_bars], name="date")

    def _simulate(self, num_bars, rng):
        days = -(-num_bars // self.bars)
        drawn = rng.random((days, self.bars))
        rows = np.stack([_steps(np.full(self.bars, self._middle), self._up, day) for day in drawn])
        since_base = (rows - self._middle) * self.step
        base = np.concatenate([[0.0], np.cumsum(since_base[:-1, -1])])
        return (base[:, None] + since_base).ravel()[:num_bars]

    @cached_property
    def _up(self):
        off = np.arange(self.rows) - self._middle
        up = 0.5 - 0.1 * off
        up[0], up[-1] = 1.0, 0.0
        return up

    def knowledge(self, prices):
        log_price = np.log(prices["close"].to_numpy(float))
        bar = np.arange(len(log_price)) % self.bars
        base = log_price[np.arange(len(log_price)) - bar]
        row = self._middle + np.rint((log_price - base) / self.step).astype(np.int64)
        return np.clip(row, 0, self.rows - 1) * self.bars + bar

    @cached_property
    def chain(self):
        states = self.rows * self.bars
        transition, moves = np.zeros((states, states)), np.zeros((states, states))
        for row in range(self.rows):
            for bar in range(self.bars - 1):
                for to, chance in ((row + 1, self._up[row]), (row - 1, 1 - self._up[row])):
                    if chance > 0:
                        here, there = row * self.bars + bar, to * self.bars + bar + 1
                        transition[here, there], moves[here, there] = chance, (to - row) * self.step
            transition[row * self.bars + self.bars - 1, self._middle * self.bars] = 1.0  # the next day's base
        return Chain.of_moves(transition, moves)

    def mdp(self, side, cost=0.0005):
        """One side's world, an `MDP` of 162 states and the actions hold, open, close."""
        return side_mdp(self.chain, checked_side(side), checked_cost(cost))


class RubberBandMarket(Market):
    """A price on a rubber band: x' = (1 - kappa) x + sigma * noise, x = log(price / 100) (an AR(1) process).

    kappa  share of the way to 100 that the band pulls it back each bar, in (0, 1];  sigma  of the noise, a bar
    """

    _places = 161

    def __init__(self, kappa=0.2, sigma=0.01):
        self.kappa, self.sigma = _in_range("kappa", kappa, 1.0), _in_range("sigma", sigma, 0.2)

    @property
    def _spread(self):
        """Standard deviation of x in the long run."""
        return self.sigma / np.sqrt(1 - (1 - self.kappa) ** 2)

    def _simulate(self, num_bars, rng):
        x = np.empty(num_bars)
        x[0], noise = 0.0, self.sigma * rng.standard_normal(num_bars)
        for t in range(1, num_bars):
            x[t] = (1 - self.kappa) * x[t - 1] + noise[t]
        return x

    @cached_property
    def _grid(self):
        return np.linspace(-5, 5, self._places) * self._spread

    def knowledge(self, prices):
        x = np.log(prices["close"].to_numpy(float) / _FIRST_PRICE)
        return _nearest(x, self._grid)

    @cached_property
    def chain(self):
        expected = (1 - self.kappa) * self._grid
        transition = _normal_chances(self._grid - expected[:, None], self.sigma)
        return Chain.of_moves(transition, self._grid - self._grid[:, None])


class TrendMarket(Market):
    """A price with a tail wind or a head wind, neither of which can be seen.

    Each bar's log return is +drift or -drift plus noise; from one bar to the next the wind stays with probability
    `stay`. The best that can be known is the probability of tail wind given the returns so far (Hamilton, 1989).
    """

    _beliefs = np.linspace(0, 1, 101)

    def __init__(self, drift=0.004, sigma=0.01, stay=0.98):
        self.drift, self.sigma = _in_range("drift", drift, 0.1), _in_range("sigma", sigma, 0.2)
        self.stay = _in_range("stay", stay, 1.0)

    def _simulate(self, num_bars, rng):
        turns = rng.random(num_bars) >= self.stay
        turns[0] = rng.random() < 0.5
        wind = 1 - 2 * (np.cumsum(turns) % 2)
        moves = wind * self.drift + self.sigma * rng.standard_normal(num_bars)
        moves[0] = 0.0
        return np.cumsum(moves)

    def _expected(self, belief):
        """Probability of tail wind in the next bar."""
        return belief * self.stay + (1 - belief) * (1 - self.stay)

    def _revised(self, expected, move):
        """Bayes' rule: the probability of tail wind in the bar that moved so, expected before it."""
        against = np.clip(-2 * move * self.drift / self.sigma**2, -650.0, 650.0)  # beyond, exp would overflow
        odds = np.exp(against) * (1 - expected) / expected
        return 1 / (1 + odds)

    def knowledge(self, prices):
        moves = np.diff(np.log(prices["close"].to_numpy(float)))
        beliefs = [0.5]
        for move in moves:
            beliefs.append(self._revised(min(max(self._expected(beliefs[-1]), 1e-12), 1.0), move))
        return _nearest(np.array(beliefs), self._beliefs)

    @cached_property
    def chain(self):
        moves = np.linspace(-1, 1, 161) * (self.drift + 5 * self.sigma)
        expected = np.clip(self._expected(self._beliefs), 1e-12, 1.0)
        tail, head = (_normal_chances(moves - wind * self.drift, self.sigma) for wind in (1, -1))
        chances = expected[:, None] * tail + (1 - expected)[:, None] * head
        place = self._revised(expected[:, None], moves) * (len(self._beliefs) - 1)
        below = np.minimum(place.astype(np.int64), len(self._beliefs) - 2)
        transition = np.zeros((len(expected), len(expected)))
        rows = np.broadcast_to(np.arange(len(expected))[:, None], below.shape)
        np.add.at(transition, (rows, below), chances * (1 - (place - below)))
        np.add.at(transition, (rows, below + 1), chances * (place - below))
        return Chain(transition, expected_growth(moves, chances))


class CycleMarket(Market):
    """A price that swings about 100: log(price / 100) = amplitude * sin(2 π t / period) + sigma * noise."""

    _noises = np.linspace(-3.5, 3.5, 21)

    def __init__(self, period=37, amplitude=0.1, sigma=0.01):
        self.period = _whole("period", period)
        self.amplitude, self.sigma = _in_range("amplitude", amplitude, 1.0), _in_range("sigma", sigma, 0.2)

    def _swing(self, bars):
        return self.amplitude * np.sin(2 * np.pi * np.asarray(bars) / self.period)

    def _simulate(self, num_bars, rng):
        return self._swing(np.arange(num_bars)) + self.sigma * rng.standard_normal(num_bars)

    def knowledge(self, prices):
        bars = np.arange(len(prices))
        noise = (np.log(prices["close"].to_numpy(float) / _FIRST_PRICE) - self._swing(bars)) / self.sigma
        return bars % self.period * len(self._noises) + _nearest(noise, self._noises)

    @cached_property
    def chain(self):
        x = self._swing(np.arange(self.period))[:, None] + self.sigma * self._noises  # by phase and noise
        chances = _normal_chances(self._noises, 1.0)
        shape = (*x.shape, *x.shape)
        transition = np.zeros(shape)
        for phase in range(self.period):
            transition[phase, :, (phase + 1) % self.period] = chances
        x = x.ravel()
        return Chain.of_moves(transition.reshape(x.size, x.size), x - x[:, None])


class RandomWalkMarket(Market):
    """Log returns that are noise and nothing else: no policy is worth more than staying out."""

    def __init__(self, sigma=0.01):
        self.sigma = _in_range("sigma", sigma, 0.2)

    def _simulate(self, num_bars, rng):
        noise = self.sigma * rng.standard_normal(num_bars)
        noise[0] = 0.0
        return np.cumsum(noise)

    def knowledge(self, prices):
        return np.zeros(len(prices), np.int64)

    @cached_property
    def chain(self):
        noise = np.linspace(-5, 5, 161) * self.sigma
        return Chain(np.ones((1, 1)), expected_growth(noise, _normal_chances(noise, self.sigma))[None])


def checked_side(side):
    if isinstance(side, bool) or np.ndim(side) or side not in (1, -1):
        raise PriceDataError(f"side must be +1 (buy, cash out) or -1 (sell, cash out), got {side!r}")
    return int(side)


def _whole(name, value):
    with as_price_errors():
        return whole_number(name, value, at_least=2)


def _in_range(name, value, most):
    with as_price_errors():
        result = number(name, value)
    if not 0 < result <= most:
        raise PriceDataError(f"{name} must be above 0 and at most {most:g}, got {value!r}")
    return result


def _steps(places, up, drawn):
    """Walk from places[0] by one up where the draw is below up[place], else by one down; overwrites the others."""
    for t in range(1, len(places)):
        places[t] = places[t - 1] + (1 if drawn[t] < up[places[t - 1]] else -1)
    return places


def _normal_chances(deviations, sigma):
    """Chances proportional to the normal density, float64, that sum to 1 over the last axis."""
    density = np.exp(-0.5 * (deviations / sigma) ** 2)
    return density / density.sum(axis=-1, keepdims=True)


def _nearest(values, grid):
    step = grid[1] - grid[0]
    return np.clip(np.rint((values - grid[0]) / step).astype(np.int64), 0, len(grid) - 1)
