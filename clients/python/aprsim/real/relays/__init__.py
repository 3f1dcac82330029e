"""Ports for controllers, and what is passed to real and simulated machines."""
