"""The cart and its pole."""

import numpy as np

from course_lib.plots.picture import BLUE, INK, ORANGE, RED, Picture, new_figure

_EDGE, _TIPPED, _CART, _POLE = 2.4, 12 * np.pi / 180, 0.5, 1.0  # as CartPole-v1 has them: metres, radians


def cart_pole(moments, *, title="", words=None):
    """CartPole-v1 at several moments, side by side; moments: {heading: (position, speed, angle, angular speed)}.

    Position in metres from the middle of the track, angle in radians from upright, to the right. words: a text
    alternative of your own, for numbers that another processor may round otherwise.
    """
    figure, panels = new_figure(2.2 * len(moments) + 0.4, 2.3, columns=len(moments))
    said = []
    for axes, (heading, (position, _, angle, _)) in zip(np.atleast_1d(panels), moments.items(), strict=True):
        over = abs(position) > _EDGE or abs(angle) > _TIPPED
        axes.plot([-_EDGE, _EDGE], [0, 0], color=INK, linewidth=1.5)
        axes.plot([-_EDGE, -_EDGE, np.nan, _EDGE, _EDGE], [-0.2, 0.3, np.nan, -0.2, 0.3], color=RED, linewidth=2)
        axes.plot([position - _CART / 2, position + _CART / 2], [0.15, 0.15], color=BLUE, linewidth=9)
        tip = position + _POLE * np.sin(angle), 0.2 + _POLE * np.cos(angle)
        axes.plot([position, tip[0]], [0.2, tip[1]], color=ORANGE, linewidth=5, solid_capstyle="round")
        axes.set_xlim(-_EDGE - 0.3, _EDGE + 0.3)
        axes.set_ylim(-0.4, 1.6)
        axes.set_aspect("equal")
        axes.axis("off")
        axes.set_title(heading, fontsize=10, color=INK)
        axes.text(0, -0.75, f"{position:+.2f} m, {np.degrees(angle):+.1f}°", fontsize=9, color=INK, ha="center")
        said.append(
            f"{heading}: cart at {position:+.2f} m, pole at {np.degrees(angle):+.1f} degrees{', over' if over else ''}"
        )
    if title:
        figure.suptitle(title, fontsize=12, color=INK, x=0.01, ha="left")
    return Picture(figure, f"{title or 'A cart with a pole'}. {words or '; '.join(said) + '.'}")
