"""SVG written quickly enough to be drawn anew at every move: shapes, and over them mazes, charts and networks."""
