"""Cameras by vision lines and pictures."""
