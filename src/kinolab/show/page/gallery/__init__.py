"""Many runs on one page, each with its own interactive page behind it."""

from kinolab.show.page.gallery.gallery_document import Card, gallery_html

__all__ = ["Card", "gallery_html"]
