"""A small neural network as SVG: what goes in, what every hidden node lets through, and what it answers."""

import numpy as np

from course_lib.explore.drawing.sketch import WIDTH, Sketch
from course_lib.explore.numerals import two_places
from course_lib.plots.picture import BLUE, FAINT, INK, PAPER, RED

QUIET = "#5f646b"  # words that matter less; 5.9 to 1 on paper
_TOP, _TALL = 56, 340  # of the columns of nodes
_IN, _HIDDEN, _LONGEST, _ON, _OUT = 34, 116, 38, 186, 262  # where they stand across: inputs, bars, lines on, outputs
_ROW, _BARS, _BARS_TO = 46, 84, 296  # a row of the answers, and the room for its bars


def forward(layers, inputs):
    """(what arrives at the hidden nodes, the outputs) of a network with one hidden layer (ReLU).

    layers   [(weights float[n, m], biases float[m]), …], two of them;  inputs   float[…, n]
    """
    (weights_1, biases_1), (weights_2, biases_2) = layers
    arriving = inputs @ weights_1 + biases_1
    return arriving, np.maximum(arriving, 0) @ weights_2 + biases_2


def dead_nodes(layers):
    """bool[m]: the hidden nodes that are silent whichever of the one-hot inputs is 1."""
    weights, biases = layers[0]
    return (weights + biases <= 0).all(axis=0)


def network(layers, state, output_names, title):
    """The network when input number `state` is 1 and all others are 0; lines as in `plots.forward_pass`.

    Of the lines to the outputs only those to the best one are drawn: what makes it so.
    """
    (weights_1, _), (weights_2, _) = layers
    arriving, outputs = forward(layers, np.eye(len(weights_1))[state])
    passed, best = np.maximum(arriving, 0), int(outputs.argmax())
    sketch = Sketch(_TOP + _TALL + 62)
    sketch.text(6, 14, title, size=15, anchor="start", font_weight="600")
    for x, heading in (
        (_IN, "inputs"),
        (_HIDDEN + 42, f"hidden nodes: {(arriving > 0).sum()} of {len(arriving)} speak"),
        ((_OUT + WIDTH - 6) / 2, "outputs"),
    ):
        sketch.text(x, _TOP - 16, heading, size=12)
    rows_in, rows, rows_out = (_spread(n) for n in (len(weights_1), len(arriving), len(outputs)))
    _lines(sketch, (_IN, [rows_in[state]] * len(rows)), (_HIDDEN - 3, rows), weights_1[state])
    _lines(sketch, (_ON, rows), (_OUT, [rows_out[best]] * len(rows)), passed * weights_2[:, best])
    for i, y in enumerate(rows_in):
        on = i == state
        sketch.circle(_IN, y, 8, fill=BLUE if on else "#ffffff", stroke=INK if on else FAINT)
        sketch.text(_IN, y, int(on), size=11.5, colour="#ffffff" if on else QUIET, font_weight="700" if on else None)
        sketch.text(_IN - 13, y, i, size=11, anchor="end", font_weight="700" if on else None)
    largest = max(1.0, float(passed.max()))
    for value, dead, y in zip(passed, dead_nodes(layers), rows, strict=True):
        if value > 0:
            long = float(value) / largest * _LONGEST
            sketch.rect(_HIDDEN, y - 5.5, long, 11, fill=BLUE, stroke=INK, stroke_width=0.8)
            sketch.text(_HIDDEN + long + 4, y, two_places(value), size=11, anchor="start")
        else:
            sketch.rect(_HIDDEN, y - 5.5, 11, 11, fill=PAPER, stroke=INK, stroke_width=0.8, stroke_dasharray="2 2")
            sketch.text(_HIDDEN + 16, y, "dead" if dead else "silent", size=11, anchor="start", colour=QUIET)
            if dead:
                sketch.line([(_HIDDEN + 2, y - 3.5), (_HIDDEN + 9, y + 3.5)], stroke=INK)
                sketch.line([(_HIDDEN + 2, y + 3.5), (_HIDDEN + 9, y - 3.5)], stroke=INK)
    for a, (name, y) in enumerate(zip(output_names, rows_out, strict=True)):
        look = {"stroke": RED, "stroke_width": 3} if a == best else {"stroke": FAINT}
        sketch.rect(_OUT, y - 24, WIDTH - 6 - _OUT, 48, rx=5, fill="#ffffff", **look)
        weight = "700" if a == best else None
        sketch.text((_OUT + WIDTH - 6) / 2, y - 10, name, font_weight=weight)
        sketch.text((_OUT + WIDTH - 6) / 2, y + 11, two_places(outputs[a]), size=15, font_weight=weight)
        if a == best:
            sketch.text((_OUT + WIDTH - 6) / 2, y + 34, "the best", size=12)
    legend = (
        "Lines: solid blue adds, dashed orange takes away;",
        f"the thicker, the more. On the right only those to {output_names[best]}.",
    )
    for i, line in enumerate(legend):
        sketch.text(6, _TOP + _TALL + 26 + 17 * i, line, size=12, anchor="start")
    return sketch.svg()


