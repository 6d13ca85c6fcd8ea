"""The demonstration: a scene, a sentence, what the library made of it, and pictures."""
