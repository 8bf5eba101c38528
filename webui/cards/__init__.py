"""Cards about a component, a stroke, findings, the cleaning prediction of a part, and a gap."""
