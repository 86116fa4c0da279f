"""Checks of stiff and extreme cases: one declared matrix, case by method, and what each must answer."""
