"""A disk that is full for a while."""

import errno
import os
import pathlib

CHUNK = 1 << 20


class Ballast:
    """A file that takes all that is free on the disk of a folder."""

    def __init__(self, folder):
        self._path = pathlib.Path(folder) / "ballast"

    @property
    def is_full(self):
        return self._path.exists()

    def fill(self):
        """Until the disk has no room for another byte."""
        with open(self._path, "wb", buffering=0) as file:
            size = CHUNK
            while size > 0:
                try:
                    written = file.write(bytes(size))
                except OSError as error:
                    if error.errno != errno.ENOSPC:
                        raise
                    written = 0
                if written == 0:
                    size //= 2

    def remove(self):
        self._path.unlink(missing_ok=True)
        os.sync()
