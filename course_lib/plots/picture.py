"""A finished figure that knows how to show itself: an image with words for those who cannot see it."""

import base64
import io
from html import escape

PAPER, INK, FAINT = "#fdfdfb", "#22262b", "#8a9099"
# Okabe and Ito's palette, told apart by every kind of colour vision
BLUE, ORANGE, GREEN, PINK, SKY, RED, YELLOW = (
    "#0072b2",
    "#e69f00",
    "#009e73",
    "#cc79a7",
    "#56b4e9",
    "#d55e00",
    "#f0e442",
)
PALETTE = (BLUE, RED, GREEN, PINK, ORANGE, SKY)
LINE_STYLES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))

_POINTS = {"title": 12, "label": 11, "tick": 10}
_DOTS_PER_INCH, _SHOWN_PER_INCH = 180, 90


class Picture:
    """A matplotlib `figure` and its text alternative, `alt`. As the last value of a cell it shows itself."""

    def __init__(self, figure, alt):
        self.figure, self.alt = figure, " ".join(alt.split())

    def __repr__(self):
        return f"Picture: {self.alt}"

    def png(self):
        """The picture as the bytes of a PNG file, in few colours so that notebooks stay small."""
        from PIL import Image

        drawn = io.BytesIO()
        self.figure.savefig(drawn, format="png", dpi=_DOTS_PER_INCH, facecolor=PAPER)
        small = io.BytesIO()
        Image.open(drawn).convert("RGB").quantize(colors=96, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
        return small.getvalue()

    def _repr_mimebundle_(self, include=None, exclude=None):  # noqa: ARG002 (IPython's signature)
        data = base64.b64encode(self.png()).decode()
        width = round(self.figure.get_figwidth() * _SHOWN_PER_INCH)
        look = f'width="{width}" style="max-width:100%;height:auto"'
        html = f'<img alt="{escape(self.alt)}" {look} src="data:image/png;base64,{data}">'
        return {"text/html": html, "text/plain": repr(self)}


def new_figure(width, height, *, columns=1):
    """A figure on paper of its own (so it reads on dark pages too) and its axes, one or a list."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure((width, height), facecolor=PAPER, layout="constrained")
    FigureCanvasAgg(figure)
    axes = [figure.add_subplot(1, columns, i + 1, facecolor=PAPER) for i in range(columns)]
    return figure, axes[0] if columns == 1 else axes


def dress(axes, *, title="", xlabel="", ylabel="", legend=False):
    """Titles, labels, a quiet grid and an open frame."""
    axes.set_title(title, fontsize=_POINTS["title"], color=INK, loc="left", pad=10)
    axes.set_xlabel(xlabel, fontsize=_POINTS["label"], color=INK)
    axes.set_ylabel(ylabel, fontsize=_POINTS["label"], color=INK)
    axes.tick_params(labelsize=_POINTS["tick"], colors=INK)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color=FAINT, alpha=0.25)
    axes.set_axisbelow(True)
    if legend:
        axes.legend(fontsize=_POINTS["tick"], frameon=False, labelcolor=INK)
