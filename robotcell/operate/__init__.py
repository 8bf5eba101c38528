"""A program fed to a robot's controller node by node: states, nodes, handshake, links, and the log of it all."""
