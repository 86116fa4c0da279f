"""particle-crosscheck: runs particle-simulation engines, compares them with each other and with closed forms, judges.

The road of the data: `scene` -> `engines` -> `checks` -> `verdict` -> `record` -> `report`.
"""

__version__ = "0.1.0"
