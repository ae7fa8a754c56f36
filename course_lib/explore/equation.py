"""The Bellman equation of one cell, in symbols and in numbers, and how far the values are from satisfying all."""

from html import escape

import numpy as np

from course_lib.bellman import action_values, bellman_sweep
from course_lib.explore.controls import Panel
from course_lib.explore.drawing.board import ARROWS, place
from course_lib.explore.drawing.chart import Chart
from course_lib.explore.numerals import numeral
from course_lib.explore.worlds import counted
from course_lib.maze import Action, Tile
from course_lib.plots.board import best_actions

STEADY = 1e-9  # values that a sweep moves by less satisfy their equations
_FIRST_SWEEPS = 12  # so many have room in the chart of errors at least
_NO_LINE = "border-bottom:0;padding-bottom:0"  # an action and its formula stand together, a line below both
_BELOW = "padding-left:16px;padding-top:0"
_SHARES = {1: "1", 2: "1/2", 3: "1/3", 4: "1/4"}  # among so many best actions a cell is shared


class Equation:
    """V(s) ← Σ_a π(a | s) Q(s, a) with Q(s, a) = R(s, a) + γ Σ_s' T(s, a, s') V(s'), for one cell s of a maze.

    values: V, float[S]; policy: π, float[S, A], equal shares of some actions; gamma: γ.
    q        float[A], the Q(s, a); result: what a sweep writes into the cell, to the last bit
    """

    def __init__(self, world, values, policy, gamma, cell):
        self.world, self.values, self.gamma, self.cell = world, values, gamma, cell
        self.shares = policy[cell]
        self.q = action_values(world.mdp, values, gamma)[cell]
        self.result = float(bellman_sweep(world.mdp, values, gamma, policy)[cell])

    @property
    def holds(self):
        """Whether both sides are equal, up to rounding."""
        return abs(self.result - self.values[self.cell]) <= STEADY

    def terms(self, action):
        """[(probability, name of the value, the value)] of an action's next states; an end has the value 0."""
        mdp, row, chances = self.world.mdp, (self.cell, int(action)), {}
        for s, chance, ends in zip(mdp.next_state[row], mdp.probability[row], mdp.terminal[row], strict=True):
            name = "V(end)" if ends else f"V({s})"
            before, _ = chances.get(name, (0.0, 0.0))
            chances[name] = (before + float(chance), 0.0 if ends else float(self.values[s]))
        return [(chance, name, value) for name, (chance, value) in chances.items() if chance]

    def symbols(self, action):
        """The right-hand side of Q(s, a) with the next states' names: R + γ (0.8 V(5) + 0.2 V(1))."""
        terms = [
            name if chance == 1 else f"{written(chance)}\N{NO-BREAK SPACE}{name}"
            for chance, name, _ in self.terms(action)
        ]
        return f"R + γ {terms[0]}" if len(terms) == 1 else f"R + γ ({' + '.join(terms)})"

    def numbers(self, action):
        """The same with the numbers put in."""
        terms = self.terms(action)
        inner = [("" if p == 1 else f"{written(p)}·") + _factor(value) for p, _, value in terms]
        following = inner[0] if len(terms) == 1 else f"({' + '.join(inner)})"
        return f"{written(self.world.mdp.R[self.cell, action])} + {written(self.gamma)}·{following}"

    def sum(self):
        """The right-hand side of V(s): the mean of Q over the policy's actions."""
        taken = np.flatnonzero(self.shares)
        if len(taken) == 1:
            return f"Q({self.cell}, {Action(taken[0]).name.lower()})"
        return f"{_SHARES[len(taken)]}·(" + " + ".join(_factor(self.q[a]) for a in taken) + ")"

    def in_words(self):
        """One line: what stands there, and what a sweep will write."""
        if self.world.grid.flat[self.cell] == Tile.WALL:
            return f"Cell {self.cell} is a wall: nobody gets in, so it has no equation."
        if self.cell in self.world.goals:
            return f"Cell {self.cell} holds a cheese: the episode is over there, so its value is 0."
        now, then = written(self.values[self.cell]), written(self.result)
        if self.holds:
            return f"Cell {self.cell} is worth {now}: its equation holds."
        return f"Cell {self.cell} is worth {now}; the next sweep will write {then}."

    def panel(self):
        """The equation as a text to be read."""
        head = f"<p><b>{escape(place(self.world, self.cell).capitalize())}</b></p>"
        if self.world.grid.flat[self.cell] == Tile.WALL or self.cell in self.world.goals:
            return Panel("equation", html=f"{head}<p>{escape(self.in_words())}</p>")
        best = best_actions(self.q)
        best = best if len(best) < len(Action) else []
        rows = "".join(self._row(a, a in best) for a in Action)
        lines = (
            "V(s) ← Σ<sub>a</sub> π(a | s) Q(s, a)",
            "Q(s, a) = R(s, a) + γ Σ<sub>s'</sub> T(s, a, s') V(s')",
        )
        columns = "".join(f'<th scope="col">{name}</th>' for name in ("action a", "π(a | s)", "Q(s, a)"))
        table = f"<table><tr>{columns}</tr>{rows}</table>"
        result = f"V({self.cell}) ← {self.sum()} = <b>{written(self.result)}</b>"
        star = "★ best: what “improve” takes." if len(best) else "All four are alike: none is best."
        told = f"{star} Numbers are rounded to four decimals."
        html = f"{head}<p>{'<br>'.join(lines)}</p>{table}<p>{result}<br>{escape(self.in_words())}</p><p>{told}</p>"
        return Panel("equation", html=html)

    def _row(self, action, is_best):
        share = _SHARES[np.count_nonzero(self.shares)] if self.shares[action] else "0"
        value = f"<b>{written(self.q[action])} ★</b>" if is_best else written(self.q[action])
        first, second = (f"<span style='display:inline-block'>{escape(text)}</span>" for text in self._sums(action))
        head = f'<th scope="row" style="font-weight:400;text-align:left;{_NO_LINE}">{ARROWS[action]}</th>'
        cells = "".join(f'<td style="{_NO_LINE}">{text}</td>' for text in (share, value))  # what is bold is best
        return f'<tr>{head}{cells}</tr><tr><td colspan="3" style="{_BELOW}">{first} {second}</td></tr>'

    def _sums(self, action):
        """Q(s, a) in symbols and in numbers, the second below the first where both have no room side by side."""
        return self.symbols(action), f"= {self.numbers(action)}"


