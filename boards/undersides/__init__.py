"""What is beneath a component: gap height, joints and pads."""
