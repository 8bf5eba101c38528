"""Rules, judgements and the verdict on each component."""
