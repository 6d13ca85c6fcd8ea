"""Perception: objects from a colour and a depth image, without the simulator's mask."""

from nsrm_harness.perception.detector import MAX_OBJECTS, Detections, detect
from nsrm_harness.perception.match import match
from nsrm_harness.perception.relief import PerceptionError

__all__ = ["MAX_OBJECTS", "Detections", "PerceptionError", "detect", "match"]
