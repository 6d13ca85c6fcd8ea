"""An episode as a recording for Rerun's viewer. Needs `rerun-sdk`, which is loaded by nothing
else."""
