"""Pictures of the cell's cameras as numpy arrays, and the cameras' lenses and poses. The camera frame C has
x to the right of the picture, y down, z along the view."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Iterator, Literal, get_args

import numpy as np
import numpy.typing as npt

from . import arguments, calls
from .errors import AprsimError
from .poses import Array, matrix
from .snapshots import seconds
from .v1 import camera_service_pb2 as messages

if TYPE_CHECKING:
    from .v1 import camera_service_pb2, cell_pb2

Content = Literal["rgb", "depth", "depth_16", "segmentation", "normals"]
"""rgb: 3 bytes a pixel; depth: metres along z; depth_16: tenths of millimetres; segmentation: numbers of
objects; normals: unit vectors in the world."""
Pixels = npt.NDArray[Any]

_FORMATS = {
    "rgb": messages.IMAGE_FORMAT_RGB,
    "depth": messages.IMAGE_FORMAT_DEPTH_FLOAT,
    "depth_16": messages.IMAGE_FORMAT_DEPTH_16,
    "segmentation": messages.IMAGE_FORMAT_SEGMENTATION,
    "normals": messages.IMAGE_FORMAT_NORMALS,
    "png": messages.IMAGE_FORMAT_PNG,
    "jpeg": messages.IMAGE_FORMAT_JPEG,
}
_TYPES = {
    "rgb": ("u1", 3),
    "depth": ("<f4", 1),
    "depth_16": ("<u2", 1),
    "segmentation": ("<u2", 1),
    "normals": ("<f4", 3),
}
_KINDS = ("nothing", "body", "robot", "tool", "fixed", "belt", "floor", "intruder")


@dataclass(frozen=True)
class SeenObject:
    """An object in segmented pictures."""

    kind: str
    """nothing, body, robot, tool, fixed, belt, floor or intruder."""
    name: str
    """Its name in the cell; empty for nothing and the floor."""


@dataclass(frozen=True)
class Picture:
    """A picture of one instant."""

    camera: str
    epoch: int
    step: int
    sim_time_s: float
    pixels: Pixels
    """Rows from the top: (height, width) or (height, width, 3). Read-only."""
    X_WC: Array
    """The pose of the camera frame C in the world W at this step."""
    objects: tuple[SeenObject, ...] = ()
    """The objects by their numbers in a segmented picture."""


class CameraBase:
    """The lens and the pose of a camera."""

    def __init__(self, description: cell_pb2.CameraDescription) -> None:
        self.description = description

    @property
    def name(self) -> str:
        """The camera's name in the scene."""
        return self.description.name

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.description.width_px, self.description.height_px

    @property
    def carrier(self) -> str:
        """The robot on whose flange it is mounted; empty = it is fixed."""
        return self.description.carrier

    @property
    def X_WC(self) -> Array:
        """The pose of the camera frame C in the world W. Raises AprsimError for a camera on a flange."""
        if self.carrier:
            raise AprsimError(f"{self.name} moves with {self.carrier}; each of its pictures has X_WC")
        return matrix(self.description.camera_in_world)

    @property
    def X_FC(self) -> Array:
        """The pose of the camera frame C in the flange F. Raises AprsimError for a fixed camera."""
        if not self.carrier:
            raise AprsimError(f"{self.name} is fixed; it has X_WC")
        return matrix(self.description.camera_in_flange)

    @property
    def intrinsics(self) -> Array:
        """The 3 x 3 matrix of focal lengths and principal point, as OpenCV has it [px]."""
        lens = self.description
        return np.array(
            [
                [lens.focal_x_px, 0.0, lens.centre_x_px],
                [0.0, lens.focal_y_px, lens.centre_y_px],
                [0.0, 0.0, 1.0],
            ]
        )

    @property
    def distortion(self) -> Array:
        """Brown's distortion in OpenCV's order: k1, k2, p1, p2, k3."""
        return np.array(self.description.distortion)


