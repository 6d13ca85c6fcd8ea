"""How often the arm does what the sentence says: many scenes, judged by the truth."""
