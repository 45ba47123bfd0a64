"""A gallery page of many runs, each with its interactive page."""

from kinolab.show.page.gallery.gallery_document import Card, gallery_html

__all__ = ["Card", "gallery_html"]
