# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the library and its peers: meshes and tasks, the drivers, the tables and plots of docs/performance.md.

native, peers and report are the drivers; each writes a JSON file that render turns into Markdown and pictures.
"""
