"""ROS 2 messages out of times, poses and shapes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

from . import log, shapes
from .track import Pose, Way, nanoseconds

LEVELS = {"info": "INFO", "warning": "WARN", "error": "ERROR"}


class Messages:
    """Makes messages; `store` holds their types, by the definitions of ROS 2 Humble."""

    def __init__(self, root: str) -> None:
        self.store = get_typestore(Stores.ROS2_HUMBLE)
        self._root = root

    def transforms(self, t: float, frames: Iterable[tuple[str, float, float, float]]) -> Any:
        """A tf2_msgs/TFMessage: (frame, x, y, rotation) of each at `t` (seconds)."""
        header = self._header(t)
        transforms = [
            self._make(
                "geometry_msgs/msg/TransformStamped",
                header=header,
                child_frame_id=frame,
                transform=self._make(
                    "geometry_msgs/msg/Transform",
                    translation=self._vector(x, y, 0.0),
                    rotation=self._turned(rotation),
                ),
            )
            for frame, x, y, rotation in frames
        ]
        return self._make("tf2_msgs/msg/TFMessage", transforms=transforms)

    def pose(self, t: float, pose: Pose) -> Any:
        """A geometry_msgs/PoseStamped."""
        place = self._pose(pose.x, pose.y, 0.0, pose.rotation)
        return self._make("geometry_msgs/msg/PoseStamped", header=self._header(t), pose=place)

    def velocity(self, t: float, pose: Pose) -> Any:
        """A geometry_msgs/TwistStamped, along the axes of the floor."""
        twist = self._make(
            "geometry_msgs/msg/Twist",
            linear=self._vector(pose.vx, pose.vy, 0.0),
            angular=self._vector(0.0, 0.0, 0.0),
        )
        return self._make("geometry_msgs/msg/TwistStamped", header=self._header(t), twist=twist)

    def path(self, way: Way) -> Any:
        """A nav_msgs/Path."""
        header = self._header(way.t)
        poses = [
            self._make(
                "geometry_msgs/msg/PoseStamped", header=header, pose=self._pose(x, y, 0.0, rotation)
            )
            for x, y, rotation in way.points
        ]
        return self._make("nav_msgs/msg/Path", header=header, poses=poses)

    def log(self, line: log.Line) -> Any:
        """A rcl_interfaces/Log."""
        kind = self.store.types["rcl_interfaces/msg/Log"]
        return kind(
            stamp=self._stamp(line.t),
            level=getattr(kind, LEVELS[line.level]),
            name=line.name,
            msg=line.text,
            file="",
            function="",
            line=0,
        )

    def markers(self, t: float, things: Iterable[shapes.Thing], lifetime: float = 0.0) -> Any:
        """A visualization_msgs/MarkerArray; `lifetime` in seconds, 0 for ever."""
        markers = [
            self._marker(t, thing, number, shape, lifetime)
            for thing in things
            for number, shape in enumerate(thing.shapes)
        ]
        return self._make("visualization_msgs/msg/MarkerArray", markers=markers)

    def _marker(
        self, t: float, thing: shapes.Thing, number: int, shape: shapes.Shape, lifetime: float
    ) -> Any:
        kind: Any = self.store.types["visualization_msgs/msg/Marker"]
        red, green, blue, opacity = shape.color
        given: dict[str, Any] = {
            "pose": self._pose(0.0, 0.0, 0.0, 0.0),
            "points": [],
            "text": "",
            **self._form(shape),
        }
        return kind(
            header=self._header(t, thing.frame),
            ns=thing.name,
            id=number,
            action=kind.ADD,
            color=self._make("std_msgs/msg/ColorRGBA", r=red, g=green, b=blue, a=opacity),
            lifetime=self._make(
                "builtin_interfaces/msg/Duration",
                sec=int(lifetime),
                nanosec=round(lifetime % 1 * 1e9),
            ),
            frame_locked=True,
            colors=[],
            texture_resource="",
            texture=self._no_texture(),
            uv_coordinates=[],
            mesh_resource="",
            mesh_file=self._make(
                "visualization_msgs/msg/MeshFile", filename="", data=np.empty(0, np.uint8)
            ),
            mesh_use_embedded_materials=False,
            **given,
        )

    def _form(self, shape: shapes.Shape) -> dict[str, Any]:
        """The fields of a marker that say what it is."""
        kind: Any = self.store.types["visualization_msgs/msg/Marker"]
        if isinstance(shape, shapes.Block):
            pose = self._pose(*shape.center, shape.yaw)
            return {"type": kind.CUBE, "pose": pose, "scale": self._vector(*shape.size)}
        if isinstance(shape, shapes.Tube):
            scale = self._vector(2 * shape.radius, 2 * shape.radius, shape.height)
            return {"type": kind.CYLINDER, "pose": self._pose(*shape.center, 0.0), "scale": scale}
        if isinstance(shape, shapes.Arrow):
            scale = self._vector(shape.length, 0.12, 0.12)
            return {"type": kind.ARROW, "pose": self._pose(*shape.start, 0.0), "scale": scale}
        if isinstance(shape, shapes.Line):
            scale = self._vector(shape.width, 0.0, 0.0)
            return {"type": kind.LINE_STRIP, "points": self._points(shape.points), "scale": scale}
        if isinstance(shape, shapes.Surface):
            scale = self._vector(1.0, 1.0, 1.0)
            points = self._points(shape.points)
            return {"type": kind.TRIANGLE_LIST, "points": points, "scale": scale}
        return {
            "type": kind.TEXT_VIEW_FACING,
            "pose": self._pose(*shape.at, 0.0),
            "scale": self._vector(0.0, 0.0, shape.size),
            "text": shape.text,
        }

    def _no_texture(self) -> Any:
        return self._make(
            "sensor_msgs/msg/CompressedImage",
            header=self._header(0.0, ""),
            format="",
            data=np.empty(0, np.uint8),
        )

    def _header(self, t: float, frame: str | None = None) -> Any:
        name = self._root if frame is None else frame
        return self._make("std_msgs/msg/Header", stamp=self._stamp(t), frame_id=name)

    def _stamp(self, t: float) -> Any:
        seconds, rest = divmod(nanoseconds(t), 10**9)
        return self._make("builtin_interfaces/msg/Time", sec=seconds, nanosec=rest)

    def _pose(self, x: float, y: float, z: float, rotation: float) -> Any:
        return self._make(
            "geometry_msgs/msg/Pose",
            position=self._point(x, y, z),
            orientation=self._turned(rotation),
        )

    def _points(self, points: tuple[shapes.Point3, ...]) -> list[Any]:
        return [self._point(*point) for point in points]

    def _point(self, x: float, y: float, z: float) -> Any:
        return self._make("geometry_msgs/msg/Point", x=x, y=y, z=z)

    def _vector(self, x: float, y: float, z: float) -> Any:
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def _turned(self, rotation: float) -> Any:
        z, w = math.sin(rotation / 2), math.cos(rotation / 2)
        return self._make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w)

    def _make(self, kind: str, **fields: Any) -> Any:
        return self.store.types[kind](**fields)
