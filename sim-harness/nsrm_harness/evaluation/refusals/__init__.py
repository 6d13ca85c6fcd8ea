"""What must be refused: sentences made to be refused, and how many are not."""
