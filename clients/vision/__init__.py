"""An example of a vision stack: finds trays and gears in the pictures of the overhead cameras."""
