"""Auditors: short runs in which every event, step or site is looked at, one file for each way to move a scene."""
