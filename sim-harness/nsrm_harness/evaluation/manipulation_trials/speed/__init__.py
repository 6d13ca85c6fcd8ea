"""How fast trials of the arm run: by how many workers, and where their time goes."""
