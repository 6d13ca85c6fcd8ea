"""The demonstration: plans a sentence in a scene, executes it, and draws the result."""
