"""The interactive page: what it shows, as data, and one file of HTML that shows it."""

from kinolab.show.page.content import Content, Curve, Driving, Keys, Series
from kinolab.show.page.document import page_html

__all__ = ["Content", "Curve", "Driving", "Keys", "Series", "page_html"]
