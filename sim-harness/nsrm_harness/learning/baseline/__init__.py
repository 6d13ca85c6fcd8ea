"""The paper's baseline (section V-B): the same data, loss and sizes, without programs.

Attribute words are words like any other, objects are blended by attention, actions are dense
vectors. `words` cuts sentences where the truth says that a step ends, the help that the paper
gives it; `model`, `train`, `evaluate` and `run` are what they are in `learn`.
"""
