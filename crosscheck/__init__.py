"""particle-crosscheck: runs particle-simulation engines and judges their results by closed forms and by each other.

Data go from `scene` to `engines`, `checks`, `verdict`, `record` and `report`.
"""

__version__ = "0.1.0"
