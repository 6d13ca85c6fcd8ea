"""The tabletop: blocks, physics, camera, renderers.

`blocks` → `layout` → `world` (physics) → `render` (pictures) → `camera` (what is seen).
"""
