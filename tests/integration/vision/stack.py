"""Shared by the tests of clients/vision: the tree, and the skip without OpenCV."""

import os
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
PATIENCE = float(os.environ.get("APRSIM_PATIENCE", "1"))  # factor on deadlines
sys.path.insert(0, str(ROOT))

try:
    import cv2
except ImportError as error:
    raise unittest.SkipTest("OpenCV is missing: install python3-opencv") from error
