"""Robots by CRCL, and the mirror of any robot."""
