"""The detection on pictures of random layouts: trays of any type, any number of gears, any label."""

import unittest

from stack import cv2  # noqa: F401  skips without OpenCV

from random_pictures import OwnVision, PicturedCell, Score, compare_layouts, layouts_from

LAYOUTS = 2


class RandomLayoutTest(unittest.TestCase):
    def test_trays_slots_and_poses_are_right(self):
        score = Score()
        with PicturedCell() as shown:
            compare_layouts(OwnVision(shown), shown, layouts_from(1, LAYOUTS, gap_mm=4), score)
        self.assertEqual(score.troubles, [])
        self.assertEqual(score.extra, 0)
        self.assertGreater(score.trays, 4 * LAYOUTS)
        self.assertEqual(score.found, score.trays)
        self.assertEqual(score.right_slots, score.slots)
        self.assertLess(max(score.away_mm), 1.0)
        self.assertLess(max(score.turn_deg), 0.5)


if __name__ == "__main__":
    unittest.main()
