"""The model against what others published: readings of experiments, and laws where no readings can be had.

``reference`` reads a folder of ``cleaning/library/validation``: what is compared, from where, and what was accepted
before it was run; ``quantities`` predicts it by the functions that an analysis uses; ``compare`` judges.
"""
