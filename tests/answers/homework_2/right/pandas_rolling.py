"""pandas: rolling windows, shifts, and a Series given to the encoder."""

import numpy as np
import pandas as pd


def window_states(close, num_train, k):
    move = pd.Series(close).pct_change()
    flat = move.abs().iloc[1:num_train].quantile(1 / 3)
    digit = pd.Series(1, index=move.index)
    digit[move > flat] = 2
    digit[move < -flat] = 0
    state = sum(digit.shift(i) * 3**i for i in range(k))
    state[:k] = -1
    return state.astype(int).to_numpy()


def level(close, low, high, levels):
    level = (levels * (close - low) / (high - low)).clip(upper=levels - 1)
    return level.where(high > low, levels // 2)


def grid_states(close, n):
    s = pd.Series(close)
    window = s.rolling(n)
    row = np.floor(level(s, window.min(), window.max(), n))
    since_low = window.apply(lambda w: w[::-1].argmin(), raw=True)
    since_high = window.apply(lambda w: w[::-1].argmax(), raw=True)
    state = n * row + since_low.where(row >= n / 2, since_high)
    state[: n - 1] = -1
    return state.astype(int).to_numpy()


def minmax_states(close, m, levels):
    s = pd.Series(close)
    window = s.rolling(m)
    state = np.floor(level(s, window.min(), window.max(), levels))
    state[: m - 1] = -1
    return state.astype("int64").values


def reward(price, next_price, side, position, next_position, cost):
    prices = pd.Series([price, next_price])
    growth = 1 + side * next_position * prices.pct_change().iloc[-1]
    return float(np.log(growth * (1 - cost) ** abs(next_position - position)))


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    index = pd.MultiIndex.from_product([[0, 1], range(len(q_table) // 2)], names=["position", "state"])
    frame = pd.DataFrame(q_table, index=index, columns=["hold", "open", "close"])
    following = frame.loc[(next_position, next_state)].drop("open" if next_position else "close")
    row = index.get_loc((position, state))
    q_table[row, action] += alpha * (reward + gamma * following.max() - q_table[row, action])


def trade(q_long, q_short, states):
    number = len(q_long) // 2
    tables = {1: pd.DataFrame(q_long, columns=list("hoc")), -1: pd.DataFrame(q_short, columns=list("hoc"))}
    gains = pd.DataFrame({side: (table.o - table.h)[:number] for side, table in tables.items()})
    best = gains.idxmax(axis=1).where((gains.max(axis=1) > 0) & (gains[1] != gains[-1]), 0)
    closes = pd.DataFrame({side: (table.c > table.h)[number:].to_numpy() for side, table in tables.items()})
    position, positions = 0, pd.Series(0, index=range(len(states)))
    for t, state in pd.Series(states).items():
        if state == -1:
            continue
        before = position
        if before and closes.at[state, before]:
            position = 0
        if position == 0 and best[state] != before:
            position = best[state]
        positions[t] = position
    return positions.to_numpy()


def looks_ahead(encode, close):
    prices = pd.Series(close)
    states = pd.Series(encode(prices))
    for t in prices.index[:-1]:
        shorter = pd.Series(encode(prices.loc[:t]))
        if not shorter.equals(states.loc[:t]):
            return True
    return False
