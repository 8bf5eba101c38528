"""Joint motion for a program: ladder graph, branch tracking, retiming."""
