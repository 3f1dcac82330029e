"""Errors of data sets."""

from __future__ import annotations

from ..errors import AprsimError


class DatasetError(AprsimError):
    """A data set cannot be written or read; the text names the file and the part."""
