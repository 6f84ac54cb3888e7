"""``python -m service``: serve with the settings of the environment."""

from __future__ import annotations

from service.app import run

if __name__ == "__main__":
    run()
