"""One camera's vision: from a picture to the objects in the frame of the robot's vision lines."""

from __future__ import annotations

import math

import cv2
import numpy as np

from .camera_map import CameraMap
from .errors import VisionError
from .gear_finder import GearFinder
from .prior import CameraPrior, Prior
from .publisher import SeenObject
from .tray_finder import TrayFinder


class Sight:
    def __init__(self, prior: Prior, camera: CameraPrior, camera_map: CameraMap) -> None:
        self._camera, self._map = camera, camera_map
        self._trays, self._gears = TrayFinder(prior, camera_map), GearFinder(prior, camera_map)

    def objects(self, jpeg: bytes) -> list[SeenObject]:
        """Trays and gears of a picture within the robot's view. Raises VisionError for a picture that is
        damaged or of another size than the camera's."""
        picture = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
        if picture is None:
            raise VisionError(f"{self._camera.name}: a picture is damaged")
        height, width = picture.shape[:2]
        if (width, height) != self._map.size_px:
            wanted = "{} x {}".format(*self._map.size_px)
            raise VisionError(
                f"{self._camera.name}: a picture of {width} x {height} pixels, where {wanted} is expected"
            )
        trays = self._trays.find(picture)
        found = []
        for tray in trays:
            kind = "KT" if tray.type.is_kit else "PT"
            pose = tray.pose
            found.append((tray.type.name, kind, pose.x_mm, pose.y_mm, pose.yaw, tray.score))
        for gear in self._gears.find(picture, trays).gears():
            # Gears look alike at each yaw.
            found.append((gear.type.name, "P", gear.x_mm, gear.y_mm, self._camera.base_yaw, gear.score))
        return [
            self._in_robot_frame(*values)
            for values in found
            if self._camera.in_view(np.array(values[2:4]))
        ]

    def _in_robot_frame(
        self, name: str, kind: str, x_mm: float, y_mm: float, yaw: float, score: float
    ) -> SeenObject:
        away = np.array([x_mm, y_mm]) - self._camera.base_mm
        c, s = math.cos(self._camera.base_yaw), math.sin(self._camera.base_yaw)
        return SeenObject(
            name,
            kind,
            float(c * away[0] + s * away[1]),
            float(c * away[1] - s * away[0]),
            math.remainder(yaw - self._camera.base_yaw, math.tau),
            score,
        )
