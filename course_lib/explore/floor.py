"""What a trader made of a stretch of prices, judged beside those it has to beat, and drawn."""

from dataclasses import asdict, dataclass
from html import escape
from itertools import pairwise

import numpy as np

from course_lib import market
from course_lib.explore.controls import Panel
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.numerals import numeral, scientific
from course_lib.explore.worlds import counted
from course_lib.plots.picture import BLUE, FAINT, INK, RED

OWN_LINES = (0, 2, 4)  # of the palette: one for each trader that can be drawn at once
_HOLD, _RANDOM, _ORACLE = 1, 3, 5
_SHIFTS = 200
_MOST_POINTS = 180  # of a line: more could not be told apart
_TILE = 'width="6" height="6" patternUnits="userSpaceOnUse"'
_HATCHES = (
    f'<pattern id="held-long" patternTransform="rotate(45)" {_TILE}>'
    f'<rect width="6" height="6" fill="{BLUE}" fill-opacity="0.3"/><rect width="2" height="6" fill="{BLUE}"/></pattern>'
    f'<pattern id="held-short" {_TILE}><rect width="6" height="6" fill="{RED}" fill-opacity="0.3"/>'
    f'<circle cx="3" cy="3" r="1.3" fill="{RED}"/></pattern>'
)


@dataclass(frozen=True, eq=False)
class Judged:
    """A trader on a part of a price history, and its yardsticks, at one cost a leg.

    account     its `market.Account`
    scores      {"trader", "buy and hold", "random" (medians) or "oracle": {field of `market.Metrics`: number}}
    curves      {"trader", "buy and hold" or "oracle": float64[P]}, log of the money at the bars `places`, int64[P]
    band        float64[3, P]: 5 %, 50 % and 95 % of 200 random traders, at the same bars
    percentile  how many of 100 random traders end with less, as `market.percentile` counts them
    """

    part: market.Part
    cost: float
    account: market.Account
    scores: dict
    curves: dict
    band: np.ndarray
    places: np.ndarray
    percentile: float

    @property
    def money(self):
        """What 1 unit of money has become."""
        return float(np.exp(self.account.log_equity[-1]))

    @property
    def sharpe(self):
        """The trader's Sharpe ratio."""
        return self.scores["trader"]["sharpe"]

    def says(self):
        """The result in a sentence or two, costs named."""
        legs = int(self.account.trades)
        eaten = 1 - (1 - self.cost) ** legs
        paid = f"took {100 * eaten:.1f} % of the money" if self.cost else "took nothing"
        costs = f"{counted(f'{legs:,}', 'leg')} at {cost_in_words(self.cost)} {paid}" if legs else "it never trades"
        ruin = " That is ruin." if self.account.ruined else ""
        rank = f"Its percentile among {_SHIFTS} random traders is {self.percentile:.0f}."
        return f"1 dollar becomes {amount(self.money)}; {costs}.{ruin} {rank}"


def judge(part, positions, cost):
    """`Judged`: the positions int[N] of one trader on a `market.Part`, at a cost a leg."""
    growth = market.log_growth(part, cost)
    accounts = {
        name: market.account(part, taken, growth=growth)
        for name, taken in {
            "trader": positions,
            "buy and hold": market.buy_and_hold(part),
            "random": market.random_shifts(positions, _SHIFTS),
            "oracle": market.oracle(part, cost=cost),
        }.items()
    }
    scores = {name: _scores(account) for name, account in accounts.items()}
    places = np.unique(np.linspace(0, len(part) - 1, _MOST_POINTS).round().astype(np.int64))
    chance = accounts.pop("random").log_equity
    curves = {name: account.log_equity[places] for name, account in accounts.items()}
    ahead = accounts["trader"].log_equity[-1] - chance[:, -1]
    percentile = 100 * (np.mean(ahead > 1e-12) + np.mean(np.abs(ahead) <= 1e-12) / 2)
    band = np.percentile(chance[:, places], [5, 50, 95], axis=0)
    return Judged(part, cost, accounts["trader"], scores, curves, band, places, float(percentile))


def _scores(account):
    return {name: float(np.median(values)) for name, values in asdict(market.metrics(account)).items()}


# --- pictures ---------------------------------------------------------------------------------------------------------


