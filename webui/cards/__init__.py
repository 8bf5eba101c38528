"""Cards about one thing: a component, a stroke, a finding, a gap."""
