"""Writes the file of a recording atomically."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from nsrm_harness.common.errors import HarnessError
from nsrm_harness.visualization.recording.episode import WORLD
from nsrm_harness.visualization.recording.timeline import TIMELINE
from nsrm_harness.visualization.recording.view import CAMERA, DEPTH

APPLICATION = "nsrm"
SUFFIX = ".rrd"
EYE_M, LOOKS_AT_M = (1.45, 0.7, 0.9), (0.35, 0.0, 0.25)
"""Initial viewpoint of the viewer, which shows table, arm and camera."""


class RecordingError(HarnessError):
    """A recording that cannot be written."""


@contextmanager
def recorded(path: Path) -> Iterator[rr.RecordingStream]:
    """Writes everything logged inside the block to `path` at its end, unless it raises.

    Raises `RecordingError` at once if the file cannot be written.
    """
    if path.suffix != SUFFIX:
        raise RecordingError(f"{path}: the viewer opens only files named *{SUFFIX}: rename it")
    partial = path.with_name(f"{path.name}.part")
    try:
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        path.parent.mkdir(parents=True, exist_ok=True)
        partial.touch()
    except OSError as error:
        raise _unwritable(path, error) from error
    # A failed log call is a bug of ours; by default, Rerun would only warn and omit the data.
    rr.set_strict_mode(True)
    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    try:
        if not stream.is_enabled():
            raise RecordingError("the environment variable RERUN turns recordings off: unset it")
        stream.set_log_time_enabled(False)
        stream.set_log_tick_enabled(False)
        # Not directly to the file: if the disk is full, Rerun's own writer waits for ever.
        memory = stream.memory_recording()
        stream.send_blueprint(_blueprint())
        yield stream
        try:
            partial.write_bytes(memory.drain_as_bytes())
            partial.replace(path)
        except OSError as error:
            raise _unwritable(path, error) from error
    finally:
        stream.disconnect()
        partial.unlink(missing_ok=True)


def _unwritable(path: Path, error: OSError) -> RecordingError:
    return RecordingError(f"{path}: {error.strerror}: use another --record")


def _blueprint() -> rrb.Blueprint:
    """The initial layout of the viewer."""
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(
                    origin=WORLD,
                    contents=["$origin/**", f"- {DEPTH}"],
                    name="scene",
                    eye_controls=rrb.EyeControls3D(
                        position=EYE_M, look_target=LOOKS_AT_M, eye_up=(0.0, 0.0, 1.0)
                    ),
                ),
                rrb.Spatial2DView(origin=CAMERA, name="camera"),
                row_shares=[3, 2],
            ),
            rrb.Vertical(
                rrb.TextDocumentView(origin="plan", name="plan"),
                rrb.TimeSeriesView(origin="distances", name="distances, m"),
                rrb.TimeSeriesView(origin="hand", name="fingers, m"),
                rrb.TimeSeriesView(origin="joints", name="joints, rad/s"),
                rrb.TextLogView(origin="events", name="events"),
            ),
            column_shares=[3, 2],
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
    )
