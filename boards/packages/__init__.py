"""Package families: size, height, pins and gap height by package name, and the precedence of gap heights."""
