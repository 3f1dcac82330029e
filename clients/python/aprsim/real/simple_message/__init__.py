"""Robots by ROS-Industrial's Simple Message."""
