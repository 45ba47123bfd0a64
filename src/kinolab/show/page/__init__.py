"""The interactive page: its content as data, and a self-contained HTML file."""

from kinolab.show.page.content import Content, Curve, Driving, Keys, Series
from kinolab.show.page.document import page_html

__all__ = ["Content", "Curve", "Driving", "Keys", "Series", "page_html"]
