"""World, camera, episodes, learning and evaluation around the NSRM library."""
