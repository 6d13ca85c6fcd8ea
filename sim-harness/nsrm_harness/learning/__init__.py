"""Trains a model on demonstrations (initial scene, sentence, final scene) and writes its model
file.

The modules, in the order of the data: `dataset` (episodes to arrays), `model` (the paper's
network), `objective` (loss and choices), `stages` and `train` (the curriculum), `calibrate` (camera
map and thresholds), `export` (the model file), `golden` (golden vectors).
"""
