"""Explorers without a browser: what they show, and what their controls do to it."""

from pathlib import Path

import nbformat


def minus(written):
    """A number as Python writes it, with the minus sign of the explorers."""
    return written.replace("-", "−")


def prose(notebook):
    """All that a notebook says to its readers, code and outputs left out."""
    path = Path(__file__).parents[2] / "notebooks" / notebook
    return "\n".join(cell.source for cell in nbformat.read(path, as_version=4).cells if cell.cell_type == "markdown")
