"""Lessons in a real JupyterLab, looked at through a real browser."""
