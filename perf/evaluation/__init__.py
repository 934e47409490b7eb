"""The paper's evaluation: every method on the same inputs, measured, tabulated, drawn."""