def price_panel(judged, shown):
    """The closes of the bars `shown`, a slice, with what the trader does on them, and below what it holds."""
    close, dates = judged.part.close.to_numpy(float)[shown], judged.part.dates[shown]
    held = judged.account.positions[shown]
    before = np.append(0, judged.account.positions[:-1])[shown]
    bars = np.arange(shown.start, shown.stop)
    when = f"{dates[0]:%Y-%m-%d} to {dates[-1]:%Y-%m-%d}"
    margin = 0.06 * (close.max() - close.min()) or 1.0
    chart = Chart(
        f"Price and trades, bars {bars[0]} to {bars[-1]}",
        x=(bars[0], bars[-1]), y=(close.min() - margin, close.max() + margin),
        xlabel=f"bar ({when})", ylabel="price", height=190, legend=6,
    )  # fmt: skip
    chart.line(bars, close, stroke=INK, stroke_width=1.2, stroke_dasharray=None)
    _strip(chart, bars, held)
    counts = []
    for side, shape, which, name in ((1, "up", 0, "buy"), (-1, "down", 1, "sell short"), (0, "ring", 0, "close")):
        happens = (held == side) & (before != side)
        chart.points(bars[happens], close[happens], which, size=4.5, shape=shape)
        counts.append(f"{name}: {happens.sum()}")
        chart.legend(counts[-1], which, kind=shape)
    course = (
        f"{_four(close[0])} at first, {_four(close[-1])} at last, between {_four(close.min())} and {_four(close.max())}"
    )
    holds = f"Long on {_percent(np.mean(held == 1))} of these bars, short on {_percent(np.mean(held == -1))}"
    words = f"Price of bars {bars[0]} to {bars[-1]}, {when}: {course}. Trades: {', '.join(counts)}. {holds}."
    return Panel("price", words, chart.svg())


def _strip(chart, bars, held):
    """The position from bar to bar: long above a line, short below it."""
    top = chart.room(3)
    middle, deep = top + 26, 18
    chart.sketch.add("defs", _HATCHES)
    changes = np.flatnonzero(np.diff(held)) + 1
    for begin, end in pairwise([0, *changes.tolist(), len(held) - 1]):
        if held[begin] and end > begin:
            left, right = (float(chart.across(bars[i])) for i in (begin, end))
            look = (
                {"fill": "url(#held-long)", "stroke": BLUE}
                if held[begin] > 0
                else {"fill": "url(#held-short)", "stroke": RED}
            )
            chart.sketch.rect(left, middle - deep * (held[begin] > 0), right - left, deep, stroke_width=0.8, **look)
    left, right = (float(chart.across(bars[i])) for i in (0, -1))
    chart.sketch.line([(left, middle), (right, middle)], stroke=INK)
    for words, y in (("long", middle - 14), ("flat", middle), ("short", middle + 14)):
        chart.sketch.text(left - 6, y, words, size=11, anchor="end")


def wealth_panel(named, shown, chosen=0):
    """What 1 dollar becomes, on a log scale; named: [(name, `Judged`), …], of one part at one cost, at most three.

    The yardsticks are those of the `chosen` one. The bars `shown` in the other picture are shaded.
    """
    judged = named[chosen][1]
    lines = [other.curves["trader"] for _, other in named] + [judged.curves["buy and hold"]]
    low, high = (np.exp(f([f(line) for line in [*lines, *judged.band]])) for f in (np.min, np.max))
    low, high = (low / 1.05, high * 1.05) if high / low < 4 else (low / 1.2, high * 1.2)
    chart = Chart(
        "What 1 dollar becomes", x=(0, len(judged.part) - 1), y=(low, high), xlabel="bar",
        ylabel="money (log scale)", height=190, log=True, legend=3 + len(named),
    )  # fmt: skip
    left, right = (float(chart.across(bar)) for bar in (shown.start, shown.stop - 1))
    chart.sketch.rect(left, chart.top, right - left, chart.bottom - chart.top, fill=FAINT, fill_opacity=0.16)
    chart.band(judged.places, *np.exp(judged.band[[0, 2]]), _RANDOM)
    chart.line(judged.places, np.exp(judged.band[1]), _RANDOM)
    seen = judged.curves["oracle"] <= np.log(high)  # it ends where it leaves the picture
    upto = len(seen) if seen.all() else int(np.argmin(seen)) + 1
    chart.line(judged.places[:upto], np.exp(judged.curves["oracle"][:upto]), _ORACLE, stroke_width=2.6)
    chart.line(judged.places, np.exp(judged.curves["buy and hold"]), _HOLD)
    told = []
    for i, (name, other) in enumerate(named):
        chart.line(
            judged.places, np.exp(other.curves["trader"]), OWN_LINES[i], stroke_width=2.8 if i == chosen else 1.8
        )
        told.append((f"{name}: {amount(other.money)}", OWN_LINES[i], "line"))
    hold, oracle = (amount(np.exp(judged.curves[name][-1])) for name in ("buy and hold", "oracle"))
    least, most = (amount(np.exp(judged.band[i, -1])) for i in (0, 2))
    told.append((f"buy and hold: {hold}", _HOLD, "line"))
    told.append((f"random, 5 % to 95 % of {_SHIFTS}: {least} to {most}", _RANDOM, "band"))
    told.append((f"oracle: {oracle}{'' if seen.all() else ', leaves the picture'}", _ORACLE, "line"))
    for words, which, kind in told:
        chart.legend(words, which, kind=kind)
    words = (
        f"What 1 dollar becomes over {len(judged.part)} bars, log scale. In the end {'; '.join(w for w, *_ in told)}."
    )
    return Panel("wealth", words, chart.svg())


