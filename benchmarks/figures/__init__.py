"""The paper's figures from built-in point sets, and pictures for the docs: ``make figures``."""
