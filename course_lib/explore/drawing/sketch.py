"""Pictures as SVG text, quick enough to be drawn anew at every move of a slider."""

from functools import cache
from html import escape

from course_lib.plots.picture import INK, PAPER

WIDTH = 360  # of every picture, in its own pixels: the width that a narrow page has for it
TEXT = 13  # pixels


class Sketch:
    """A picture under construction: x grows to the right, y downwards. Looks are SVG's attributes, `_` for `-`."""

    def __init__(self, height, width=WIDTH):
        self.width, self.height, self._parts = width, height, []

    def add(self, shape, content=None, **look):
        """Any SVG element."""
        attributes = "".join(
            f' {name.replace("_", "-")}="{_written(value)}"' for name, value in look.items() if value is not None
        )
        self._parts.append(
            f"<{shape}{attributes}/>" if content is None else f"<{shape}{attributes}>{content}</{shape}>"
        )

    def rect(self, x, y, width, height, **look):
        """A rectangle by its upper left corner."""
        self.add("rect", x=x, y=y, width=width, height=height, **look)

    def circle(self, x, y, radius, **look):
        """A circle by its middle."""
        self.add("circle", cx=x, cy=y, r=radius, **look)

    def line(self, points, *, closed=False, **look):
        """A line through `points`, [(x, y)], or the shape that it encloses."""
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        look = look if closed else {"fill": "none", "stroke_linejoin": "round"} | look
        self.add("polygon" if closed else "polyline", points=corners, **look)

    def text(self, x, y, words, *, size=TEXT, anchor="middle", colour=INK, **look):
        """Words whose middle (or "start", "end") stands at x, and whose middle height at y."""
        self.add(
            "text", escape(str(words)), x=x, y=y + 0.35 * size, font_size=size, text_anchor=anchor, fill=colour, **look
        )

    def svg(self):
        """The picture as text. Nothing in it can be selected or focused; its words stand beside it."""
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}"'
            f' font-family="system-ui, -apple-system, Segoe UI, Roboto, Helvetica, Arial, sans-serif">'
            f'<rect width="{self.width}" height="{self.height}" fill="{PAPER}"/>{_HATCHES}{"".join(self._parts)}</svg>'
        )


# What is told apart by colour is told apart by a hatching, too.
_HATCHES = (
    '<defs><pattern id="slanted" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">'
    '<rect width="8" height="8" fill="#4a4f57"/><rect width="2.5" height="8" fill="#6a7079"/></pattern>'
    '<pattern id="dotted" width="8" height="8" patternUnits="userSpaceOnUse">'
    '<circle cx="4" cy="4" r="1.3" fill="#56b4e9"/></pattern></defs>'
)


def _written(value):
    return f"{value:.2f}".rstrip("0").rstrip(".") if isinstance(value, float) else escape(str(value))


@cache
def shades(name="viridis"):
    """256 pairs of a colour, from low to high, and the ink that is readable on it."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    from course_lib.plots.board import readable_on

    ink = readable_on(name, 0, 255)
    return [(to_hex(colormaps[name](i)), {"white": "#ffffff", "black": "#000000"}[ink(i)]) for i in range(256)]


def shade(value, low, high, name="viridis"):
    """The colour of `value` between `low` and `high`, and the ink that is readable on it."""
    place = 0.5 if high <= low else (value - low) / (high - low)
    return shades(name)[int(min(max(place, 0.0), 1.0) * 255)]
