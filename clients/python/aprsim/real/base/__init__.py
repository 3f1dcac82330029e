"""Readers of real machines, and their comparison with simulated ones."""
