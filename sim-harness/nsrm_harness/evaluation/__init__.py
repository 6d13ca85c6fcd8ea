"""How good it is: metrics, refusals, the detector, manipulation trials, fault injection."""
