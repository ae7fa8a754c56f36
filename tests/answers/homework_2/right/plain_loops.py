"""Nothing but Python: loops, lists and floats, simple returns, and lists returned; the future is cut off."""

import math


def window_states(close, num_train, k):
    moves = [close[t] / close[t - 1] - 1 for t in range(1, len(close))]
    sizes = sorted(abs(move) for move in moves[: num_train - 1])
    place = (len(sizes) - 1) / 3
    below = math.floor(place)
    flat = sizes[below]
    if below + 1 < len(sizes):
        flat += (place - below) * (sizes[below + 1] - sizes[below])
    states = []
    for t in range(len(close)):
        if t < k:
            states.append(-1)
            continue
        number = 0
        weight = 1
        for i in range(k):
            move = moves[t - 1 - i]
            if move > flat:
                number += 2 * weight
            elif move >= -flat:
                number += weight
            weight *= 3
        states.append(number)
    return states


def place_of(price, low, high, steps):
    if low == high:
        return steps // 2
    place = int((price - low) / (high - low) * steps)
    if place == steps:
        place = steps - 1
    return place


def grid_states(close, n):
    prices = [float(price) for price in close]
    states = [-1] * len(prices)
    for t in range(n - 1, len(prices)):
        low = high = prices[t]
        since_low = since_high = 0
        for back in range(1, n):
            price = prices[t - back]
            if price < low:
                low = price
                since_low = back
            if price > high:
                high = price
                since_high = back
        row = place_of(prices[t], low, high, n)
        if 2 * row >= n:
            states[t] = row * n + since_low
        else:
            states[t] = row * n + since_high
    return states


def minmax_states(close, m, levels):
    states = []
    for t in range(len(close)):
        if t + 1 < m:
            states.append(-1)
        else:
            window = list(close[t + 1 - m : t + 1])
            states.append(place_of(close[t], min(window), max(window), levels))
    return states


def reward(price, next_price, side, position, next_position, cost):
    pays = 0.0
    if position != next_position:
        pays += math.log(1 - cost)
    if next_position == 1 and side == 1:
        pays += math.log(next_price / price)
    elif next_position == 1:
        pays += math.log(2 - next_price / price)
    return pays


def update(q_table, state, position, action, reward, next_state, next_position, alpha, gamma):
    num_states = len(q_table) // 2
    best = q_table[next_position * num_states + next_state][0]
    other = q_table[next_position * num_states + next_state][1 + next_position]
    if other > best:
        best = other
    old = q_table[position * num_states + state][action]
    q_table[position * num_states + state][action] = (1 - alpha) * old + alpha * (reward + gamma * best)


def trade(q_long, q_short, states):
    num_states = len(q_long) // 2
    position = 0
    positions = []
    for state in states:
        if state < 0:
            position = 0
        else:
            long = q_long[state][1] - q_long[state][0]
            short = q_short[state][1] - q_short[state][0]
            if position == 1:
                if q_long[num_states + state][2] > q_long[num_states + state][0]:
                    position = -1 if short > 0 and short > long else 0
            elif position == -1:
                if q_short[num_states + state][2] > q_short[num_states + state][0]:
                    position = 1 if long > 0 and long > short else 0
            elif long > 0 and long > short:
                position = 1
            elif short > 0 and short > long:
                position = -1
        positions.append(position)
    return positions


def looks_ahead(encode, close):
    whole = list(encode(close))
    for length in range(1, len(close)):
        if list(encode(close[:length])) != whole[:length]:
            return True
    return False
