"""The paper's baseline (section V-B): the same data, loss and sizes, without programs.

Attribute words are ordinary words, objects are blended by attention, actions are dense vectors.
`words` splits sentences at the true ends of steps, the help that the paper gives it; `model`,
`train`, `evaluate` and `run_baseline` correspond to modules of `learning`.
"""
