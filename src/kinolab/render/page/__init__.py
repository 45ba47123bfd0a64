"""The interactive page: what it shows, as data, and one file of HTML that shows it."""

from kinolab.render.page.content import Content, Curve, Driving, Keys, Series
from kinolab.render.page.html import page_html

__all__ = ["Content", "Curve", "Driving", "Keys", "Series", "page_html"]
