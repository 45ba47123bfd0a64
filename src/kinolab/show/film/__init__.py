"""Animations: a small software renderer, and GIF and MP4 files.

A ``Picture`` describes the content, ``staging`` makes a ``Film`` of it, which draws its frames.
"""