def answers(q, exact, tries, output_names, title):
    """Bars: what a network says of every action in one state, and what is true; the best ones in bold.

    q   float[A];  exact   float[A], or None where nobody ever acts;  tries   int[A], how often each was taken
    """
    shown = [q] if exact is None else [q, exact]
    low, high = min(0.0, *map(np.min, shown)), max(1.0, *map(np.max, shown))
    sketch = Sketch(34 + _ROW * len(q) + 30)
    sketch.text(6, 14, title, size=15, anchor="start", font_weight="600")

    def across(value):
        return _BARS + (float(value) - low) / (high - low) * (_BARS_TO - _BARS)

    for a, name in enumerate(output_names):
        y = 34 + _ROW * a
        sketch.text(6, y + 12, name, anchor="start", font_weight="700" if q[a] == q.max() else None)
        sketch.text(6, y + 29, f"tried {tries[a]:,}×", size=11, anchor="start", colour=QUIET)
        _bar(sketch, across, y + 3, q[a], q[a] == q.max(), fill=BLUE)
        if exact is not None:
            _bar(sketch, across, y + 21, exact[a], exact[a] > exact.max() - 1e-9, fill="url(#dotted)")
    sketch.line([(across(0), 30), (across(0), 34 + _ROW * len(q) - 6)], stroke=INK)
    y = 34 + _ROW * len(q) + 10
    sketch.rect(6, y - 6, 22, 12, fill=BLUE, stroke=INK)
    sketch.text(34, y, "the network", size=12, anchor="start")
    if exact is None:
        sketch.text(126, y, "Nobody ever acts here.", size=12, anchor="start")
    else:
        sketch.rect(126, y - 6, 22, 12, fill="url(#dotted)", stroke=INK)
        sketch.text(154, y, "exact; bold: the best", size=12, anchor="start")
    return sketch.svg()


def _spread(number):
    """The heights of so many nodes in a column."""
    return [_TOP + _TALL * (i + 0.5) / number for i in range(number)]


def _lines(sketch, here, there, flows):
    (x, ys), (to_x, to_ys) = here, there
    largest = float(np.abs(flows).max()) or 1.0
    for y, to_y, flow in zip(ys, to_ys, flows.tolist(), strict=True):
        if abs(flow) > 0.02 * largest:
            look = {"stroke": BLUE} if flow > 0 else {"stroke": RED, "stroke_dasharray": "4 3"}
            width = 0.4 + 2.4 * abs(flow) / largest
            look |= {"stroke_width": width, "stroke_opacity": 0.75, "stroke_linejoin": None}  # nothing is joined
            sketch.line([(x, y), (to_x, to_y)], **look)


def _bar(sketch, across, y, value, best, **look):
    start, end = sorted((across(0), across(value)))
    sketch.rect(start, y, max(end - start, 1.0), 14, stroke=INK, stroke_width=0.8, **look)
    sketch.text(WIDTH - 6, y + 7, two_places(value), anchor="end", font_weight="700" if best else None)
