"""Files written as a whole or not at all, and the inputs of a program found again."""
