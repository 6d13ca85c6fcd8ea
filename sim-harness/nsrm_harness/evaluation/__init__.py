"""Evaluation: metrics, refusals, the detector, manipulation trials, fault injection."""
