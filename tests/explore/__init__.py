"""Explorers without a browser: what they show, and what their controls do to it."""