def score_panel(named, notes, chosen=0):
    """A table of what counts, and lines of `notes` below it; named: as in `wealth_panel`."""
    judged = named[chosen][1]
    rows = [(name, other.scores["trader"]) for name, other in named]
    rows += [(name, judged.scores[name]) for name in ("buy and hold", "random", "oracle")]
    notes = [f"random: medians of {_SHIFTS}; in trade: on how many of the bars.", *notes]
    body = ""
    for name, scores in rows:
        cells = [
            _percent(scores["total_return"], "+"), one_digit(scores["sharpe"]),
            _percent(scores["max_drawdown"]), f"{scores['trades']:,.0f}", _percent(scores["exposure"]),
        ]  # fmt: skip
        body += (
            f'<tr><th scope="row" style="font-weight:400">{escape(name)}</th>'
            + "".join(f'<td style="white-space:nowrap;{_NUMBERS}">{cell}</td>' for cell in cells)
            + "</tr>"
        )
    head = "".join(f'<th scope="col" style="{_NUMBERS}">{name}</th>' for name in _COLUMNS)
    table = f'<table style="{_TABLE_LOOK}"><thead><tr><td></td>{head}</tr></thead><tbody>{body}</tbody></table>'
    lines = "".join(f'<p style="margin:6px 0 0">{escape(note)}</p>' for note in notes)
    return Panel("scores", html=table + lines)


_COLUMNS = ("return", "Sharpe", "drawdown", "legs", "in trade")
_NUMBERS = "padding:3px 0 3px 8px;text-align:right"  # units below units: what is large is long
_TABLE_LOOK = "font-size:12px;overflow-wrap:normal"  # it has to fit a narrow page


def dots_panel(own, tries, whose):
    """Sharpe ratios in training, across, and on unseen days: of `own`, a pair, and of `tries`, pairs.

    whose  what the tries are
    """
    pairs, result = np.array([own, *tries]), "{} in training, {} on unseen days".format(*map(one_digit, own))
    least, most = np.minimum(pairs.min(axis=0), (-1, -3)), np.maximum(pairs.max(axis=0), (15, 6))
    chart = Chart(
        "Learned, or memorised?", x=(least[0], most[0]), y=(least[1], most[1]), xlabel="Sharpe ratio on training days",
        ylabel="Sharpe ratio on unseen days (0: nothing gained)", height=190, legend=2,
    )  # fmt: skip
    both = max(least), min(most)
    chart.line(both, both, stroke=INK, stroke_width=1, stroke_dasharray="1 3")
    chart.note(both[1] + 0.2 * (most[0] - least[0]), both[1] - 0.15 * (most[1] - least[1]), "as good on unseen days")
    chart.rule(0, "")
    for inside, outside in tries:
        chart.points(inside, outside, 0)
    chart.points(*own, 1, size=5, shape="square")
    chart.legend(f"this trader: {result}", 1, kind="square")
    words = f"Sharpe ratios. This trader: {result}."
    if tries:
        chart.legend(f"{len(tries)} {whose}", 0, kind="circle")
        told = [f"{one_digit(inside)} and {one_digit(outside)}" for inside, outside in tries]
        words += f" {len(tries)} {whose}, in training and on unseen days: {'; '.join(told)}."
    return Panel("dots", words, chart.svg())


# --- numbers in words -------------------------------------------------------------------------------------------------


def cost_in_words(cost):
    """A cost as a part of a hundred: 0.0005 is 0.05 %."""
    return f"{round(100 * cost, 6):g} %"


def one_digit(number):
    """One digit after the point, and no minus before a zero."""
    return numeral(round(float(number), 1) + 0.0, ".1f")


def amount(money):
    """Three digits that count, 0.998, 6.42, 36,800,000; two of what is very large or small, 7.2×10¹⁰."""
    rounded = float(f"{money:.3g}")
    if rounded and not 1e-4 <= rounded < 1e9:
        return scientific(money)
    return f"{rounded:,.12g}" if rounded >= 1000 else f"{rounded:.3g}"


def _four(price):
    return f"{float(f'{price:.4g}'):,.12g}"


def _percent(share, sign=""):
    """Two or three digits that count: 3.7 %, 29 %, +542 %, +157,000 %; what is beyond ten million as +4×10⁹ %."""
    hundred = 100 * share
    if abs(hundred) >= 1e7:
        return f"{scientific(hundred, f'{sign}.0e')} %"
    rounded = round(hundred, 1) if abs(hundred) < 9.95 else float(f"{hundred:.3g}")
    return f"{numeral(rounded + 0.0, f'{sign},.{int(abs(rounded) < 9.95)}f')} %"
