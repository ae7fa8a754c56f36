"""What `network_inputs` is mistaken for: functions as in task 1, each wrong in one way, and words for it.

Where a mistake leaves open what an entry is, it is `ANY`.
"""

import numpy as np

from course_lib.checks.homework_3.arrays import ANY


def windows(values, k):
    """float[T, k] of T - 1 values that end at bars 1 … T - 1: row t holds those of bars t - k + 1 … t; NaN before."""
    rows = np.full((len(values) + 1, k), np.nan)
    rows[k:] = np.lib.stride_tricks.sliding_window_view(values, k)
    return rows


def _log_returns(close):
    return np.diff(np.log(close))


def _simple_returns(close):
    return close[1:] / close[:-1] - 1


def _fallen(close):
    return -_log_returns(close)


def _of_training(returns, num_train):
    return returns[: num_train - 1]


def _of_one_more(returns, num_train):
    return returns[:num_train]


def _of_all(returns, _):
    return returns


def _rows(*, returns=_log_returns, sigma_of=_of_training, mean_of=None, ddof=0, divides=True, largest=5):
    """A function as `network_inputs`, but for what is said."""

    def rows(close, num_train, k):
        values = returns(close)
        sigma = np.std(sigma_of(values, num_train), ddof=ddof) if divides else 1.0
        mean = np.mean(mean_of(values, num_train)) if mean_of else 0.0
        return windows(np.clip((values - mean) / sigma, -largest, largest), k)

    return rows


_right = _rows()


def _newest_first(close, num_train, k):
    return _right(close, num_train, k)[:, ::-1]


def _one_bar_ahead(close, num_train, k):
    rows = _right(close, num_train, k)
    rows[k - 1 : -1] = rows[k:]
    rows[[k - 1, -1]] = ANY
    return rows


def _one_bar_behind(close, num_train, k):
    rows = _right(close, num_train, k)
    rows[k + 1 :] = rows[k:-1].copy()
    rows[k] = ANY
    return rows


def _one_row_late(close, num_train, k):
    rows = _right(close, num_train, k)
    rows[k] = np.nan
    return rows


def _scaled_by_row(close, _, k):
    rows = windows(_log_returns(close), k)
    return np.clip(rows / rows.std(axis=1, keepdims=True), -5, 5)


def _scaled_by_column(close, num_train, k):
    rows = windows(_log_returns(close), k)
    train = rows[k:num_train]
    return np.clip((rows - train.mean(axis=0)) / train.std(axis=0), -5, 5)


def _prices(change):
    """Rows of closes where there should be rows of returns."""

    def rows(close, num_train, k):
        values = change(close)
        return windows(np.clip(values / np.std(values[:num_train]), -5, 5)[1:], k)

    return rows


def _cut_off(close, num_train, k):
    return _right(close, num_train, k)[k:]


ROWS_TOO_LATE = "your function leaves rows empty for which all returns are there: row k is the first full one."
_CUT = "the rows without a full window are cut off: there is a row for each close, and the first k rows are NaN."
_FROM_ALL = "sigma comes from all closes, also from those after the training part: take `returns[:num_train - 1]`."
_MEAN = "your function subtracts the mean as well. Divide by sigma only: a return of 0 stays 0."
_PRICES = "your rows hold prices, or differences of prices: a log return is log(close[t] / close[t − 1])."

VALUE_MISTAKES = [
    (_newest_first, "the newest return comes first: the oldest of the k belongs in column 0."),
    (_one_bar_ahead, "your rows look one bar ahead: the last number of row t is log(close[t] / close[t − 1])."),
    (_one_bar_behind, "your rows end one bar too early: the last number of row t is log(close[t] / close[t − 1])."),
    (_one_row_late, ROWS_TOO_LATE),
    (_rows(sigma_of=_of_all), _FROM_ALL),
    (
        _rows(sigma_of=_of_one_more),
        "one return too many goes into sigma: between `num_train` closes there are num_train − 1 returns, and the "
        "next one ends after the training part.",
    ),
    (
        _rows(ddof=1),
        "your sigma divides by n − 1, as pandas' `std` does; `np.std` divides by n. In pandas it is `.std(ddof=0)`.",
    ),
    (_rows(divides=False), "your function does not divide by sigma."),
    (_rows(largest=np.inf), "values beyond −5 … 5 are left: `np.clip` comes last, after the division by sigma."),
    (_rows(mean_of=_of_training), _MEAN),
    (_rows(mean_of=_of_all), _MEAN),
    (_rows(mean_of=_of_all, sigma_of=_of_all), _FROM_ALL),
    (_rows(returns=_simple_returns), "your returns are simple ones, close[t] / close[t − 1] − 1: take the logarithm."),
    (_rows(returns=_fallen), "a rise comes out negative: a log return is log(close[t] / close[t − 1])."),
    (_scaled_by_row, "each row is divided by its own standard deviation: sigma is one number for all rows."),
    (_scaled_by_column, "each column is scaled by itself, as a `StandardScaler` does: sigma is one number for all."),
    (_rows(returns=np.diff), _PRICES),
    (_prices(np.asarray), _PRICES),
    (_prices(np.log), _PRICES),
    (_cut_off, _CUT),
]


def _filled_with_zeros(close, num_train, k):
    return np.nan_to_num(_right(close, num_train, k))


def _padded(number):
    """Bars that have no return get that `number` as one."""

    def rows(close, num_train, k):
        returns = _log_returns(close)
        scaled = np.clip(returns / np.std(_of_training(returns, num_train)), -5, 5)
        return np.lib.stride_tricks.sliding_window_view(np.concatenate([np.full(k, number), scaled]), k).copy()

    return rows


def _return_of_bar_0(close, num_train, k):
    rows = _padded(0.0)(close, num_train, k)
    rows[: k - 1] = np.nan
    return rows


WARM_UP_MISTAKES = [
    (
        _filled_with_zeros,
        "the first k rows are filled with zeros. Zero says that nothing has moved, NaN that it is not known.",
    ),
    (_padded(0.0), "what is missing in the first k rows is filled with zeros: such a row is NaN as a whole."),
    (_padded(np.nan), "the first k rows are NaN in part: where one return is missing the whole row is NaN."),
    (_return_of_bar_0, "bar 0 has a return in your rows, but there is no bar before it: row k is the first full one."),
    (_cut_off, _CUT),
]