class Camera(CameraBase):
    """A camera of a blocking cell. Each call takes a picture of the latest state."""

    def __init__(
        self,
        description: cell_pb2.CameraDescription,
        run: Callable[[calls.Call[Any]], Any],
        stream: Callable[[calls.Service, str, Any], Iterator[Any]],
    ) -> None:
        super().__init__(description)
        self._run, self._stream = run, stream

    def rgb(self) -> npt.NDArray[np.uint8]:
        """Colours: (height, width, 3), red, green and blue."""
        return self.picture("rgb").pixels

    def depth(self) -> npt.NDArray[np.float32]:
        """Distance along the camera's z axis [m]; 0 = nothing there."""
        return self.picture("depth").pixels

    def segmentation(self) -> npt.NDArray[np.uint16]:
        """Numbers of the visible objects; `objects` has their names."""
        return self.picture("segmentation").pixels

    def normals(self) -> npt.NDArray[np.float32]:
        """Unit normals of the surfaces in the world: (height, width, 3); 0 = nothing there."""
        return self.picture("normals").pixels

    def objects(self) -> tuple[SeenObject, ...]:
        """The objects of the running scene by their numbers in segmented pictures."""
        return self.picture("segmentation").objects

    def jpeg(self) -> bytes:
        """Colours as a JPEG file of the camera's quality."""
        data: bytes = self._run(get_file(self.name, "jpeg"))
        return data

    def png(self) -> bytes:
        """Colours as a PNG file."""
        data: bytes = self._run(get_file(self.name, "png"))
        return data

    def picture(self, content: Content = "rgb") -> Picture:
        """A picture with its step and time."""
        picture: Picture = self._run(get_picture(self.name, content))
        return picture

    def stream(self, content: Content = "rgb", hz: float | None = None) -> Iterator[Picture]:
        """Pictures at `hz` per second of wall time, at most 60, or at the camera's rate, until the loop
        ends. A slow reader misses some and gets the latest. A paused cell repeats its picture."""
        request = stream_request(self.name, content, hz)
        for answer in self._stream("Camera", "StreamImages", request):
            yield picture_of(answer.image, content)


def list_cameras() -> calls.Call[list[cell_pb2.CameraDescription]]:
    """The call that lists the cameras."""

    def read(answer: Any) -> list[cell_pb2.CameraDescription]:
        return list(answer.cameras)

    return calls.Call("Camera", "ListCameras", messages.ListCamerasRequest(), read)


def get_picture(camera: str, content: Content) -> calls.Call[Picture]:
    """The call that takes a picture."""
    request = messages.GetImageRequest(camera=camera, format=_format(content))
    return calls.Call(
        "Camera", "GetImage", request, lambda answer: picture_of(answer.image, content)
    )


def get_file(camera: str, kind: Literal["jpeg", "png"]) -> calls.Call[bytes]:
    """The call that takes a picture as a file."""
    request = messages.GetImageRequest(camera=camera, format=_FORMATS[kind])
    return calls.Call("Camera", "GetImage", request, lambda answer: bytes(answer.image.data))


def stream_request(camera: str, content: Content, hz: float | None) -> Any:
    """The request of a stream; `hz` None = the camera's rate."""
    rate = 0.0 if hz is None else arguments.number("hz", hz, "Hz", above=0)
    return messages.StreamImagesRequest(camera=camera, format=_format(content), rate_hz=rate)


def picture_of(image: camera_service_pb2.Image, content: Content) -> Picture:
    """A message's picture; the array shares its bytes."""
    kind, channels = _TYPES[content]
    shape = (image.height_px, image.width_px, channels)[: 3 if channels > 1 else 2]
    return Picture(
        image.camera,
        image.epoch,
        image.step,
        seconds(image.sim_time),
        np.frombuffer(image.data, dtype=kind).reshape(shape),
        matrix(image.camera_in_world),
        tuple(SeenObject(_KINDS[seen.kind], seen.name) for seen in image.objects),
    )


def camera_named(
    cameras: list[cell_pb2.CameraDescription], name: str
) -> cell_pb2.CameraDescription:
    """Raises AprsimError with the names there are."""
    named = {camera.name: camera for camera in cameras}
    if name not in named:
        raise AprsimError(f"the cell has no camera '{name}'; there is {', '.join(named) or 'none'}")
    return named[name]


def _format(content: Content) -> Any:
    if content not in get_args(Content):
        raise arguments.wrong("content", content, ", ".join(get_args(Content)))
    return _FORMATS[content]
