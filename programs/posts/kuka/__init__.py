"""KUKA KRL."""
