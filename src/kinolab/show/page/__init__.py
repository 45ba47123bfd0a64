"""The interactive page: a self-contained HTML file."""

from kinolab.show.page.document import page_html as page_html
