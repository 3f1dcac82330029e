"""Errors that the user can correct."""


class VisionError(Exception):
    """Wrong file, argument or camera; the text names the place and the expected value."""
