"""A network as a picture: every node, the lines that matter, and bars beside the truth."""

import re

import numpy as np
import pytest

from course_lib.explore.drawing import nodes


def texts(svg):
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


def test_forward_is_two_layers_with_relu_between():
    layers = [(np.array([[1.0, -2.0]]), np.array([0.5, 0.5])), (np.array([[3.0], [7.0]]), np.array([-1.0]))]
    arriving, outputs = nodes.forward(layers, np.array([[1.0], [0.0]]))
    assert arriving.tolist() == [[1.5, -1.5], [0.5, 0.5]]
    assert outputs.tolist() == [[3.5], [4.0]]


def test_the_input_that_is_1_stands_out():
    layers = [(np.ones((3, 1)), np.zeros(1)), (np.ones((1, 2)), np.zeros(2))]
    svg = nodes.network(layers, 1, ("a", "b"), "title")
    assert texts(svg)[:10] == ["title", "inputs", "hidden nodes: 1 of 1 speak", "outputs", "0", "0", "1", "1", "0", "2"]
    fills = re.findall(r'<circle [^>]*fill="([^"]*)"', svg.split("</defs>")[1])
    assert [fills[i] == fills[0] for i in range(3)] == [True, False, True]


def test_dead_nodes_are_silent_whatever_goes_in():
    weights = np.array([[1.0, -1.0, -1.0], [-1.0, -1.0, 0.5]])
    layers = [(weights, np.array([0.0, 0.5, 0.0])), (np.ones((3, 2)), np.array([0.0, 1.0]))]
    assert nodes.dead_nodes(layers).tolist() == [False, True, False]
    written = texts(nodes.network(layers, 0, ("a", "b"), "title"))
    assert (written.count("dead"), written.count("silent"), written.count("1.00")) == (1, 1, 2)
    assert written[-3:-2] == ["the best"]


def test_lines_to_the_best_output_are_what_it_is_made_of():
    weights = np.array([[1.0, 0.5, -1.0]])
    layers = [(weights, np.zeros(3)), (np.array([[1.0, 0.0], [-2.0, 0.0], [9.0, 9.0]]), np.array([5.0, 0.0]))]
    drawn = re.findall(r"<polyline[^>]*>", nodes.network(layers, 0, ("a", "b"), ""))
    lines = [line for line in drawn if "stroke-opacity" in line]
    assert [("dasharray" in line) for line in lines] == [False, False, True, False, True], "1, 0.5 and -1; 1 and -1"
    assert [re.search(r'width="([\d.]+)"', line)[1] for line in lines] == ["2.8", "1.6", "2.8", "2.8", "2.8"]


def test_bars_are_as_long_as_their_numbers():
    svg = nodes.answers(np.array([0.5, -0.25]), np.array([1.0, 0.25]), [3, 1000], ("a", "b"), "")
    bars = [float(width) for width in re.findall(r'<rect [^>]*width="([\d.]+)" height="14"', svg)]
    assert bars[1] == pytest.approx((nodes._BARS_TO - nodes._BARS) / 1.25, abs=0.02), (
        "there is room for -0.25 on the left"
    )
    assert bars == pytest.approx([bars[1] / 2, bars[1], bars[1] / 4, bars[1] / 4], abs=0.02)
    assert "tried 1,000×" in texts(svg)
    assert re.findall(r'font-weight="700">([^<]*)<', svg) == ["a", "0.50", "1.00"]