def error_chart(errors, gamma):
    """The largest error after 0, 1, 2, … sweeps of a policy, below the bound that γ gives."""
    errors, sweeps = [error if error > STEADY else 0.0 for error in errors], len(errors) - 1
    top = 10.0 ** np.ceil(np.log10(errors[0])) if errors[0] else 1.0
    last = max(_FIRST_SWEEPS, sweeps)
    chart = Chart(
        "How far V is from the policy's own values", x=(-0.5, last), y=(top * 1e-4, top), log=True,
        xlabel="sweeps k of this policy", ylabel="largest error of any cell (log scale)", height=170, legend=2,
    )  # fmt: skip
    bound = errors[0] * gamma ** np.arange(last + 1.0)
    seen = np.flatnonzero(bound >= top * 1e-4)
    chart.line(seen, bound[seen], 1)
    there = [k for k, error in enumerate(errors) if error >= top * 1e-4]
    chart.points(np.array(there), np.array(errors)[there])
    if not errors[-1]:
        chart.note(last / 2, top * 1e-2, "No error is left.")
    elif sweeps in there:
        chart.note(sweeps, errors[-1] * 0.3, f"{errors[-1]:.2g}", shift=20)  # below the line of the bound
    chart.legend("after k sweeps", 0, kind="circle")
    chart.legend("never above: the first error times γ to the power k", 1)
    told = "; ".join(f"{counted(k, 'sweep')}: {errors[k]:.2g}" for k in sorted({*range(0, sweeps, 10), sweeps}))
    words = f"The largest distance of V from this policy's own values after {told}. At most the first times γ^k."
    return Panel("errors", words, chart.svg())


def written(number):
    """A number with at most four decimals."""
    return numeral(round(round(float(number), 12), 4) + 0.0, ".7g")


def _factor(number):
    return f"({written(number)})" if number < 0 and written(number) != "0" else written(number)
