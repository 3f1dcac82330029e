"""The motion of a copy: from measured postures to points of a stream."""
