"""The simulator as a source of images."""

from __future__ import annotations

from nsrm_harness.geometry.camera import Camera
from nsrm_harness.perception.camera_source import RgbdImage
from nsrm_harness.simulation.render import Light, Renderer
from nsrm_harness.simulation.world import World


class SimulatedCamera:
    """A `CameraSource` in a simulated world, with the world's clock."""

    def __init__(self, renderer: Renderer, world: World, camera: Camera) -> None:
        self._renderer, self._world, self._camera = renderer, world, camera

    @property
    def camera(self) -> Camera:
        """The camera's calibration, which is exact."""
        return self._camera

    @property
    def now_s(self) -> float:
        """Simulated seconds."""
        return self._world.time_s

    def take(self) -> RgbdImage:
        """Renders an image of the current world."""
        frame = self._renderer.render(self._world, self._camera, Light())
        return RgbdImage(frame.rgb, frame.depth, self._world.time_s)
