"""A run as an MCAP file with Foxglove's schemas, which Foxglove opens as a scene.

Each body has a frame. Its shapes are written once, and `/tf` moves the frames.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import foxglove
from foxglove.channels import (
    FrameTransformsChannel,
    LogChannel,
    PoseInFrameChannel,
    PosesInFrameChannel,
    SceneUpdateChannel,
)
from foxglove.mcap import MCAPWriteOptions
from foxglove.messages import (
    ArrowPrimitive,
    Color,
    CubePrimitive,
    CylinderPrimitive,
    Duration,
    FrameTransform,
    FrameTransforms,
    LinePrimitive,
    Log,
    LogLevel,
    Point3,
    Pose,
    PoseInFrame,
    PosesInFrame,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)

from ..core.recorder import Event
from ..record.figures import COSTS
from ..record.outcome import Outcome
from . import scene
from .scene import nanoseconds

_LEVELS = {"info": LogLevel.Info, "warning": LogLevel.Warning, "error": LogLevel.Error}


def write(run: Outcome, path: Path, rate: float) -> None:
    """Write `run` to `path` with `rate` poses per second of every body."""
    context = foxglove.Context()
    # One thread compresses, because several split the data depending on the number of cores.
    options = MCAPWriteOptions(compression_threads=0)
    with path.open("wb") as file:
        sink = _Sink(file)
        with foxglove.open_mcap(sink, context=context, writer_options=options) as mcap:
            mcap.write_metadata("floorwalker", _about(run, rate))
            _Writer(run, context).write(rate)
        if sink.failure is not None:
            raise sink.failure


def _about(run: Outcome, rate: float) -> dict[str, str]:
    summary = {name: value for name, value in run.summary.items() if name not in COSTS}
    return {
        "trial": run.scene.trial,
        "floorplan": run.floorplan.name,
        "rate": f"{rate:g}",
        "summary": json.dumps(summary, ensure_ascii=False),
    }


class _Sink:
    """A file that ignores writes after the disk is full, and keeps the error.

    The SDK prints a line for every message that it cannot write, and raises nothing. After the
    first failure only the position is updated, because the SDK relies on it.
    """

    def __init__(self, file: BinaryIO) -> None:
        self.failure: OSError | None = None
        self._file = file
        self._at = 0
        self._end = 0

    def write(self, data: bytes | bytearray) -> int:
        self._try(lambda: self._file.write(data))
        self._at += len(data)
        self._end = max(self._end, self._at)
        return len(data)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        base = {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._end}[whence]
        self._at = base + offset
        self._try(lambda: self._file.seek(self._at))
        return self._at

    def flush(self) -> None:
        self._try(self._file.flush)

    def _try(self, act: Callable[[], object]) -> None:
        if self.failure is None:
            try:
                act()
            except OSError as why:
                self.failure = why


class _Writer:
    """Channels of one file."""

    def __init__(self, run: Outcome, context: foxglove.Context) -> None:
        people = [person.name for person in run.scene.people]
        self._run = run
        self._floor = SceneUpdateChannel("/floor", context=context)
        self._bodies = SceneUpdateChannel("/bodies", context=context)
        self._violations = SceneUpdateChannel("/violations", context=context)
        self._events = LogChannel("/events", context=context)
        self._frames = FrameTransformsChannel("/tf", context=context)
        self._poses = {
            name: PoseInFrameChannel(f"/{name}/pose", context=context) for name in run.motions
        }
        self._paths = {
            name: PosesInFrameChannel(f"/{name}/way", context=context) for name in people
        }

    def write(self, rate: float) -> None:
        """Write everything in order of time."""
        self._draw(self._floor, scene.floor(self._run), 0.0)
        self._draw(self._bodies, scene.bodies(self._run), 0.0)
        for moment in scene.moments(self._run, rate):
            if moment.event is not None:
                self._write_event(moment.event)
            if moment.path is not None:
                self._write_path(moment.path)
            if moment.poses:
                self._write_poses(moment.t, moment.poses)

    def _draw(
        self,
        channel: SceneUpdateChannel,
        things: list[scene.Thing],
        t: float,
        lifetime: float = 0.0,
    ) -> None:
        entities = [_entity(thing, t, lifetime) for thing in things]
        channel.log(SceneUpdate(entities=entities), log_time=nanoseconds(t))

    def _write_event(self, event: Event) -> None:
        line = scene.line(event)
        message = Log(
            timestamp=_stamp(line.t), level=_LEVELS[line.level], message=line.text, name=line.name
        )
        self._events.log(message, log_time=nanoseconds(line.t))
        if event["kind"] == "violation":
            mark = scene.violation(self._run, event)
            self._draw(self._violations, [mark], line.t, scene.ALARM_TIME)

    def _write_path(self, path: scene.WalkedPath) -> None:
        self._paths[path.person].log(
            PosesInFrame(
                timestamp=_stamp(path.t),
                frame_id=scene.ROOT_FRAME,
                poses=[_pose(*point) for point in path.points],
            ),
            log_time=nanoseconds(path.t),
        )

    def _write_poses(self, t: float, poses: tuple[scene.BodyPose, ...]) -> None:
        stamp, log_time = _stamp(t), nanoseconds(t)
        transforms = [_transform(stamp, *place) for place in scene.frames(self._run, poses)]
        self._frames.log(FrameTransforms(transforms=transforms), log_time=log_time)
        for pose in poses:
            self._poses[pose.body].log(
                PoseInFrame(
                    timestamp=stamp,
                    frame_id=scene.ROOT_FRAME,
                    pose=_pose(pose.x, pose.y, pose.rotation),
                ),
                log_time=log_time,
            )


def _transform(stamp: Timestamp, frame: str, x: float, y: float, rotation: float) -> FrameTransform:
    return FrameTransform(
        timestamp=stamp,
        parent_frame_id=scene.ROOT_FRAME,
        child_frame_id=frame,
        translation=Vector3(x=x, y=y, z=0.0),
        rotation=_turned(rotation),
    )


def _entity(thing: scene.Thing, t: float, lifetime: float) -> SceneEntity:
    entity: dict[str, list[Any]] = {}
    for shape in thing.shapes:
        kind, primitive = _primitive(shape)
        entity.setdefault(kind, []).append(primitive)
    return SceneEntity(
        timestamp=_stamp(t),
        frame_id=thing.frame,
        id=thing.name,
        lifetime=Duration(sec=int(lifetime), nsec=round(lifetime % 1 * 1e9)),
        frame_locked=True,
        **entity,
    )


def _primitive(shape: scene.Shape) -> tuple[str, Any]:
    """Return the field of a SceneEntity for a shape, and its value."""
    color = Color(r=shape.color[0], g=shape.color[1], b=shape.color[2], a=shape.color[3])
    x, y, z = shape.at
    pose, points = _pose(x, y, shape.yaw, z), _points(shape.points)
    size = Vector3(x=shape.size[0], y=shape.size[1], z=shape.size[2])
    if shape.kind == "cube":
        return "cubes", CubePrimitive(pose=pose, size=size, color=color)
    if shape.kind == "cylinder":
        return "cylinders", CylinderPrimitive(
            pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=color
        )
    if shape.kind == "arrow":
        length, shaft, head = shape.size
        return "arrows", ArrowPrimitive(
            pose=pose,
            shaft_length=0.6 * length,
            shaft_diameter=shaft,
            head_length=0.4 * length,
            head_diameter=head,
            color=color,
        )
    if shape.kind == "line":
        return "lines", LinePrimitive(
            pose=pose, thickness=shape.size[0], points=points, color=color
        )
    if shape.kind == "triangles":
        return "triangles", TriangleListPrimitive(pose=pose, points=points, color=color)
    return "texts", TextPrimitive(
        pose=pose, billboard=True, font_size=shape.size[2], color=color, text=shape.text
    )


def _points(points: tuple[scene.Point3, ...]) -> list[Point3]:
    return [Point3(x=x, y=y, z=z) for x, y, z in points]


def _pose(x: float, y: float, rotation: float, z: float = 0.0) -> Pose:
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=_turned(rotation))


def _turned(rotation: float) -> Quaternion:
    return Quaternion(x=0.0, y=0.0, z=math.sin(rotation / 2), w=math.cos(rotation / 2))


def _stamp(t: float) -> Timestamp:
    seconds, rest = divmod(nanoseconds(t), 10**9)
    return Timestamp(sec=seconds, nsec=rest)
