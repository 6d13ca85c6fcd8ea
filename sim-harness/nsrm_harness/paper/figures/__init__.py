"""The paper's figures 2 to 5: its sentences in scenes like its own, carried out unassisted."""
